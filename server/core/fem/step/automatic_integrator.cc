#include "server/core/fem/step/automatic_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/implicit_integrator.h"

namespace kerf::fem {
namespace {

// -, cost of explicit steps over that of TR-BDF2 up to which explicit steps are chosen. At equal cost they are by far
// the more accurate. With clusters the limit is lower, so that cuts do not make stiff sheets slower.
struct Preference {
  double without_clusters;
  double with_clusters;
};
constexpr Preference kFirstPreference{4.0, 1.5};
// Allows more without clusters: with ratios of 4 to 5, slits of kirigami took 0.6 to 0.9 of the time of TR-BDF2
// (tests/evaluation/speed.md). The limit with clusters is for estimates that count all iterations.
constexpr Preference kSecondPreference{6.0, 1.0};
// The same for a sheet that touches itself: implicit steps only correct their ends, and contact takes most of the time.
constexpr double kPreferenceWithSelfContact = 20.0;
constexpr double kConditionOfTrBdf2 = 1e9;  // -, largest condition number 1 + dt^2 lambda_max for TR-BDF2
constexpr int kLeastForFactorCg = 2000;     // vertices; for fewer a factor in double precision is as fast
// Solves of cut sheets need that many: slivers converge last, and a solve that stops early throws them. Others converge
// sooner, and stop.
constexpr int kLeastNewtonIterations = 5;

IntegratorOptions with_kind(IntegratorOptions options, IntegratorKind kind) {
  options.kind = kind;
  return options;
}

linear::LinearSolverKind implicit_solver(const Model& model) {
  return model.num_vertices() >= kLeastForFactorCg ? linear::LinearSolverKind::kFactorCg
                                                   : linear::LinearSolverKind::kDirect;
}

IntegratorOptions with_tr_bdf2(const Model& model, const IntegratorOptions& options) {
  IntegratorOptions of_stages = with_kind(options, IntegratorKind::kTrBdf2);
  of_stages.linear_solver = implicit_solver(model);
  return of_stages;
}

// Returns the condition number of implicit steps, 1 + dt^2 lambda_max.
double condition_number(const Model& model, double tick) {
  return 1.0 + tick * tick * model.stiffness_bound().value();
}

// Returns the options of the implicit steps that kAutomatic takes at this condition number.
IntegratorOptions implicit_options(const Model& model, const IntegratorOptions& options, double condition) {
  const bool is_first = options.choice == AutomaticChoice::kFirst;
  IntegratorOptions chosen = with_tr_bdf2(model, options);
  if (condition > kConditionOfTrBdf2) {
    chosen.kind = is_first ? IntegratorKind::kImplicitEuler : IntegratorKind::kSdirk2;
    chosen.linear_solver = linear::LinearSolverKind::kDirect;
  }
  if (!is_first) chosen.newton_iterations = std::max(chosen.newton_iterations, kLeastNewtonIterations);
  return chosen;
}

// Returns the options of the implicit steps whose cost is compared with that of explicit ones.
IntegratorOptions priced_options(const Model& model, const ExplicitIntegrator& planned,
                                 const IntegratorOptions& options) {
  // Solves without clusters converge within the iterations asked for; cut sheets need all that they may make. The limit
  // with self-contact was found with the former.
  const bool counts_all =
      options.choice != AutomaticChoice::kFirst && !planned.inertia().empty() && !options.touches_itself;
  return counts_all ? implicit_options(model, options, condition_number(model, options.tick))
                    : with_tr_bdf2(model, options);
}

// Estimates a tick and makes the choice of kAutomatic. `planned` has planned explicit steps for the model.
TickEstimate estimate_planned(const Model& model, const ExplicitIntegrator& planned, const IntegratorOptions& options) {
  TickEstimate estimate;
  estimate.substeps = planned.planned_substeps(options.tick);
  estimate.explicit_ns = planned.expected_cost(model, options.tick, {}).total();
  const bool is_first = options.choice == AutomaticChoice::kFirst;
  estimate.implicit_ns = implicit_cost(model, priced_options(model, planned, options), {}).total();
  const Preference& preferred = is_first ? kFirstPreference : kSecondPreference;
  const double preference = options.touches_itself      ? kPreferenceWithSelfContact
                            : planned.inertia().empty() ? preferred.without_clusters
                                                        : preferred.with_clusters;
  const bool fits = !is_first && estimate.explicit_ns <= 1e9 * kShareOfTick * options.tick;
  estimate.is_explicit =
      estimate.substeps <= options.max_substeps && (fits || estimate.explicit_ns <= preference * estimate.implicit_ns);
  return estimate;
}

std::string_view name_of(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::kTrBdf2:
      return "TR-BDF2, ";
    case IntegratorKind::kSdirk2:
      return "SDIRK2, ";
    default:
      return "implicit Euler, ";
  }
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

TickCost AutomaticIntegrator::expected_cost(const Model& model, double dt, const TickCounts& last) const {
  if (!implicit_) return explicit_.expected_cost(model, dt, last);
  IntegratorOptions counted = with_kind(priced_options(model, explicit_, options_), implicit_->kind());
  counted.linear_solver = solver_;
  return implicit_cost(model, counted, last);
}

StepStats AutomaticIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                    State& state) {
  chosen().set_stop_condition(stop_.get());
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
  const double condition = condition_number(model, options_.tick);
  const IntegratorKind before = kind();
  std::string_view scheme = options_.touches_itself ? "explicit, preferred for self-contact" : "explicit";
  std::string_view solver;
  bool is_other = before != IntegratorKind::kExplicit;
  if (estimate.is_explicit) {
    implicit_.reset();
  } else {
    const IntegratorOptions options = implicit_options(model, options_, condition);
    scheme = name_of(options.kind);
    solver = linear::name_of(options.linear_solver).description;
    is_other = options.kind != before || options.linear_solver != solver_;
    solver_ = options.linear_solver;
    if (is_other) implicit_ = std::make_unique<ImplicitIntegrator>(options);
  }
  const bool is_mixed = options_.precision == Precision::kMixed && LeapfrogSweep<float>::may_hold(model);
  const IntegratorOptions priced = priced_options(model, explicit_, options_);
  const char* precision = is_mixed ? "mixed" : "double";
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "; estimated per tick of %.4g s: %.0f explicit substeps in %s precision %.1f ms, %s%s %.1f ms%s",
                options_.tick, estimate.substeps, precision, estimate.explicit_ns * 1e-6, name_of(priced.kind).data(),
                linear::name_of(priced.linear_solver).description.data(), estimate.implicit_ns * 1e-6,
                condition <= kConditionOfTrBdf2 || priced.kind != IntegratorKind::kTrBdf2
                    ? ""
                    : " (inaccurate at a condition number above 1e9)");
  explanation_ = "automatic: ";
  explanation_.append(scheme).append(solver).append(text.data());
  return is_other;
}

}  // namespace kerf::fem
