#include "server/fem/explicit_integrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "server/base/check.h"
#include "server/fem/bending_forces.h"
#include "server/fem/energy_guard.h"
#include "server/fem/follower_loads.h"
#include "server/fem/membrane.h"
#include "server/fem/wind_drag.h"

namespace kerf::fem {
namespace {

constexpr int kMaxRetries = 3;  // of a step that ended not finite, each with twice the substeps

void set_pin_velocities(const Loads& loads, State& state) {
  for (const Pin& pin : loads.pins) state.v.col(pin.vertex) = pin.held(pin.velocity, state.v.col(pin.vertex));
}

void set_pin_positions(const Loads& loads, double time_left, State& state) {
  for (const Pin& pin : loads.pins) {
    state.x.col(pin.vertex) = pin.held(pin.target - time_left * pin.velocity, state.x.col(pin.vertex));
  }
}

}  // namespace

void ExplicitIntegrator::rebuild(const Model& model) {
  const double omega = std::sqrt(model.stiffness_bound());
  const double limit = std::max(kMaxModeDamping, options_.highest_mode_damping);
  double xi = 0.0;  // the largest
  beta_.clear();
  bending_beta_.clear();
  for (const double own : model.materials().stiffness_damping()) {
    const double damping_ratio = std::clamp(0.5 * own * omega, options_.highest_mode_damping, limit);
    beta_.push_back(omega > 0.0 ? 2.0 * damping_ratio / omega : 0.0);
    bending_beta_.push_back(std::min(beta_.back(), own));
    xi = std::max(xi, damping_ratio);
  }
  critical_step_ =
      omega > 0.0 ? 2.0 / omega * (std::sqrt(1.0 + xi * xi) - xi) : std::numeric_limits<double>::infinity();
  const Eigen::Index n = model.num_vertices();
  scratch_.force.resize(n);
  scratch_.damped.resize(n);
  scratch_.start.x.resize(n);
  scratch_.start.v.resize(n);
  scratch_.mobility.resize(model.inverse_mass().size());
  explanation_ = "explicit: velocity Verlet, stable step " + std::to_string(critical_step_ * 1e6) + " us";
}

double ExplicitIntegrator::planned_substeps(double dt) const {
  return std::max(1.0, std::ceil(dt / (options_.cfl * critical_step_)));
}

StepStats ExplicitIntegrator::step(const Model& model, const Loads& loads, double dt, ContactConstraint* contact,
                                   State& state) {
  KERF_CHECK(state.x.cols() == scratch_.force.cols() && model.num_vertices() == scratch_.force.cols(),
             "rebuild() was called for this model");
  StepStats stats;
  std::copy(model.inverse_mass().begin(), model.inverse_mass().end(), scratch_.mobility.begin());
  for (const Pin& pin : loads.pins) {
    if (pin.is_whole()) scratch_.mobility[static_cast<std::size_t>(pin.vertex)] = 0.0;
  }
  scratch_.start.x = state.x;
  scratch_.start.v = state.v;

  double planned = planned_substeps(dt);
  double h = dt / planned;
  if (planned > options_.max_substeps) {
    planned = options_.max_substeps;
    h = options_.cfl * critical_step_;
    stats.flags |= kSubstepLimit;
  }
  stats.substeps = static_cast<int>(planned);
  stats.simulated = h * planned;
  for (int retry = 0;; ++retry) {
    if (contact != nullptr) contact->begin(state.x);
    advance(model, loads, h, stats.substeps, contact, state);
    if (is_finite(state)) {
      stats.max_strain = max_principal_strain(model.element_blocks(), state.x);
      if (contact != nullptr || keeps_energy(model, loads, stats, state) || retry == kMaxRetries) break;
    }
    state.x = scratch_.start.x;
    state.v = scratch_.start.v;
    if (retry == kMaxRetries) {
      stats.flags |= kFrozen;
      stats.substeps = 0;
      stats.simulated = 0.0;
      return stats;
    }
    stats.flags |= kSubstepped;
    stats.substeps *= 2;
    h *= 0.5;
  }
  if (stats.max_strain > options_.strain_limit) stats.flags |= kStrainLimit;
  return stats;
}

// Whether the substeps resolved the motion well enough; else its energy is limited.
bool ExplicitIntegrator::keeps_energy(const Model& model, const Loads& loads, StepStats& stats, State& state) const {
  // The stable step is that of the sheet at rest; what strains it little is resolved by it.
  constexpr double kSmallStrain = 0.1;  // -
  // Verlet swings about the energy it keeps by what its step resolves of the fastest modes.
  constexpr double kAllowedGain = 1e-2;  // -
  if (stats.max_strain <= kSmallStrain) return true;
  const EnergyGuard::Verdict verdict = EnergyGuard::enforce(model, loads, kAllowedGain, scratch_.start, state);
  if (verdict != EnergyGuard::Verdict::kKept) stats.flags |= kEnergyLimited;
  return verdict == EnergyGuard::Verdict::kKept;
}

void ExplicitIntegrator::advance(const Model& model, const Loads& loads, double h, int substeps,
                                 ContactConstraint* contact, State& state) {
  const double duration = h * substeps;
  set_pin_velocities(loads, state);
  evaluate_forces(model, loads, 0.5 * h, state);
  kick(model, loads, 0.5 * h, state);
  kick_grabs(loads, 0.5 * h, h, duration - h, state);
  set_pin_velocities(loads, state);
  for (int i = 1; i <= substeps; ++i) {
    const double time_left = i == substeps ? 0.0 : duration - h * i;
    state.x += h * state.v;
    set_pin_positions(loads, time_left, state);
    const bool last = i == substeps;
    const double kick_duration = last ? 0.5 * h : h;
    if (contact != nullptr && !last) contact->enforce(h, state);
    evaluate_forces(model, loads, kick_duration, state);
    kick(model, loads, kick_duration, state);
    kick_grabs(loads, kick_duration, h, std::max(time_left - h, 0.0), state);
    set_pin_velocities(loads, state);
    if (contact != nullptr && last) contact->enforce(h, state);
  }
}

void ExplicitIntegrator::evaluate_forces(const Model& model, const Loads& loads, double kick, const State& state) {
  mesh::VertexField& f = scratch_.force;
  if (loads.external_forces.cols() > 0) {
    f = loads.external_forces;
  } else {
    f.setZero();
  }
  add_membrane_forces(model.element_blocks(), model.materials(), beta_, state.x, state.v, f);
  model.add_bending_forces(state.x, state.v, bending_beta_, scratch_.damped, f);
  add_follower_forces(model.element_blocks(), loads, state.x, f);
  add_wind_drag(model.element_blocks(), model.materials(), loads.wind, kick, state, f);
}

// Midpoint rule for the mass damping: v' = v + duration (f/m + g - alpha (v + v')/2).
void ExplicitIntegrator::kick(const Model& model, const Loads& loads, double duration, State& state) const {
  const double* const f = scratch_.force.data();
  double* const v = state.v.data();
  double keep = 1.0;
  double scale = duration;
  std::array<double, 3> g{};
  const auto damp = [&](double alpha) {
    const double half_damping = 0.5 * alpha * duration;
    keep = (1.0 - half_damping) / (1.0 + half_damping);
    scale = duration / (1.0 + half_damping);
    g = {scale * loads.gravity.x(), scale * loads.gravity.y(), scale * loads.gravity.z()};
  };
  const bool is_same = model.materials().has_one_mass_damping();
  if (is_same) damp(model.mass_damping(0));
  for (std::size_t i = 0; i < scratch_.mobility.size(); ++i) {
    if (!is_same) damp(model.mass_damping(static_cast<mesh::VertexId>(i)));
    const double weight = scale * scratch_.mobility[i];
    if (weight == 0.0) continue;
    for (std::size_t c = 0; c < 3; ++c) v[3 * i + c] = keep * v[3 * i + c] + weight * f[3 * i + c] + g[c];
  }
}

// One implicit Euler step of the spring alone, over the kick and the drift of h that follows: impulse
//   j = tau (k (target - p - h (v - v_target)) - c (v - v_target)) / (1 + w tau (h k + c)),  w = sum weight^2 / m.
void ExplicitIntegrator::kick_grabs(const Loads& loads, double duration, double h, double time_left,
                                    State& state) const {
  for (const Grab& grab : loads.grabs) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    double w = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      const double weight = grab.weights[static_cast<Eigen::Index>(k)];
      p += weight * state.x.col(grab.vertices[k]);
      v += weight * state.v.col(grab.vertices[k]);
      w += weight * weight * scratch_.mobility[static_cast<std::size_t>(grab.vertices[k])];
    }
    const Eigen::Vector3d target = grab.target - time_left * grab.velocity;  // when the drift ends
    const Eigen::Vector3d impulse = duration *
                                    (grab.stiffness * (target - p - h * v) - grab.damping * (v - grab.velocity)) /
                                    (1.0 + w * duration * (h * grab.stiffness + grab.damping));
    for (std::size_t k = 0; k < 3; ++k) {
      if (grab.vertices[k] == mesh::kNone) continue;
      const double share =
          grab.weights[static_cast<Eigen::Index>(k)] * scratch_.mobility[static_cast<std::size_t>(grab.vertices[k])];
      state.v.col(grab.vertices[k]) += share * impulse;
    }
  }
}

}  // namespace kerf::fem
