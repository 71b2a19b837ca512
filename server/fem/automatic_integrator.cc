#include "server/fem/automatic_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "server/fem/implicit_integrator.h"

namespace kerf::fem {
namespace {

// Nanoseconds on one core of 2024; only their ratios matter. Of the explicit integrator by race_bench (tests/bench), 50
// x 50 vertices in double: 6 regular and 12 irregular, and in mixed precision half of that.
constexpr double kForceNsPerSlot = 9.0;
constexpr double kMixedForceNsPerSlot = 5.0;
constexpr double kForceNsPerBendingEntry = 0.8;
constexpr double kTangentNsPerSlot = 400.0;
constexpr double kProductNsPerBlock = 4.0;
// Of the direct solver: 11 ms of 2,500 vertices, 103 ms of 10,000. Factorisation of a planar mesh of V vertices grows
// as V^1.5 (George 1973, nested dissection).
constexpr double kFactorNsPerVertexToThreeHalves = 100.0;
// Conjugate gradient iterations for sqrt(condition number) 1: block-Jacobi needed 0.25 (stiff) to 1.1 (soft).
constexpr double kIterationsPerRootCondition = 0.6;
constexpr double kPreferenceForExplicit = 2.0;

IntegratorOptions with_kind(IntegratorOptions options, IntegratorKind kind) {
  options.kind = kind;
  return options;
}

double explicit_cost(const Model& model, const ExplicitIntegrator& integrator, const IntegratorOptions& options) {
  const double substeps = integrator.planned_substeps(options.tick);
  const double interval = integrator.bending_interval(options.tick / substeps, 0.0);
  const auto entries = static_cast<double>(model.bending_rows().num_entries());
  const double per_slot = options.precision == Precision::kMixed ? kMixedForceNsPerSlot : kForceNsPerSlot;
  return substeps * (per_slot * model.num_slots() + kForceNsPerBendingEntry * entries / interval);
}

double iterative_cost(const Model& model, const IntegratorOptions& options) {
  const double root_condition = std::sqrt(1.0 + options.tick * options.tick * model.stiffness_bound());
  const double iterations =
      std::min(kIterationsPerRootCondition * root_condition, static_cast<double>(options.max_linear_iterations));
  const double blocks = std::max(static_cast<double>(model.bending_rows().num_entries()), 7.0 * model.num_vertices());
  return options.newton_iterations * (kTangentNsPerSlot * model.num_slots() + iterations * kProductNsPerBlock * blocks);
}

double direct_cost(const Model& model, const IntegratorOptions& options) {
  const double V = model.num_vertices();
  return options.newton_iterations *
         (kTangentNsPerSlot * model.num_slots() + kFactorNsPerVertexToThreeHalves * V * std::sqrt(V));
}

}  // namespace

AutomaticIntegrator::AutomaticIntegrator(const IntegratorOptions& options)
    : options_(options), explicit_(with_kind(options, IntegratorKind::kExplicit)) {}

IntegratorKind AutomaticIntegrator::kind() const {
  return implicit_ ? implicit_->kind() : explicit_.kind();
}

StepStats AutomaticIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                    State& state) {
  return chosen().step(model, loads, dt, contact, state);
}

void AutomaticIntegrator::rebuild(const Model& model) {
  choose(model);
  chosen().rebuild(model);
}

void AutomaticIntegrator::follow(const Model& model) {
  if (choose(model)) {
    chosen().rebuild(model);
  } else {
    chosen().follow(model);
  }
}

bool AutomaticIntegrator::choose(const Model& model) {
  explicit_.plan(model);
  const double substeps = explicit_.planned_substeps(options_.tick);
  const double of_explicit = explicit_cost(model, explicit_, options_);
  const double of_iterative = iterative_cost(model, options_);
  const double of_direct = direct_cost(model, options_);
  const double of_implicit = std::min(of_iterative, of_direct);
  const bool use_explicit = substeps <= options_.max_substeps && of_explicit <= kPreferenceForExplicit * of_implicit;
  const char* choice = "explicit";
  bool is_new = false;
  if (use_explicit) {
    is_new = implicit_ != nullptr;
    implicit_.reset();
  } else {
    const bool direct = of_direct <= of_iterative;
    choice =
        direct ? "implicit Euler, direct solver" : "implicit Euler, block-Jacobi-preconditioned conjugate gradients";
    IntegratorOptions options = with_kind(options_, IntegratorKind::kImplicitEuler);
    options.linear_solver = direct ? LinearSolverKind::kDirect : LinearSolverKind::kBlockJacobiCg;
    is_new = !implicit_ || options.linear_solver != solver_;
    solver_ = options.linear_solver;
    if (is_new) implicit_ = std::make_unique<ImplicitIntegrator>(options);
  }
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "automatic: %s; estimated per tick of %.4g s: %.0f explicit substeps %.1f ms, implicit with conjugate "
                "gradients %.1f ms, with the direct solver %.1f ms",
                choice, options_.tick, substeps, of_explicit * 1e-6, of_iterative * 1e-6, of_direct * 1e-6);
  explanation_ = text.data();
  return is_new;
}

}  // namespace kerf::fem
