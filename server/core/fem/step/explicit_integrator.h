#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/fem/leapfrog/leapfrog_sweep.h"
#include "server/core/fem/leapfrog/membrane_layout.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Velocity Verlet in leapfrog form: half kick, then {drift, force, full kick}, the last kick half again, so that a step
// begins and ends with x and v at one time. Second order, symplectic, conserves linear and angular momentum to
// round-off where no load acts.
//
// Substep: h = dt / n, n >= dt / (cfl h_crit), no more above than a whole number of bending kicks asks for, h_crit = 2
// / omega (sqrt(1 + xi^2) - xi), omega^2 = Model::stiffness_bound(); Kelvin-Voigt damping beta = 2 xi / omega with xi
// between highest_mode_damping and kMaxModeDamping, whichever lets the material's own stiffness_damping through; of
// several materials each has its xi, and the largest bounds the step: with K and C the sums of the elements' stiffness
// and damping and any mode of the step, u.C u <= beta_max u.K u. Mass damping by the midpoint rule. Bending acts more
// slowly than the membrane and kicks once in several substeps (impulse method: Grubmueller et al. 1991, "Generalized
// Verlet algorithm for efficient molecular dynamics simulations with long-range interactions"; Tuckerman, Berne,
// Martyna 1992): see bending_interval(). The bound is that of the sheet at rest. Stretched with Green's strain it is
// stiffer, see GreenStretch: of that law a step begins with the substep of the sheet as it is, and is made again with
// shorter ones where the sheet ends so stretched that they were too long. In mixed precision a step of a sheet that is
// nearly at rest as it begins goes by displacements, or is made in double: else a stiff sheet would not come to rest.
// A calm sheet on bodies takes kCalmSubsteps times as many substeps, and bending kicks in each: else it would creep.
// Contact is enforced after each drift, in the last substep after the closing kick, so that what leaves the step
// respects it.
class ExplicitIntegrator final : public Integrator {
 public:
  // Damping ratio of the fastest mode, -, above which the stable step shrinks faster than damping is worth.
  static constexpr double kMaxModeDamping = 0.3;
  // -, substeps of a calm sheet on bodies, over those of others. The fastest modes swing at the pace of the substeps at
  // the edge of stability. Bodies, which push once in each, keep them going, and friction lets go. Measured: drapes
  // that crept or trembled for good with 1 and 1.25 come to rest with 1.5.
  static constexpr double kCalmSubsteps = 1.5;

  explicit ExplicitIntegrator(const IntegratorOptions& options) : options_(options) {}

  // Stable step, damping and clusters alone, for planned_substeps(); `follows`: after one Model::follow since the call
  // before. To be completed by set_up() before a step.
  void plan(const Model& model, bool follows);
  void set_up(const Model& model, bool follows);
  void rebuild(const Model& model) override;
  void follow(const Model& model) override;
  StepStats step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact, State& state) override;
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const override;
  [[nodiscard]] std::string_view explanation() const override { return explanation_; }
  [[nodiscard]] IntegratorKind kind() const override { return IntegratorKind::kExplicit; }
  [[nodiscard]] std::optional<LocalInertiaStats> local_inertia(double dt) const override;
  [[nodiscard]] TickCost expected_cost(const Model& model, double dt, const TickCounts& last) const override;

  // Substeps a step of dt takes at least.
  [[nodiscard]] double planned_substeps(double dt) const;
  // Substeps of h from one kick of the bending forces to the next, n <= kMaxBendingInterval, in a sheet of which the
  // largest strain in tension is as given, -. Kicks are stable by themselves where n h omega_b < 2, omega_b^2 =
  // Model::bending_stiffness_bound(), or the bending limit of clusters. A mode that oscillates with Omega between them
  // is in resonance where n h Omega is a multiple of pi, and then grows by up to (n h omega_b)^2 / (2 n h Omega) a
  // kick: most by half a swing, Omega = pi / (n h). Modes of the membrane lose n h xi Omega^2 / omega to damping, which
  // is to be twice that. Those that tension alone swings, Omega^2 <= strain omega^2, are not damped, and must not come
  // near half a swing.
  [[nodiscard]] int bending_interval(double h, double strain) const;
  [[nodiscard]] const LocalInertia& inertia() const { return inertia_; }

 private:
  static constexpr int kMaxBendingInterval = 8;

  struct Scratch {
    mesh::VertexField force;  // 3 x V, N
    State start;              // to go back to
    mesh::VertexField given;  // 3 x V, m/s, before calm_clusters()
  };
  struct Plan {
    double duration = 0.0;  // s
    int substeps = 0;
    double tension = 0.0;  // -, of Green's strain: see GreenStretch; else 0, what it is is seen as the step begins
    int load_phases = 0;   // see StepStats
    int cluster_pushes = 0;
    int bending_interval = 0;
    bool is_calm = false;  // see ContactConstraint::is_calm()
    bool touched = false;  // a body moved a vertex

    [[nodiscard]] double h() const { return duration / substeps; }  // s
  };

  // -, (0, 1), of the stable step. Less where nothing takes from the fastest modes what others of a sheet that strains
  // a little everywhere put into them.
  [[nodiscard]] double cfl() const;
  // s, of a sheet so many times as stiff as at rest; infinite without material.
  [[nodiscard]] double critical_step(double stiffening) const;
  // Frequencies of the fastest modes that the sheet had as built, from its edges and materials alone.
  struct Reference {
    double omega = 0.0;          // 1/s, of the membrane and bending
    double bending_omega = 0.0;  // 1/s, of bending
  };
  [[nodiscard]] static Reference reference(const Model& model);
  // Sets beta_, xi_ and the like for omega_; damping_ratio: see IntegratorOptions::highest_mode_damping.
  void set_damping(const Model& model, double damping_ratio);
  // Lengthens the step to what clusters allow, and returns their terms, or nothing where none are wanted. Both follow
  // from the model alone, so that an undo gives them back.
  [[nodiscard]] std::optional<InertiaTerms> inertia_terms(const Model& model);
  // Lets bending act in every third substep in spite of a few small triangles, where the membrane needs no clusters.
  [[nodiscard]] std::optional<InertiaTerms> inertia_terms_of_bending(const Model& model, const Reference& built);
  // Adds what kicks of bending want in steps of up to h, s, and sets bending_omega_; adds nothing where bending is to
  // act in every substep. built_omega: 1/s, of the bending of what need not be stiff.
  void add_terms_of_kicks(double h, double built_omega, InertiaTerms& terms);
  void resize(const Model& model);
  void set_sweeps(const Model& model, bool follows);
  void go_back(State& state) const;
  // Gives clusters the momentum that their vertices have by the masses alone, where relative motion inside of them
  // adds a share to the kinetic energy that swinging sheets do not have: noise of single vertices. That energy would
  // else come out as motion of the masses. Returns whether it did; the velocities given are then in scratch_.given.
  bool calm_clusters(const Model& model, State& state);
  // What step() returns where it was ended.
  StepStats interrupt(bool is_calmed, State& state) const;
  // m/s, below which motion is not far above the noise of mixed precision: strains of that noise make waves, which move
  // at the strain times the speed of waves, however fine the mesh is. 0 where the sheet is faster. A sheet that lies
  // still counts as fast where its mean acceleration makes it so within dt, s.
  [[nodiscard]] double quiet_speed(const Model& model, const Loads& loads, double dt, const State& state);
  // m/s^2, magnitude of all forces on what is not held over the mass of the sheet. Grabs and contact are left out.
  // Overwrites scratch_.force.
  [[nodiscard]] double mean_acceleration(const Model& model, const Loads& loads, double dt, const State& state);
  // Whether the substeps resolved the motion well enough; else its energy is limited.
  bool keeps_energy(const Model& model, const Loads& loads, StepStats& stats, State& state) const;
  // Of the co-rotational law: what the step takes of a sheet that is stretched, -, so much that irregular meshes are
  // stiffer than at rest; 0 where it is not.
  [[nodiscard]] int substeps_stretched(double duration, double strain) const;
  // Substeps of the plan that would be `substeps` of a sheet that is not calm.
  [[nodiscard]] int with_calm_share(const Plan& plan, int substeps) const;
  // The longest interval, no longer than `longest`, of which a step can have a whole number at the cost of a twentieth
  // more substeps: the last one of a step, if it were shorter, would beat with modes of the step's own pace.
  [[nodiscard]] int even_interval(int substeps, int longest) const;
  // -, steps of dt below `longest`, s; at least 1.
  [[nodiscard]] static double substeps_below(double longest, double dt);
  // At least so many, of a sheet with that tension, -, as many as bending kicks of one length want. Returns the
  // interval of these kicks.
  int set_substeps(const Model& model, int least, double tension, Plan& plan) const;
  // Of at least the plan's substeps: those made are put into it. False: the precision of the sweep does not do.
  template <typename T>
  bool advance(const Model& model, const Loads& loads, Plan& plan, ContactConstraint* contact, LeapfrogSweep<T>& sweep,
               State& state);
  // Into scratch_.force, those of bending as their impulse wants.
  void set_forces(const Model& model, const Loads& loads, const LeapfrogKick& kick, const State& state);
  template <typename T>
  static bool kick_grabs(const Loads& loads, const LeapfrogKick& kick, double h, double time_left,
                         LeapfrogSweep<T>& sweep);

  IntegratorOptions options_;
  // Of the model of the last rebuild, at rest.
  double omega_ = 0.0;                // 1/s
  double largest_xi_ = 0.0;           // -
  double critical_step_ = 0.0;        // s, > 0
  double plain_step_ = 0.0;           // s, > 0, the longest without clusters
  double fastest_wave_ = 0.0;         // m/s, of stretching, in the stiffest material that a triangle has
  std::vector<double> beta_;          // s, of the membrane, one a material
  std::vector<double> bending_beta_;  // s, the materials' own alone: see bending_forces.h
  double xi_ = 0.0;                   // -, the least
  double bending_omega_ = 0.0;        // 1/s, of bending, of what is not stiff where there are clusters
  LocalInertia inertia_;
  MembraneLayout layout_;
  LeapfrogSweep<double> double_sweep_;  // of mixed precision: where that does not do
  bool is_double_current_ = false;
  bool was_in_double_ = false;  // the last step
  LeapfrogSweep<float> mixed_sweep_;
  Scratch scratch_;
  std::string explanation_;
};

}  // namespace kerf::fem
