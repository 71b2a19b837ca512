#include "server/fem/automatic_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "server/fem/implicit_integrator.h"

namespace kerf::fem {
namespace {

// Nanoseconds on one core of 2024; only their ratios matter. Fitted to ticks of wool of 225 to 10,000 vertices before
// and after a cut (tests/accuracy/plots/measure.py size, one hour): within an eighth from 900 vertices on, a quarter
// too low at 277. What a substep goes through and a cache does not hold is dearer: fitted to 10,000 to 160,000
// vertices, and 90,000 with bending in each substep.
struct ExplicitCost {
  double per_slot;
  double per_bending_entry;
};
constexpr ExplicitCost kDoubleNs{4.2, 0.42};
constexpr ExplicitCost kMixedNs{2.0, 0.2};
constexpr double kBytesPerSlot = 37.0;
constexpr double kBytesPerBendingEntry = 8.0;
constexpr double kCacheBytes = 15e6;        // of which going through them costs as much again as working with them
constexpr double kNsPerClusterEntry = 2.0;  // of a factor below its diagonal
constexpr double kNsPerClusterVertex = 40.0;
constexpr double kTangentNsPerSlot = 400.0;
// Factor and solve of a Newton iteration: 12 ms of 2,500 vertices. Factorisation of a planar mesh of V vertices grows
// as V^1.5 (George 1973, nested dissection). One in float is kept while it serves, which is for the longer the more it
// costs: measured 44, 50, 35, 21 ns V^1.5 of 2,500, 10,000, 40,000 and 90,000.
constexpr double kDirectNsPerVertexToThreeHalves = 100.0;
constexpr double kFactorCgNsPerVertexToThreeHalves = 45.0;
constexpr double kMostToThreeHalves = 20'000.0;  // vertices: beyond, a factor in float that is kept grows as V
constexpr double kStages = 2.0;                  // of TR-BDF2
constexpr double kPreferenceForExplicit = 2.0;
constexpr double kPreferenceWithClusters = 1.0;  // stiff sheets after cuts, which should not become slower by them
constexpr double kSecondOrderCondition = 1e9;    // 1 + dt^2 lambda_max
constexpr int kLeastForFactorCg = 2000;          // vertices: below, a factor in double takes no longer

IntegratorOptions with_kind(IntegratorOptions options, IntegratorKind kind) {
  options.kind = kind;
  return options;
}

// In which the explicit integrator makes most of its steps.
Precision usual_precision(const Model& model, const IntegratorOptions& options) {
  return LeapfrogSweep<float>::may_hold(model) ? options.precision : Precision::kDouble;
}

double explicit_cost(const Model& model, const ExplicitIntegrator& integrator, Precision precision, double tick) {
  const double substeps = integrator.planned_substeps(tick);
  const double interval = integrator.bending_interval(tick / substeps, 0.0);
  const auto entries = static_cast<double>(model.bending_rows().num_entries());
  const ExplicitCost ns = precision == Precision::kMixed ? kMixedNs : kDoubleNs;
  const double bytes = kBytesPerSlot * model.num_slots() + kBytesPerBendingEntry * entries / interval;
  const LocalInertia& inertia = integrator.inertia();
  const double of_clusters = kNsPerClusterEntry * static_cast<double>(inertia.num_entries()) +
                             kNsPerClusterVertex * static_cast<double>(inertia.num_vertices());
  return substeps *
         ((1.0 + bytes / kCacheBytes) * (ns.per_slot * model.num_slots() + ns.per_bending_entry * entries / interval) +
          of_clusters);
}

LinearSolverKind implicit_solver(const Model& model) {
  return model.num_vertices() >= kLeastForFactorCg ? LinearSolverKind::kFactorCg : LinearSolverKind::kDirect;
}

double implicit_cost(const Model& model, const IntegratorOptions& options) {
  const double V = model.num_vertices();
  const bool is_kept = implicit_solver(model) == LinearSolverKind::kFactorCg;
  const double per_factor = is_kept ? kFactorCgNsPerVertexToThreeHalves * V * std::sqrt(std::min(V, kMostToThreeHalves))
                                    : kDirectNsPerVertexToThreeHalves * V * std::sqrt(V);
  return kStages * options.newton_iterations * (kTangentNsPerSlot * model.num_slots() + per_factor);
}

// Estimates with explicit steps already planned, as kAutomatic takes them.
TickEstimate estimate_planned(const Model& model, const ExplicitIntegrator& planned, const IntegratorOptions& options) {
  TickEstimate estimate;
  estimate.substeps = planned.planned_substeps(options.tick);
  estimate.explicit_ns = explicit_cost(model, planned, usual_precision(model, options), options.tick);
  estimate.implicit_ns = implicit_cost(model, options);
  const double preference = planned.inertia().empty() ? kPreferenceForExplicit : kPreferenceWithClusters;
  estimate.is_explicit =
      estimate.substeps <= options.max_substeps && estimate.explicit_ns <= preference * estimate.implicit_ns;
  return estimate;
}

}  // namespace

TickEstimate estimate_tick(const Model& model, const IntegratorOptions& options) {
  ExplicitIntegrator planned(with_kind(options, IntegratorKind::kExplicit));
  planned.plan(model, false);
  TickEstimate estimate = estimate_planned(model, planned, options);
  if (options.kind != IntegratorKind::kAutomatic) estimate.is_explicit = options.kind == IntegratorKind::kExplicit;
  return estimate;
}

AutomaticIntegrator::AutomaticIntegrator(const IntegratorOptions& options)
    : options_(options), explicit_(with_kind(options, IntegratorKind::kExplicit)) {}

IntegratorKind AutomaticIntegrator::kind() const {
  return implicit_ ? implicit_->kind() : explicit_.kind();
}

StepStats AutomaticIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                    State& state) {
  chosen().heed(heed_.get());
  return chosen().step(model, loads, dt, contact, state);
}

void AutomaticIntegrator::rebuild(const Model& model) {
  choose(model, false);
  implicit_ ? implicit_->rebuild(model) : explicit_.set_up(model, false);
}

void AutomaticIntegrator::follow(const Model& model) {
  const bool is_other = choose(model, true);
  if (!implicit_) return explicit_.set_up(model, !is_other);
  is_other ? implicit_->rebuild(model) : implicit_->follow(model);
}

bool AutomaticIntegrator::choose(const Model& model, bool follows) {
  explicit_.plan(model, follows);
  const TickEstimate estimate = estimate_planned(model, explicit_, options_);
  const double condition = 1.0 + options_.tick * options_.tick * model.stiffness_bound();
  const IntegratorKind before = kind();
  std::string_view scheme = "explicit";
  std::string_view solver;
  bool is_other = before != IntegratorKind::kExplicit;
  if (estimate.is_explicit) {
    implicit_.reset();
  } else {
    const bool is_second_order = condition <= kSecondOrderCondition;
    IntegratorOptions options =
        with_kind(options_, is_second_order ? IntegratorKind::kTrBdf2 : IntegratorKind::kImplicitEuler);
    options.linear_solver = is_second_order ? implicit_solver(model) : LinearSolverKind::kDirect;
    scheme = is_second_order ? "TR-BDF2, " : "implicit Euler, ";
    solver = name_of(options.linear_solver).description;
    is_other = options.kind != before || options.linear_solver != solver_;
    solver_ = options.linear_solver;
    if (is_other) implicit_ = std::make_unique<ImplicitIntegrator>(options);
  }
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "; estimated per tick of %.4g s: %.0f explicit substeps in %s precision %.1f ms, TR-BDF2, %s %.1f ms%s",
                options_.tick, estimate.substeps,
                usual_precision(model, options_) == Precision::kMixed ? "mixed" : "double", estimate.explicit_ns * 1e-6,
                name_of(implicit_solver(model)).description.data(), estimate.implicit_ns * 1e-6,
                condition <= kSecondOrderCondition ? "" : " (not solved well at a condition above 1e9)");
  explanation_ = "automatic: ";
  explanation_.append(scheme).append(solver).append(text.data());
  return is_other;
}

}  // namespace kerf::fem
