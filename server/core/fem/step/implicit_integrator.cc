#include "server/core/fem/step/implicit_integrator.h"

#include <algorithm>
#include <cmath>

#include "server/base/check.h"
#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/energy_guard.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"

namespace kerf::fem {
namespace {

// Returns `allowed_gain` of EnergyGuard::enforce. The tolerance of solves may leave a gain of 1e-7 in a step; even a
// thousand such steps stay within 1e-4. The energy of the trapezoidal rule, which does not damp, swings further.
double allowed_gain(IntegratorKind kind) {
  return kind == IntegratorKind::kTrapezoidal ? 1e-2 : 1e-7;
}

std::string_view describe_scheme(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::kTrBdf2:
      return "implicit: TR-BDF2, one step a tick";
    case IntegratorKind::kTrapezoidal:
      return "implicit: trapezoidal rule, one step a tick";
    case IntegratorKind::kBdf2:
      return "implicit: BDF2, four steps a tick, the first of the trapezoidal rule";
    case IntegratorKind::kSdirk2:
      return "implicit: SDIRK2, one step a tick";
    default:
      return "implicit: Euler, one step a tick";
  }
}

// s, longest substep in which the sheet touches itself. Contact stops single vertices while others move, and nothing
// pulls on them before the next substep: the strain grows with the length of substeps.
constexpr double kMostWithSelfContact = 1.0 / 240.0;

int num_solves(IntegratorKind kind) {
  switch (kind) {
    case IntegratorKind::kTrBdf2:
    case IntegratorKind::kSdirk2:
      return 2;
    case IntegratorKind::kBdf2:
      return kBdf2Substeps;
    default:
      return 1;
  }
}

SystemSolver kind_of(linear::LinearSolverKind solver) {
  switch (solver) {
    case linear::LinearSolverKind::kDirect:
      return SystemSolver::kDirect;
    case linear::LinearSolverKind::kFactorCg:
      return SystemSolver::kKeptFactor;
    default:
      return SystemSolver::kIterative;
  }
}

}  // namespace

TickCost implicit_cost(const Model& model, const IntegratorOptions& options, const TickCounts& last) {
  return cost_of(ImplicitCounts{.most_newton_iterations = 1.0 * num_solves(options.kind) * options.newton_iterations,
                                .vertices = static_cast<double>(model.num_vertices()),
                                .slots = static_cast<double>(model.num_slots()),
                                .solver = kind_of(options.linear_solver)},
                 last);
}

ImplicitIntegrator::ImplicitIntegrator(const IntegratorOptions& options)
    : options_(options),
      explanation_(std::string(describe_scheme(options.kind)) + "; " +
                   std::string(linear::name_of(options.linear_solver).description)),
      solver_(options) {
  KERF_CHECK(options.kind != IntegratorKind::kAutomatic && options.kind != IntegratorKind::kExplicit,
             "an implicit kind");
}

void ImplicitIntegrator::rebuild(const Model& model) {
  solver_.rebuild(model);
  resize(model);
}

void ImplicitIntegrator::follow(const Model& model) {
  solver_.follow(model);
  resize(model);
}

void ImplicitIntegrator::resize(const Model& model) {
  for (linear::VertexField* field :
       {&scratch_.start.x, &scratch_.start.v, &scratch_.substep_start.x, &scratch_.substep_start.v, &scratch_.before.x,
        &scratch_.before.v, &scratch_.force, &scratch_.constant, &scratch_.damped, &scratch_.stage.base.x,
        &scratch_.stage.base.v, &scratch_.stage.ballistic}) {
    field->resize(model.num_vertices());
  }
}

StepStats ImplicitIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                   State& state) {
  KERF_CHECK(state.x.cols() == scratch_.force.cols() && model.num_vertices() == scratch_.force.cols(),
             "rebuild() was called for this model");
  StepStats stats;
  scratch_.start.x = state.x;
  scratch_.start.v = state.v;
  const bool has_bodies = contact != nullptr && contact->has_bodies();
  scratch_.stage.contact = has_bodies ? contact : nullptr;
  solver_.set_stop_condition(stop_.get());
  bool done = false;
  const int last = num_attempts() + (!has_bodies && StageSolver::can_majorize(model, loads) ? 1 : -1);
  const int for_contact = static_cast<int>(std::ceil(dt / kMostWithSelfContact - 1e-9));
  int least = 1;  // substeps
  for (int i = 0; i <= last && !done; ++i) {
    Attempt attempt = attempt_after(i);
    attempt.substeps = std::max(attempt.substeps, least);
    stats.flags &= ~(kSubstepped | kMajorized);
    if (attempt.is_majorized) stats.flags |= kMajorized;
    if (attempt.kind != options_.kind) stats.flags |= kDamped;
    if (attempt.substeps > num_substeps()) stats.flags |= kSubstepped;
    done = try_step(model, loads, attempt, dt, contact, state, stats);
    if (stop_.is_met()) {
      state.x = scratch_.start.x;
      state.v = scratch_.start.v;
      stats = {};
      stats.interrupted = true;
      return stats;
    }
    if (done && (stats.flags & kSplitContact) != 0 && attempt.substeps < for_contact) {
      least = for_contact;
      done = false;
      --i;
    }
    const bool is_taken = i == last || attempt.is_majorized;  // taken even if it ends with too much energy
    // Repairs of contact may strain the sheet, which is no fault of the solve.
    if (done && !has_bodies && (stats.flags & kSplitContact) == 0)
      done = keep_energy(model, loads, attempt.kind, state, stats) || is_taken;
    if (done) break;
    stats.flags &= ~(kEnergyLimited | kNotConverged | kSplitContact);  // clears the flags of the discarded attempt
    state.x = scratch_.start.x;
    state.v = scratch_.start.v;
  }
  if (!done) {
    stats.flags |= kFrozen;
    stats.substeps = 0;
    return stats;
  }
  stats.simulated = dt;
  const StrainExtent strain = measure_strain(model.element_blocks(), model.materials(), state.x);
  stats.max_strain = strain.largest;
  stats.strained_share = strain.beyond_limit;
  if (contact != nullptr && contact->num_inside() > 0) stats.flags |= kInsideBody;
  return stats;
}

ImplicitIntegrator::Attempt ImplicitIntegrator::attempt_after(int failures) const {
  if (failures == num_attempts()) return {IntegratorKind::kImplicitEuler, 1, true};
  failures = std::min(failures, num_attempts() - 1);
  if (failures == 0 || options_.kind == IntegratorKind::kImplicitEuler) {
    return {options_.kind, num_substeps() << failures};
  }
  return {IntegratorKind::kImplicitEuler, num_substeps() << (failures - 1)};
}

bool ImplicitIntegrator::try_step(const Model& model, const Loads& loads, const Attempt& attempt, double dt,
                                  ContactConstraint* contact, State& state, StepStats& stats) {
  solver_.reset();
  const double h = dt / attempt.substeps;
  stats.residual = 0.0;
  stats.linear_residual = 0.0;
  stats.substeps = attempt.substeps;
  scratch_.stage.may_repair = attempt.kind == IntegratorKind::kImplicitEuler;
  if (contact != nullptr) contact->begin(state.x);
  const bool touches_itself = contact != nullptr && contact->touches_itself();
  for (int i = 1; i <= attempt.substeps; ++i) {
    const double time_left = i == attempt.substeps ? 0.0 : dt - h * i;
    const Substep substep{attempt.kind, i - 1, h, time_left, attempt.is_majorized};
    if (touches_itself) scratch_.before_contact = state.x;
    if (!advance(model, loads, substep, state, stats)) return false;
    if (scratch_.stage.contact != nullptr) contact->enforce(h, state);
    if (touches_itself && is_finite(state)) touch_itself(model, loads, h, *contact, state, stats);
    if (!is_finite(state)) return false;
  }
  return true;
}

// Corrects the end of a substep by contact of the sheet with itself.
void ImplicitIntegrator::touch_itself(const Model& model, const Loads& loads, double h, ContactConstraint& contact,
                                      State& state, StepStats& stats) {
  if (!self_contact_.correct(model, loads, h, scratch_.before_contact, contact, state.x)) return;
  stats.flags |= kSplitContact;
  linear::VertexField& change = self_contact_.change();
  // Vertices that a body has stopped move no more, though their way shows how they did before.
  if (contact.has_bodies()) solver_.stop_in_contact(change);
  state.v += change;
  scratch_.before.v += change;
  contact.end_self_contact(state);
}

// Limits the energy of `state`. Returns false if it was exceeded so far that another attempt may do better.
bool ImplicitIntegrator::keep_energy(const Model& model, const Loads& loads, IntegratorKind kind, State& state,
                                     StepStats& stats) const {
  const EnergyGuard::Verdict verdict =
      EnergyGuard::enforce(model, loads, nullptr, allowed_gain(kind), scratch_.start, state);
  if (verdict != EnergyGuard::Verdict::kKept) stats.flags |= kEnergyLimited;
  return verdict != EnergyGuard::Verdict::kExceeded;
}

}  // namespace kerf::fem
