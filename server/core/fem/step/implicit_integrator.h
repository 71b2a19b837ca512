#pragma once

#include <string>

#include "server/core/fem/step/integrator.h"
#include "server/core/fem/step/stage_solver.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Counts a tick of steps by these options, whose kind is an implicit one, after a tick like `last`.
TickCost implicit_cost(const Model& model, const IntegratorOptions& options, const TickCounts& last);

// Implicit Euler, TR-BDF2 (Bank et al. 1985, gamma = 2 - sqrt 2: both stages share one d = gamma h / 2), the
// trapezoidal rule, all of one substep a step, or BDF2 of kBdf2Substeps. A step that finds no finite solution, or ends
// with too much energy (see EnergyGuard), is thrown away: one of second order, where its fast iteration failed too, is
// made by implicit Euler, which damps, and one of implicit Euler in twice the substeps. Where no number of them does,
// one linear step on a bound of the energy takes their place (StageSolver::solve_majorized), which cannot gain any, but
// damps far more; where that does not hold, with contact among others, the last attempt is taken, stopped by the guard.
// Wind drag is taken at the start of each substep, everything else at its end.
class ImplicitIntegrator final : public Integrator {
 public:
  // options.kind: neither kAutomatic nor kExplicit.
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
    State before;                // where the substep before began; BDF2 alone
    mesh::VertexField force;     // 3 x V, N
    mesh::VertexField constant;  // 3 x V, N: external forces and wind
    mesh::VertexField damped;    // 3 x V, m
    Stage stage;
  };

  struct Attempt {
    IntegratorKind kind;
    int substeps;
    bool is_majorized = false;  // the whole step at once
  };
  struct Substep {
    IntegratorKind kind;
    int index = 0;           // from 0
    double h = 0.0;          // s
    double time_left = 0.0;  // s, of the step after it
    bool is_majorized = false;
  };

  void resize(const Model& model);
  [[nodiscard]] int num_attempts() const {
    return options_.max_halvings + (options_.kind == IntegratorKind::kImplicitEuler ? 1 : 2);
  }
  // After the last of num_attempts() the majorised one; should that fail, the last once more.
  [[nodiscard]] Attempt attempt_after(int failures) const;
  bool try_step(const Model& model, const Loads& loads, const Attempt& attempt, double dt, ContactConstraint* contact,
                State& state, StepStats& stats);
  // How many substeps a step has before it is divided.
  [[nodiscard]] int num_substeps() const { return options_.kind == IntegratorKind::kBdf2 ? kBdf2Substeps : 1; }
  bool keep_energy(const Model& model, const Loads& loads, IntegratorKind kind, State& state, StepStats& stats) const;
  bool advance(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  void set_ballistic(const State& start, double t, double t2, const Eigen::Vector3d& gravity);
  void begin_trapezoidal(const Model& model, const Loads& loads, double time_left, const State& start);
  bool advance_euler(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  bool advance_tr_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  bool advance_trapezoidal(const Model& model, const Loads& loads, const Substep& substep, State& state,
                           StepStats& stats);
  bool advance_bdf2(const Model& model, const Loads& loads, const Substep& substep, State& state, StepStats& stats);
  void evaluate_constant_force(const Model& model, const Loads& loads, double h, const State& state, StepStats& stats);
  // Into scratch_.force: acceleration at `state`, m/s^2, 0 where the mass is 0.
  void evaluate_acceleration(const Model& model, const Loads& loads, double time_left, const State& state);

  IntegratorOptions options_;
  std::string explanation_;
  StageSolver solver_;
  Scratch scratch_;
};

}  // namespace kerf::fem
