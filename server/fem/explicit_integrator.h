#pragma once

#include <string>
#include <vector>

#include "server/fem/integrator.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

// Velocity Verlet in leapfrog form: half kick, then {drift, force, full kick}, the last kick half again, so that a step
// begins and ends with x and v at one time. Second order, symplectic, conserves linear and angular momentum to
// round-off where no load acts.
//
// Substep: h = dt / ceil(dt / (cfl h_crit)), h_crit = 2 / omega (sqrt(1 + xi^2) - xi), omega^2 =
// Model::stiffness_bound(); Kelvin-Voigt damping beta = 2 xi / omega with xi between highest_mode_damping and
// kMaxModeDamping, whichever lets the material's own stiffness_damping through; of several materials each has its xi,
// and the largest bounds the step: with K and C the sums of the elements' stiffness and damping and any mode of the
// step, u.C u <= beta_max u.K u. Mass damping by the midpoint rule. Contact is enforced after each drift, in the last
// substep after the closing kick, so that what leaves the step respects it.
class ExplicitIntegrator final : public Integrator {
 public:
  // Damping ratio of the fastest mode, -, above which the stable step shrinks faster than damping is worth.
  static constexpr double kMaxModeDamping = 0.3;

  explicit ExplicitIntegrator(const IntegratorOptions& options) : options_(options) {}

  void rebuild(const Model& model) override;
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override { return IntegratorKind::kExplicit; }

  // Substeps a step of dt takes.
  [[nodiscard]] double planned_substeps(double dt) const;

 private:
  struct Scratch {
    mesh::VertexField force;       // 3 x V, N
    mesh::VertexField damped;      // 3 x V, m: x + beta v
    std::vector<double> mobility;  // V, 1/kg: inverse masses, 0 at pins
    State start;                   // to go back to
  };

  void advance(const Model& model, const Loads& loads, double h, int substeps, ContactConstraint* contact,
               State& state);
  bool keeps_energy(const Model& model, const Loads& loads, StepStats& stats, State& state) const;
  void evaluate_forces(const Model& model, const Loads& loads, double kick, const State& state);
  void kick(const Model& model, const Loads& loads, double duration, State& state) const;
  void kick_grabs(const Loads& loads, double duration, double h, double time_left, State& state) const;

  IntegratorOptions options_;
  double critical_step_ = 0.0;  // s, > 0, for the model of the last rebuild; infinite for a model without material
  std::vector<double> beta_;    // s, of the membrane, one a material
  std::vector<double> bending_beta_;  // s, the materials' own alone: see bending_forces.h
  Scratch scratch_;
  std::string explanation_;
};

}  // namespace kerf::fem
