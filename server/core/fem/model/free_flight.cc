#include "server/core/fem/model/free_flight.h"

#include <algorithm>
#include <span>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/element/wind_drag.h"

namespace kerf::fem {
namespace {

struct Motion {
  Eigen::Vector3d x, v, spin;  // m, m/s, kg m^2/s about the centre
};

Motion motion_of(const Model& model, const LocalInertia& inertia, const State& state) {
  const Eigen::Vector3d x = model.centre_of_mass(state.x);
  const Momentum momentum = model.momentum(state);
  const Eigen::Vector3d spin = momentum.angular + inertia.added_spin(state) - x.cross(momentum.linear);
  return {x, momentum.linear / model.masses().total(), spin};
}

// Returns the inertia tensor about the centre, kg m^2.
Eigen::Matrix3d inertia_of(const Model& model, const linear::VertexField& x, const Eigen::Vector3d& centre) {
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (int v = 0; v < model.num_vertices(); ++v) {
    const Eigen::Vector3d r = x.col(v) - centre;
    const double mass = model.mass()[static_cast<std::size_t>(v)];
    inertia += mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return inertia;
}

// Returns the angular velocity (rad/s) of a rigid body with that spin; 0 about axes with next to no inertia.
Eigen::Vector3d rotation_of(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& spin) {
  constexpr double kLeast = 1e-9;  // -, of the largest
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double about = axes.eigenvalues()[i];
    if (!(about > kLeast * axes.eigenvalues()[2])) continue;
    rotation += axes.eigenvectors().col(i).dot(spin) / about * axes.eigenvectors().col(i);
  }
  return rotation;
}

}  // namespace

KickFactors kick_factors(double mass_damping, double duration) {
  const double half = 0.5 * mass_damping * duration;
  return {duration / (1.0 + half), 2.0 * half / (1.0 + half)};
}

bool FreeFlight::holds(const Model& model, const Loads& loads) {
  const bool is_held = !loads.pins.empty() || !loads.grabs.empty() || !model.bending().clamp_forces().forces.empty();
  const bool is_pushed = loads.has_external_forces() || has_wind_drag(loads.wind) || has_follower_loads(loads);
  return !is_held && !is_pushed && model.materials().has_one_mass_damping() && model.masses().total() > 0.0;
}

FreeFlight::FreeFlight(const Model& model, const LocalInertia& inertia, const State& state) {
  const Motion motion = motion_of(model, inertia, state);
  x_ = motion.x;
  v_ = motion.v;
  spin_ = motion.spin;
}

void FreeFlight::substep(const KickFactors& factors, const Eigen::Vector3d& gravity, double drift) {
  v_ += factors.scale * gravity - factors.lost * v_;
  x_ += drift * v_;
  spin_ *= 1.0 - factors.lost;
}

void FreeFlight::put_right(const Model& model, const LocalInertia& inertia, State& state) const {
  const Motion motion = motion_of(model, inertia, state);
  const std::span<const double> damping = model.materials().stiffness_damping();
  const bool keeps_spin = !model.materials().has_bending() ||
                          std::all_of(damping.begin(), damping.end(), [](double own) { return own == 0.0; });
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  if (keeps_spin) rotation = rotation_of(inertia_of(model, state.x, motion.x), spin_ - motion.spin);
  for (int v = 0; v < model.num_vertices(); ++v) {
    if (model.mass()[static_cast<std::size_t>(v)] == 0.0) continue;
    const Eigen::Vector3d r = state.x.col(v) - motion.x;
    state.x.col(v) += x_ - motion.x;
    state.v.col(v) += v_ - motion.v + rotation.cross(r);
  }
}

}  // namespace kerf::fem
