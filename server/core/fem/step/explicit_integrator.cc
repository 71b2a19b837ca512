#include "server/core/fem/step/explicit_integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "server/base/check.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/element/wind_drag.h"
#include "server/core/fem/model/energy_guard.h"
#include "server/core/fem/model/free_flight.h"
#include "server/core/fem/model/model.h"

namespace kerf::fem {
namespace {

constexpr int kMaxRetries = 3;  // of a step that failed, each with twice the substeps

void set_pins(const Loads& loads, double time_left, State& state) {
  for (const Pin& pin : loads.pins) {
    state.v.col(pin.vertex) = pin.held(pin.velocity, state.v.col(pin.vertex));
    state.x.col(pin.vertex) = pin.held(pin.target - time_left * pin.velocity, state.x.col(pin.vertex));
  }
}

GreenStretch stretch_at(const Model& model, const linear::VertexField& x) {
  if (model.materials().membrane_law() != MembraneLaw::kGreen) return {};
  return green_stretch(model.element_blocks(), model.materials(), x);
}

bool has_loads_on_vertices(const Loads& loads) {
  return loads.has_external_forces() || has_wind_drag(loads.wind) || has_follower_loads(loads);
}

// Returns true if there are forces of bending that the bending matrix does not give: clamps, curved rest shapes and
// damping that varies.
bool has_bending_on_vertices(const Model& model, std::span<const double> bending_beta) {
  return model.materials().has_bending() &&
         (!model.bending().clamp_forces().forces.empty() ||
          !model.bending().rest(model.element_blocks()).rest.empty() || !is_uniform(bending_beta));
}

// Moves vertices without mass that are not held at constant velocity.
void drift_massless(const Model& model, double duration, State& state) {
  for (std::size_t v = 0; v < model.inverse_mass().size(); ++v) {
    if (model.inverse_mass()[v] > 0.0) continue;
    const auto i = static_cast<Eigen::Index>(v);
    state.x.col(i) += duration * state.v.col(i);
  }
}

}  // namespace

void ExplicitIntegrator::resize(const Model& model) {
  const Eigen::Index n = model.num_vertices();
  scratch_.force.resize(n);
  scratch_.start.x.resize(n);
  scratch_.start.v.resize(n);
  scratch_.given.resize(n);
}

void ExplicitIntegrator::rebuild(const Model& model) {
  plan(model, false);
  set_up(model, false);
}

void ExplicitIntegrator::follow(const Model& model) {
  plan(model, true);
  set_up(model, true);
}

void ExplicitIntegrator::set_up(const Model& model, bool follows) {
  resize(model);
  if (!follows) layout_.rebuild(model);
  set_sweeps(model, follows && layout_.follow(model));
}

void ExplicitIntegrator::set_sweeps(const Model& model, bool follows) {
  const auto set = [&](auto& sweep) {
    if (follows) {
      sweep.follow(model, layout_, inertia_);
    } else {
      sweep.rebuild(model, layout_, inertia_);
    }
  };
  const bool is_mixed = options_.precision == Precision::kMixed;
  if (is_mixed) set(mixed_sweep_);
  // A mixed-precision sheet that was stepped in double will probably be so in the next step as well.
  is_double_current_ = !is_mixed || (follows && is_double_current_ && was_in_double_);
  if (is_double_current_) {
    set(double_sweep_);
  } else {
    double_sweep_.reserve(model, layout_, mixed_sweep_);
  }
}

double ExplicitIntegrator::quiet_speed(const Model& model, const Loads& loads, double dt, const State& state) {
  constexpr double kAboveNoise = 8.0;      // -
  constexpr double kNoise = 0x1p-20;       // -, noise of strains that gathers over many substeps, measured for many
                                           // materials and meshes
  constexpr double kCoarseness = 0x1p-28;  // -, unit of positions over the extent of the sheet
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  double speed_squared = 0.0;
  for (Eigen::Index v = 0; v < state.x.cols(); ++v) {
    if (model.mass()[static_cast<std::size_t>(v)] == 0.0) continue;
    low = low.min(state.x.col(v).array());
    high = high.max(state.x.col(v).array());
    speed_squared = std::max(speed_squared, state.v.col(v).squaredNorm());
  }
  const double extent = (high - low).maxCoeff();
  const double noise =
      std::max(kNoise, kCoarseness * extent *
                           std::min(model.elements().largest_gradient(), LeapfrogSweep<float>::flattest(model)));
  const double quiet = kAboveNoise * noise * fastest_wave_;
  if (std::sqrt(speed_squared) >= quiet) return 0.0;
  return speed_squared > 0.0 || dt * mean_acceleration(model, loads, dt, state) < quiet ? quiet : 0.0;
}

double ExplicitIntegrator::mean_acceleration(const Model& model, const Loads& loads, double dt, const State& state) {
  linear::VertexField& f = scratch_.force;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto add_to_sum = [&] {
    for (const Pin& pin : loads.pins) f.col(pin.vertex) = pin.held(Eigen::Vector3d::Zero(), f.col(pin.vertex));
    sum += f.rowwise().sum();
  };
  model.internal_forces(state.x, f);
  add_to_sum();
  LeapfrogKick kick;
  kick.duration = dt;
  set_forces(model, loads, kick, state);
  for (Eigen::Index v = 0; v < f.cols(); ++v) f.col(v) += model.mass()[static_cast<std::size_t>(v)] * loads.gravity;
  add_to_sum();
  return sum.norm() / model.masses().total();
}

StepStats ExplicitIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                   State& state) {
  // Largest ratio of the substeps that the final strains need to those taken. A step above it is repeated. For a flake
  // torn apart by a ball the ratio was 350.
  constexpr int kMostOutrun = 2;
  KERF_CHECK(state.x.cols() == scratch_.force.cols() && model.num_vertices() == scratch_.force.cols(),
             "rebuild() was called for this model");
  StepStats stats;
  inertia_.hold(loads.pins);
  const bool is_calmed = calm_clusters(model, state);
  scratch_.start.x = state.x;
  scratch_.start.v = state.v;

  const GreenStretch stretch = stretch_at(model, state.x);
  const double longest = cfl() * critical_step(stretch.stiffening);
  const double planned = substeps_below(longest, dt);
  Plan plan{dt, 0, stretch.tension, 0};
  if (planned > options_.max_substeps) {
    plan.substeps = options_.max_substeps;
    plan.duration = longest * plan.substeps;
    stats.flags |= kSubstepLimit;
  } else {
    plan.is_calm = contact != nullptr && contact->is_calm();
    plan.substeps = with_calm_share(plan, static_cast<int>(planned));
  }
  bool is_mixed = options_.precision == Precision::kMixed;
  double quiet = is_mixed ? quiet_speed(model, loads, dt, state) : 0.0;
  // Green's strain has no form for displacements.
  const bool has_displacements = model.materials().membrane_law() == MembraneLaw::kCorotational;
  if (quiet > 0.0 && !has_displacements) is_mixed = false;
  for (int retry = 0;; ++retry) {
    const int least = plan.substeps;
    if (is_mixed) {
      mixed_sweep_.step_by_displacements(quiet);
      is_mixed = advance(model, loads, plan, contact, mixed_sweep_, state) || !is_finite(state);
      // A sheet that leaves the range of displacements is not at rest. Its step is made again with plain positions.
      if (quiet > 0.0 && (is_mixed ? !is_finite(state) : !mixed_sweep_.stayed_inside(plan.duration))) {
        quiet = 0.0;
        mixed_sweep_.step_by_displacements(quiet);
        go_back(state);
        plan.substeps = least;
        is_mixed = advance(model, loads, plan, contact, mixed_sweep_, state) || !is_finite(state);
      }
      if (stop_.is_met()) return interrupt(is_calmed, state);
      if (!is_mixed) {
        if (quiet == 0.0) stats.flags |= kWidened;
        go_back(state);
        plan.substeps = least;
      }
    }
    if (!is_mixed) {
      if (!is_double_current_) double_sweep_.rebuild(model, layout_, inertia_);
      is_double_current_ = true;
      advance(model, loads, plan, contact, double_sweep_, state);
      if (stop_.is_met()) return interrupt(is_calmed, state);
    }
    was_in_double_ = !is_mixed;
    if (is_finite(state)) {
      const StrainExtent strain = measure_strain(model.element_blocks(), model.materials(), state.x);
      stats.max_strain = strain.largest;
      stats.strained_share = strain.beyond_limit;
      const bool is_kept = plan.touched || keeps_energy(model, loads, stats, state);
      // A sheet that stretches more within the step than the margin of the cfl number allows has outrun its substeps.
      const bool is_stable = plan.h() <= critical_step(stretch_at(model, state.x).stiffening) &&
                             substeps_stretched(plan.duration, stats.max_strain) <= kMostOutrun * plan.substeps;
      if ((is_kept && is_stable) || retry == kMaxRetries) break;
    }
    go_back(state);
    stats.flags &= ~kEnergyLimited;  // clears the flag of the discarded attempt
    if (retry == kMaxRetries) {
      if (is_calmed) state.v = scratch_.given;
      stats.flags |= kFrozen;
      return stats;
    }
    stats.flags |= kSubstepped;
    plan.substeps *= 2;
  }
  stats.substeps = plan.substeps;
  stats.load_phases = plan.load_phases;
  stats.cluster_pushes = plan.cluster_pushes;
  stats.bending_interval = plan.bending_interval;
  stats.is_double = was_in_double_;
  stats.simulated = plan.duration;
  if (contact != nullptr && contact->num_inside() > 0) stats.flags |= kInsideBody;
  return stats;
}

bool ExplicitIntegrator::keeps_energy(const Model& model, const Loads& loads, StepStats& stats, State& state) const {
  // -, strain up to which the stable step of the sheet at rest resolves the motion, so that energy need not be checked.
  constexpr double kSmallStrain = 0.1;  // -
  // The energy of Verlet oscillates, because its step does not fully resolve the fastest modes.
  constexpr double kAllowedGain = 1e-5;  // -
  if (stats.max_strain <= kSmallStrain) return true;
  const EnergyGuard::Verdict verdict =
      EnergyGuard::enforce(model, loads, &inertia_, kAllowedGain, scratch_.start, state);
  if (verdict != EnergyGuard::Verdict::kKept) stats.flags |= kEnergyLimited;
  return verdict == EnergyGuard::Verdict::kKept;
}

bool ExplicitIntegrator::calm_clusters(const Model& model, State& state) {
  // Largest share that is no noise. Swinging sheets after 5 to 100 random cuts reach 0.001.
  constexpr double kMostAdded = 0.005;  // -, added energy over the kinetic energy of the masses
  if (inertia_.empty()) return false;
  double kinetic = 0.0;
  for (Eigen::Index v = 0; v < state.v.cols(); ++v) {
    kinetic += 0.5 * model.mass()[static_cast<std::size_t>(v)] * state.v.col(v).squaredNorm();
  }
  if (!(inertia_.added_energy(state.v) > kMostAdded * kinetic)) return false;
  scratch_.given = state.v;
  inertia_.share_impulses(model, state.v);
  return true;
}

StepStats ExplicitIntegrator::interrupt(bool is_calmed, State& state) const {
  go_back(state);
  if (is_calmed) state.v = scratch_.given;
  StepStats stats;
  stats.interrupted = true;
  return stats;
}

void ExplicitIntegrator::go_back(State& state) const {
  state.x = scratch_.start.x;
  state.v = scratch_.start.v;
}

template <typename T>
bool ExplicitIntegrator::advance(const Model& model, const Loads& loads, Plan& plan, ContactConstraint* contact,
                                 LeapfrogSweep<T>& sweep, State& state) {
  const double duration = plan.duration;
  const double bending_beta = is_uniform(bending_beta_) ? damping_of(bending_beta_, 0) : 0.0;
  LeapfrogTerms terms{loads.gravity, beta_, bending_beta, 0.0};
  const bool has_loads = has_loads_on_vertices(loads);
  const bool has_bending = has_bending_on_vertices(model, bending_beta_);
  if (contact != nullptr) contact->begin(state.x);
  // In floats, rounding accumulates over substeps to a drift of the whole sheet. FreeFlight corrects it.
  std::optional<FreeFlight> flight;
  if (std::is_same_v<T, float> && FreeFlight::holds(model, loads)) flight.emplace(model, inertia_, state);
  set_pins(loads, duration, state);
  const int least = plan.substeps;
  const bool is_green = model.materials().membrane_law() == MembraneLaw::kGreen;
  int interval = set_substeps(model, least, plan.tension, plan);
  terms.h = plan.h();
  const bool touches_itself = contact != nullptr && contact->touches_itself();
  if (!sweep.begin(model, loads, terms, duration, state)) return false;
  if (!is_green) {
    const int expected = plan.substeps;
    interval =
        set_substeps(model, std::max(least, with_calm_share(plan, substeps_stretched(duration, sweep.tension()))),
                     sweep.tension(), plan);
    terms.h = plan.h();
    if (plan.substeps != expected && !sweep.begin(model, loads, terms, duration, state)) return false;
  }
  const double h = plan.h();
  bool touched_itself = false;
  if (touches_itself) {
    touched_itself = begin_self_contact(model, loads, plan, *contact, state);
    if (touched_itself && !sweep.read(state)) return false;
  }
  for (int i = 0; i <= plan.substeps; ++i) {
    if (stop_.is_met()) return false;
    const bool last = i == plan.substeps;
    const double time_left = last ? 0.0 : duration - h * i;
    LeapfrogKick kick;
    kick.duration = i == 0 || last ? 0.5 * h : h;
    kick.drift = last ? 0.0 : h;
    if (i % interval == 0) {
      kick.bending = i == 0 || last ? 0.5 * h * interval : h * interval;
    }
    if (has_loads || (has_bending && kick.bending > 0.0)) {
      sweep.write(state);
      set_forces(model, loads, kick, state);
      ++plan.load_phases;
      kick.forces = &scratch_.force;
    }
    sweep.substep(model, terms, kick);
    if (flight) flight->substep(kick_factors(model.masses().damping(0), kick.duration), loads.gravity, kick.drift);
    if (!kick_grabs(loads, kick, h, std::max(time_left - h, 0.0), sweep)) return false;
    if (contact == nullptr) continue;
    if (i + 1 == plan.substeps) {
      sweep.find_touching(*contact, h);
    } else if (!(last ? sweep.enforce_found(*contact) : sweep.enforce(*contact, h))) {
      return false;
    }
    const int done = last ? plan.substeps : i + 1;
    if (!touches_itself || done < contact->next_self_contact() || i + 1 == plan.substeps) continue;
    sweep.write(state);
    const std::span<const mesh::VertexId> moved = contact->make_self_contact(state);
    touched_itself = touched_itself || !moved.empty();
    if (!sweep.set_vertices(moved, state)) return false;
  }
  if (!sweep.stayed_inside(duration)) return false;
  plan.touched = sweep.touched() || touched_itself;
  plan.cluster_pushes = sweep.num_cluster_pushes();
  plan.bending_interval = interval;
  sweep.write(state);
  if (flight && !plan.touched) flight->put_right(model, inertia_, state);
  set_pins(loads, 0.0, state);
  drift_massless(model, duration, state);
  return true;
}

bool ExplicitIntegrator::begin_self_contact(const Model& model, const Loads& loads, const Plan& plan,
                                            ContactConstraint& contact, State& state) {
  const std::span<const double> inverse_mass = model.inverse_mass();
  scratch_.mobility.assign(inverse_mass.begin(), inverse_mass.end());
  for (const Pin& pin : loads.pins) scratch_.mobility[static_cast<std::size_t>(pin.vertex)] = 0.0;
  return !contact.begin_self_contact(plan.h(), plan.substeps, loads.gravity, scratch_.mobility, inertia_, state)
              .empty();
}

void ExplicitIntegrator::set_forces(const Model& model, const Loads& loads, const LeapfrogKick& kick,
                                    const State& state) {
  linear::VertexField& f = scratch_.force;
  f.setZero();
  if (kick.bending > 0.0 && model.materials().has_bending()) {
    add_clamp_forces(model.bending().clamp_forces(), f);
    add_rest_bending_forces(model.bending().rest(model.element_blocks()), state.x, state.v, bending_beta_, f);
    if (!is_uniform(bending_beta_))
      add_bending_damping(model.bending().terms(model.element_blocks()), bending_beta_, state.v, f);
    f *= kick.bending / kick.duration;
  }
  add_wind_drag(model.element_blocks(), model.materials(), loads.wind, kick.duration, state, f);
  if (loads.external_forces.cols() > 0) f += loads.external_forces;
  add_follower_forces(model.element_blocks(), loads, state.x, f);
}

// Makes one implicit Euler step of the spring alone, over the kick and the drift of h after it, with the impulse
//   j = tau (k (target - p - h (v - v_target)) - c (v - v_target)) / (1 + w tau (h k + c)),  w = sum weight^2 / m.
template <typename T>
bool ExplicitIntegrator::kick_grabs(const Loads& loads, const LeapfrogKick& kick, double h, double time_left,
                                    LeapfrogSweep<T>& sweep) {
  for (const Grab& grab : loads.grabs) {
    Eigen::Array3d p = Eigen::Array3d::Zero();  // at the end of the drift
    Eigen::Array3d v = Eigen::Array3d::Zero();
    const Eigen::Array3d w = sweep.mobility(grab);
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      const double weight = grab.weights[static_cast<Eigen::Index>(k)];
      const Eigen::Vector3d velocity = sweep.velocity(grab.vertices[k]);
      p += weight * (sweep.position(grab.vertices[k]) + (h - kick.drift) * velocity).array();
      v += weight * velocity.array();
    }
    const Eigen::Array3d target = grab.target - time_left * grab.velocity;
    const Eigen::Array3d impulse = kick.duration *
                                   (grab.stiffness * (target - p) - grab.damping * (v - grab.velocity.array())) /
                                   (1.0 + w * kick.duration * (h * grab.stiffness + grab.damping));
    if (!sweep.push(grab, impulse, kick.drift)) return false;
  }
  return true;
}

}  // namespace kerf::fem
