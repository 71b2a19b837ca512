#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Velocity Verlet in leapfrog form: half kick, then {drift, force, full kick}. The last kick is a half one again, so
// that a step begins and ends with x and v at the same time. Second order, symplectic, conserves linear and angular
// momentum to round-off if no load acts.
//
// Substep: h = dt / n with n >= dt / (cfl h_crit). n is no larger than needed for a whole number of bending kicks.
//   h_crit = 2 / omega (sqrt(1 + xi^2) - xi),   omega^2 = Model::stiffness_bound().
// Stiffness damping: Kelvin-Voigt with beta = 2 xi / omega. It follows Material::stiffness_damping, with xi kept
// between highest_mode_damping and kMaxModeDamping. Each material has its own xi, and the largest bounds the step. With
// K and C the sums of the elements' stiffness and damping, u.C u <= beta_max u.K u for any mode of the step. Mass
// damping: midpoint rule.
// Bending has lower frequencies than the membrane and kicks once in several substeps, see bending_interval(). This is
// the impulse method (Grubmueller et al. 1991, "Generalized Verlet algorithm for efficient molecular dynamics
// simulations with long-range interactions"; Tuckerman, Berne, Martyna 1992).
// Stretch: the bound holds for the sheet at rest. A sheet stretched with Green's strain is stiffer, see GreenStretch.
// Its step takes the substeps that the sheet needs at the start of the step. The step is repeated with shorter substeps
// if the sheet ends too stretched for them.
// Mixed precision: a step of a sheet nearly at rest uses displacements or double precision, see quiet_speed(). Rounding
// would keep a stiff sheet from coming to rest.
// Calm sheets on bodies (ContactConstraint::is_calm()) take kCalmSubsteps times as many substeps, and bending kicks in
// each. With fewer they would creep.
// Contact is enforced after each drift. In the last substep it is enforced after the closing kick, so that the final
// state respects it.
class ExplicitIntegrator final : public Integrator {
 public:
  // Largest damping ratio of the fastest mode, -. Above it the stable step shrinks faster than damping is worth.
  static constexpr double kMaxModeDamping = 0.3;
  // -, ratio of the substeps of a calm sheet on bodies to those of a sheet that is not calm. At the edge of stability
  // the fastest modes swing at the pace of the substeps. Bodies push once in each substep and keep these modes going,
  // so that friction fails to hold. Measured: drapes that crept or trembled for good with 1 and 1.25 come to rest with
  // 1.5.
  static constexpr double kCalmSubsteps = 1.5;

  explicit ExplicitIntegrator(const IntegratorOptions& options) : options_(options) {}

  // rebuild() and follow() in two parts, for callers that may need only the first. plan() computes the stable step,
  // damping and clusters, which suffices for planned_substeps(). set_up() must complete it before a step. `follows` is
  // true after exactly one Model::follow since the previous call, as for follow().
  void plan(const Model& model, bool follows);
  void set_up(const Model& model, bool follows);
  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  void hold(std::span<const Pin> pins) override { inertia_.hold(pins); }
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const override;
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override { return IntegratorKind::kExplicit; }
  [[nodiscard]] std::optional<LocalInertiaStats> local_inertia(double dt) const override;
  [[nodiscard]] TickCost expected_cost(const Model& model, double dt, const TickCounts& last) const override;

  // Returns the least number of substeps that keep a step of dt (s) stable.
  [[nodiscard]] double planned_substeps(double dt) const;
  // Returns the number n <= kMaxBendingInterval of substeps of h, s, from one kick of the bending forces to the next.
  // `strain`, -, is the largest principal strain of the sheet in tension. Let omega_b^2 be StiffnessBound::bending(),
  // or the bending limit of clusters. Kicks are stable by themselves if n h omega_b < 2. A mode that oscillates with
  // Omega between kicks is in resonance if n h Omega is a multiple of pi. It then grows by up to (n h omega_b)^2 / (2 n
  // h Omega) a kick. Growth is largest at half a swing, Omega = pi / (n h). Modes of the membrane lose n h xi Omega^2 /
  // omega to damping, which must be twice the growth. Modes driven by tension alone, Omega^2 <= strain omega^2, are not
  // damped, and must stay away from half a swing.
  [[nodiscard]] int bending_interval(double h, double strain) const;
  [[nodiscard]] const LocalInertia& inertia() const { return inertia_; }

 private:
  static constexpr int kMaxBendingInterval = 8;

  struct Scratch {
    linear::VertexField force;     // 3 x V, N
    State start;                   // for go_back()
    linear::VertexField given;     // 3 x V, m/s, before calm_clusters()
    std::vector<double> mobility;  // 1/kg, by vertex; 0 if it is held in any direction
  };
  struct Plan {
    double duration = 0.0;  // s
    int substeps = 0;
    // -, GreenStretch::tension of a sheet with Green's strain. 0 with the co-rotational law, whose strain is measured
    // as the step begins.
    double tension = 0.0;
    int load_phases = 0;  // for this and the next two see StepStats
    int cluster_pushes = 0;
    int bending_interval = 0;
    bool is_calm = false;  // see ContactConstraint::is_calm()
    bool touched = false;  // true if a body moved a vertex

    [[nodiscard]] double h() const { return duration / substeps; }  // s
  };

  // -, (0, 1), substep over stable step: IntegratorOptions::cfl, or less if the fastest modes have no damping. In a
  // sheet that is strained a little everywhere, other modes feed the fastest ones.
  [[nodiscard]] double cfl() const;
  // s, stable step h_crit of a sheet `stiffening` times as stiff as at rest; infinite without material.
  [[nodiscard]] double critical_step(double stiffening) const;
  // Frequencies of the fastest modes of the sheet as built, estimated from its typical edge length and its materials
  // alone.
  struct Reference {
    double omega = 0.0;          // 1/s, of the membrane and bending
    double bending_omega = 0.0;  // 1/s, of bending
  };
  [[nodiscard]] static Reference reference(const Model& model);
  // Sets beta_, bending_beta_, xi_ and largest_xi_ for omega_. `damping_ratio` is the least xi, see
  // IntegratorOptions::highest_mode_damping.
  void set_damping(const Model& model, double damping_ratio);
  // Returns the terms that give clusters their added inertia, or nothing if none are needed. If the membrane needs
  // clusters, it also sets omega_, the damping and critical_step_ for the longer step that clusters allow. All results
  // follow from the model alone, so an undo restores them.
  [[nodiscard]] std::optional<InertiaTerms> inertia_terms(const Model& model);
  // Returns terms of clusters that let bending act in every third substep despite a few small triangles, or nothing.
  // For sheets whose membrane needs no clusters.
  [[nodiscard]] std::optional<InertiaTerms> inertia_terms_of_bending(const Model& model, const Reference& built);
  // Sets the members of `terms` for bending, with substeps of h, s, and bending_omega_. Does nothing if bending acts in
  // every substep. built_omega: 1/s, frequency that bending outside the stiff parts may have.
  void add_terms_of_kicks(double h, double built_omega, InertiaTerms& terms);
  void resize(const Model& model);
  void set_sweeps(const Model& model, bool follows);
  void go_back(State& state) const;
  // Removes noise from the motion within clusters. It is noise if the added inertia has a larger share of the kinetic
  // energy than in swinging sheets. The clusters then get the velocities that the momentum of their masses alone gives
  // them. If they kept their velocities, the energy of the noise would turn into motion of the masses. Returns true if
  // velocities were changed; the original ones are then in scratch_.given.
  bool calm_clusters(const Model& model, State& state);
  // Restores `state` after a step that was interrupted, and returns the statistics of such a step. `is_calmed` is the
  // result of calm_clusters().
  StepStats interrupt(bool is_calmed, State& state) const;
  // m/s, speed below which motion is not far above the noise of mixed precision. Rounding makes noise in the strains.
  // The vertices then move at this strain times the wave speed, however fine the mesh is. Returns 0 if the sheet is
  // faster. A sheet at rest counts as faster if its mean acceleration makes it so within dt, s.
  [[nodiscard]] double quiet_speed(const Model& model, const Loads& loads, double dt, const State& state);
  // m/s^2, magnitude of the sum of all forces on free components over the mass of the sheet. Leaves out grabs and
  // contact. Overwrites scratch_.force.
  [[nodiscard]] double mean_acceleration(const Model& model, const Loads& loads, double dt, const State& state);
  // Returns true if the substeps resolved the motion well enough. If they did not, EnergyGuard limits the energy of
  // `state` and sets a flag in `stats`.
  bool keeps_energy(const Model& model, const Loads& loads, StepStats& stats, State& state) const;
  // Returns the number of substeps in `duration` (s) for a sheet with the co-rotational law that is stretched by
  // `strain`, -. Irregular meshes are then stiffer than at rest. Returns 0 for small strains.
  [[nodiscard]] int substeps_stretched(double duration, double strain) const;
  // Returns `substeps`, or kCalmSubsteps times as many if the plan is that of a calm sheet.
  [[nodiscard]] int with_calm_share(const Plan& plan, int substeps) const;
  // Returns the longest interval between bending kicks, at most `longest`, in substeps. A step must hold a whole number
  // of such intervals, with at most a twentieth more than `substeps`. A shorter last interval in each step would beat
  // with modes at the pace of the steps.
  [[nodiscard]] int even_interval(int substeps, int longest) const;
  // -, least number of substeps of a step of dt, s, that are no longer than `longest`, s; at least 1.
  [[nodiscard]] static double substeps_below(double longest, double dt);
  // Sets plan.substeps to `least`, or a little more, for a sheet under `tension`, -. Returns the interval between
  // bending kicks in substeps, which divides plan.substeps.
  int set_substeps(const Model& model, int least, double tension, Plan& plan) const;
  // Advances `state` by plan.duration in at least plan.substeps substeps, and stores their number in the plan. Returns
  // false if the sweep's precision T cannot hold the sheet, or if the step was stopped.
  template <typename T>
  bool advance(const Model& model, const Loads& loads, Plan& plan, ContactConstraint* contact, LeapfrogSweep<T>& sweep,
               State& state);
  // Sets scratch_.force to LeapfrogKick::forces. Those of bending are scaled by kick.bending / kick.duration, so that a
  // kick of kick.duration has the impulse of kick.bending.
  void set_forces(const Model& model, const Loads& loads, const LeapfrogKick& kick, const State& state);
  // Begins contact of the sheet with itself. Returns true if it changed velocities.
  bool begin_self_contact(const Model& model, const Loads& loads, const Plan& plan, ContactConstraint& contact,
                          State& state);
  template <typename T>
  static bool kick_grabs(const Loads& loads, const LeapfrogKick& kick, double h, double time_left,
                         LeapfrogSweep<T>& sweep);

  IntegratorOptions options_;
  // Properties at rest of the model that was followed last.
  double omega_ = 0.0;                // 1/s, bound of the fastest mode, or with clusters the frequency that they allow
  double largest_xi_ = 0.0;           // -
  double critical_step_ = 0.0;        // s, > 0
  double plain_step_ = 0.0;           // s, > 0, longest substep that would be stable without clusters
  double fastest_wave_ = 0.0;         // m/s, speed of the fastest stretching waves in the material of any triangle
  std::vector<double> beta_;          // s, damping time of the membrane, one a material
  std::vector<double> bending_beta_;  // s, damping time of bending, one a material: at most Material::stiffness_damping
  double xi_ = 0.0;                   // -, smallest xi of all materials
  double bending_omega_ = 0.0;        // 1/s, bound of bending alone; with clusters, of bending outside the stiff parts
  LocalInertia inertia_;
  MembraneLayout layout_;
  LeapfrogSweep<double> double_sweep_;  // for steps that mixed precision cannot hold
  bool is_double_current_ = false;
  bool was_in_double_ = false;  // the last step was in double
  LeapfrogSweep<float> mixed_sweep_;
  Scratch scratch_;
  std::string explanation_;
};

}  // namespace kerf::fem
