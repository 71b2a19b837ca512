#include "server/core/fem/model/energy_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace kerf::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool is_guarded(const Model& model, const Loads& loads, const State& start) {
  const bool has_wind = loads.wind.air_density > 0.0 && !loads.wind.velocity.isZero(0.0);
  if (has_wind || !loads.grabs.empty() || !loads.pressure.empty() || !loads.edge_moments.empty()) return false;
  for (const Pin& pin : loads.pins) {
    const Vector3d at = start.x.col(pin.vertex);
    if (pin.held(pin.target, at) != at || !pin.held(pin.velocity, Vector3d::Zero()).isZero(0.0)) return false;
  }
  return model.num_vertices() > 0;
}

// Returns the work of gravity and dead forces from one state to the other, J.
double work_of_loads(const Model& model, const Loads& loads, const State& start, const State& end) {
  double work = 0.0;
  for (Eigen::Index i = 0; i < end.x.cols(); ++i) {
    Vector3d force = model.mass()[static_cast<std::size_t>(i)] * loads.gravity;
    if (loads.external_forces.cols() > 0) force += loads.external_forces.col(i);
    work += force.dot(end.x.col(i) - start.x.col(i));
  }
  return work;
}

// Returns the energy, J, that rounding alone may add to a sheet whose elastic energy is `elastic`, J. The error of a
// strain is about kRoundings eps |x| / edge length, where |x| is the largest coordinate.
double rounding_energy(const Model& model, const State& state, double elastic) {
  constexpr double kRoundings = 16.0;  // rounding errors that add up in each strain
  const double area = model.elements().area();
  if (!(area > 0.0)) return 0.0;
  const double edge = std::sqrt(2.0 * area / std::max(1, model.num_slots()));
  const double strain =
      kRoundings * std::numeric_limits<double>::epsilon() * std::max(1.0, state.x.cwiseAbs().maxCoeff() / edge);
  const double stiffness = model.materials().largest_membrane_trace() * area;
  return strain * (strain * stiffness + std::sqrt(2.0 * elastic * stiffness));
}

// Returns the elastic energy, J. Negative bending energy counts as 0. Only rounding in slivers can make it negative,
// and it would allow the motion to gain energy without end.
double elastic_energy(const Energies& energies) {
  return energies.membrane + std::max(0.0, energies.bending);
}

// Motion of a rigid body with the sheet's linear and angular momentum.
struct RigidMotion {
  Vector3d centre = Vector3d::Zero();    // m
  Vector3d velocity = Vector3d::Zero();  // m/s, of the centre
  Vector3d spin = Vector3d::Zero();      // rad/s

  RigidMotion(const Model& model, const State& state) {
    centre = model.centre_of_mass(state.x);
    const Momentum momentum = model.momentum(state);
    velocity = momentum.linear / model.masses().total();
    const Vector3d angular = momentum.angular - centre.cross(momentum.linear);
    Matrix3d inertia = Matrix3d::Zero();
    for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
      const Vector3d r = state.x.col(i) - centre;
      inertia +=
          model.mass()[static_cast<std::size_t>(i)] * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose());
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(inertia);
    constexpr double kNoInertia = 1e-12;  // -, of the largest: mass on a line has no inertia about it
    for (int c = 0; c < 3; ++c) {
      const double moment = eigen.eigenvalues()[c];
      const Vector3d axis = eigen.eigenvectors().col(c);
      if (moment > kNoInertia * eigen.eigenvalues()[2]) spin += axis.dot(angular) / moment * axis;
    }
  }
  [[nodiscard]] Vector3d at(const Vector3d& x) const { return velocity + spin.cross(x - centre); }
};

// Shrinks the deviation of each vertex's velocity from part(i), m/s, until the kinetic energy has fallen by `excess`,
// J, or no deviation is left. The kinetic energies of part and deviation add up. Returns the part of the excess that
// remains, J.
template <typename Part>
double take(const Model& model, const Part& part, double excess, State& state) {
  if (!(excess > 0.0)) return 0.0;
  double energy = 0.0;
  for (Eigen::Index i = 0; i < state.v.cols(); ++i) {
    energy += 0.5 * model.mass()[static_cast<std::size_t>(i)] * (state.v.col(i) - part(i)).squaredNorm();
  }
  const double share = energy > excess ? std::sqrt(1.0 - excess / energy) : 0.0;
  for (Eigen::Index i = 0; i < state.v.cols(); ++i) {
    const Vector3d kept = part(i);
    state.v.col(i) = kept + share * (state.v.col(i) - kept);
  }
  return std::max(0.0, excess - energy);
}

}  // namespace

EnergyGuard::Verdict EnergyGuard::enforce(const Model& model, const Loads& loads, const LocalInertia* inertia,
                                          double allowed_gain, const State& start, State& end) {
  if (!is_guarded(model, loads, start)) return Verdict::kKept;
  const double work = work_of_loads(model, loads, start, end);
  Energies at_start = model.energies(start, Vector3d::Zero());
  Energies at_end = model.energies(end, Vector3d::Zero());
  if (inertia != nullptr) {
    at_start.kinetic += inertia->added_energy(start.v);
    at_end.kinetic += inertia->added_energy(end.v);
  }
  const double before = elastic_energy(at_start) + at_start.kinetic;
  const double elastic = elastic_energy(at_end);
  const double allowed =
      before + work + allowed_gain * (before + std::abs(work)) + rounding_energy(model, start, elastic);
  double excess = elastic + at_end.kinetic - allowed;
  if (!(excess > 0.0)) return Verdict::kKept;
  bool leaves_motion = elastic <= allowed;
  if (loads.pins.empty()) {
    const RigidMotion rigid(model, end);
    excess = take(
        model, [&](Eigen::Index i) { return rigid.at(end.x.col(i)); }, excess, end);
    excess = take(
        model, [&](Eigen::Index) { return rigid.velocity; }, excess, end);
    leaves_motion = !(excess > 0.0);
  }
  take(
      model, [](Eigen::Index) { return Vector3d(Vector3d::Zero()); }, excess, end);
  return leaves_motion ? Verdict::kLimited : Verdict::kExceeded;
}

}  // namespace kerf::fem
