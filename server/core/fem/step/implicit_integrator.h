#pragma once

#include <string>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/self_contact_correction.h"
#include "server/core/fem/step/stage_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Estimates the cost of a tick with these options, whose kind is implicit, after a tick like `last`.
TickCost implicit_cost(const Model& model, const IntegratorOptions& options, const TickCounts& last);

// Implicit Euler, TR-BDF2, SDIRK2 and the trapezoidal rule, with one substep a step. Both stages of TR-BDF2 share one
// d = gamma h / 2, with gamma = 2 - sqrt 2 (Bank et al. 1985). Those of SDIRK2 are implicit Euler's at first, with the
// same d = (1 - 1 / sqrt 2) h (Alexander 1977). BDF2 has kBdf2Substeps. A step fails if it finds no finite solution or
// ends with too much energy (see EnergyGuard). A failed step is discarded and repeated:
//   - A step of second order becomes an implicit Euler step, which damps. It is not repaired before: it fails as soon
//     as the fast iteration of StageSolver does.
//   - An implicit Euler step is made in twice the substeps.
//   - If no number of substeps succeeds, one linear step on a bound of the energy replaces them
//     (StageSolver::solve_majorized). It cannot gain energy, but damps far more.
//   - If no such bound exists, as with contact (StageSolver::can_majorize), the last attempt is accepted after
//     EnergyGuard has stopped the sheet.
// Contact of the sheet with itself corrects the end of each substep.
// Wind drag is evaluated at the start of each substep, everything else at its end.
class ImplicitIntegrator final : public Integrator {
 public:
  // options.kind must be neither kAutomatic nor kExplicit.
  explicit ImplicitIntegrator(const IntegratorOptions& options);

  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  void prepare() override { solver_.prepare(); }
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override { return options_.kind; }
  [[nodiscard]] TickCost expected_cost(const Model& model, double /*dt*/, const TickCounts& last) const override {
    return implicit_cost(model, options_, last);
  }

 private:
  struct Scratch {
    State start;  // of the step
    State substep_start;
    State before;                        // from which BDF2 and the second stage of TR-BDF2 extrapolate
    linear::VertexField force;           // 3 x V, N
    linear::VertexField constant;        // 3 x V, N: external forces and wind
    linear::VertexField damped;          // 3 x V, m, scratch of BendingOperator::add_forces
    linear::VertexField before_contact;  // m, start of the substep, for self-contact
    Stage stage;
  };

  struct Attempt {
    IntegratorKind kind;
    int substeps;
    bool is_majorized = false;  // the whole step in one solve of StageSolver::solve_majorized
  };
  struct Substep {
    IntegratorKind kind;
    int index = 0;           // from 0
    double h = 0.0;          // s
    double time_left = 0.0;  // s, from the end of the substep to the end of the step
    bool is_majorized = false;
  };

  void resize(const Model& model);
  [[nodiscard]] int num_attempts() const {
    return options_.max_halvings + (options_.kind == IntegratorKind::kImplicitEuler ? 1 : 2);
  }
  // Returns the attempt that follows `failures` failed ones of the same step. After num_attempts() failures it is the
  // majorised one, see kMajorized. After more failures it is the last attempt before that one again.
  [[nodiscard]] Attempt attempt_after(int failures) const;
  bool try_step(const Model& model, const Loads& loads, const Attempt& attempt, double dt, ContactConstraint* contact,
                State& state, StepStats& stats);
  // Number of substeps in the first attempt at a step.
  [[nodiscard]] int num_substeps() const { return options_.kind == IntegratorKind::kBdf2 ? kBdf2Substeps : 1; }
  void touch_itself(const Model& model, const Loads& loads, double h, ContactConstraint& contact, State& state,
                    StepStats& stats);
  bool keep_energy(const Model& model, const Loads& loads, IntegratorKind kind, State& state, StepStats& stats) const;
  bool advance(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  void set_ballistic(const State& start, double t, double t2, const Eigen::Vector3d& gravity);
  void forget_stopped(const linear::VertexField& x);
  void begin_trapezoidal(const Model& model, const Loads& loads, double time_left, const State& start);
  void begin_euler(const Model& model, const Loads& loads, const State& start);
  bool advance_euler(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  bool advance_tr_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  bool advance_sdirk2(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  bool advance_last(const Model& model, const Loads& loads, const Substep& substep, double now, double old,
                    State& state, StepStats& stats);
  bool advance_trapezoidal(const Model& model, const Loads& loads, const Substep& substep, State& state,
                           StepStats& stats);
  bool advance_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  void evaluate_constant_force(const Model& model, const Loads& loads, double h, const State& state, StepStats& stats);
  // Sets scratch_.force to the acceleration at `state`, m/s^2, 0 where the mass is 0.
  void evaluate_acceleration(const Model& model, const Loads& loads, double time_left, const State& state);

  IntegratorOptions options_;
  std::string explanation_;
  StageSolver solver_;
  Scratch scratch_;
  SelfContactCorrection self_contact_;
};

}  // namespace kerf::fem
