#include "server/contact/contact_solver.h"

#include <algorithm>

namespace kerf::contact {

namespace {

// `along` shortened by at most `limit`, never turned round.
Eigen::Vector3d lessened(const Eigen::Vector3d& along, double limit) {
  const double length = along.stableNorm();
  if (length <= limit) return Eigen::Vector3d::Zero();
  return along * (1.0 - limit / length);
}

// Pushes one vertex out of one collider. Returns whether it had to.
bool push_out(const PreparedCollider& collider, double thickness, const Eigen::Vector3d& x_before, Eigen::Vector3d& x,
              Eigen::Vector3d& v) {
  const Proximity near = collider.query(x);
  if (near.distance >= thickness) return false;
  const Eigen::Vector3d& n = near.normal;
  const double mu = collider.friction();

  const double depth = thickness - near.distance;
  if (mu > 0.0) {
    const Eigen::Vector3d u = x - x_before;
    const Eigen::Vector3d u_t = u - u.dot(n) * n;
    x += lessened(u_t, mu * depth) - u_t;
  }
  x += depth * n;

  const double v_n = v.dot(n);
  if (v_n < 0.0) {
    const Eigen::Vector3d v_t = v - v_n * n;
    v = mu > 0.0 ? lessened(v_t, mu * -v_n) : v_t;
  }
  return true;
}

// Squared sine of the angle between walls below which they count as parallel.
constexpr double kLeastSineSquared = 1.0e-6;

void stop_approach(const Eigen::Vector3d& n, Eigen::Vector3d& v) {
  v -= std::min(v.dot(n), 0.0) * n;
}

}  // namespace

void ContactSolver::set_colliders(std::span<const Collider> colliders) {
  colliders_.clear();
  colliders_.reserve(colliders.size());
  for (const Collider& collider : colliders) colliders_.emplace_back(collider);
}

void ContactSolver::resolve(double thickness, std::span<const std::uint8_t> fixed, const mesh::VertexField& x_before,
                            mesh::VertexField& x, mesh::VertexField& v) {
  if (colliders_.empty()) return;
  KERF_CHECK(x.cols() == v.cols() && x.cols() == x_before.cols(), "positions and velocities of different meshes");
  KERF_CHECK(fixed.empty() || static_cast<Eigen::Index>(fixed.size()) == x.cols(), "pin mask of another mesh");
  ++counters_.phases;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    if (!fixed.empty() && fixed[static_cast<std::size_t>(i)] != 0) continue;
    Eigen::Vector3d position = x.col(i);
    Eigen::Vector3d velocity = v.col(i);
    if (!resolve_vertex(thickness, x_before.col(i), position, velocity)) continue;
    x.col(i) = position;
    v.col(i) = velocity;
  }
}

bool ContactSolver::resolve_vertex(double thickness, const Eigen::Vector3d& x_before, Eigen::Vector3d& x,
                                   Eigen::Vector3d& v) {
  bool touched = false;
  bool pushed = true;
  for (int pass = 0; pass < kPasses && pushed; ++pass) {
    pushed = false;
    for (const PreparedCollider& collider : colliders_) {
      if (!push_out(collider, thickness, x_before, x, v)) continue;
      pushed = true;
      ++counters_.contacts;
    }
    touched = touched || pushed;
  }
  if (pushed && colliders_.size() > 1) leave_notch(thickness, x, v);
  return touched;
}

void ContactSolver::leave_notch(double thickness, Eigen::Vector3d& x, Eigen::Vector3d& v) const {
  for (int round = 0; round < kNotchRounds; ++round) {
    const Penetration first = deepest(thickness, x);
    if (first.collider == nullptr) return;
    x += first.depth * first.normal;
    stop_approach(first.normal, v);
    const Penetration second = deepest(thickness, x);
    if (second.collider == nullptr) return;
    // Along the first surface, out of the second.
    const Eigen::Vector3d along = second.normal - second.normal.dot(first.normal) * first.normal;
    const double sine_squared = along.squaredNorm();
    if (sine_squared < kLeastSineSquared) return;
    x += second.depth / sine_squared * along;
    stop_approach(second.normal, v);
    if (v.dot(first.normal) < 0.0) {  // what stopped it at one wall sends it into the other: only the way along both
      v -= v.dot(along) / sine_squared * along;
      v -= v.dot(first.normal) * first.normal;
    }
  }
}

ContactSolver::Penetration ContactSolver::deepest(double thickness, const Eigen::Vector3d& x) const {
  Penetration found;
  found.depth = kTouching;
  for (const PreparedCollider& collider : colliders_) {
    const Proximity near = collider.query(x);
    const double depth = thickness - near.distance;
    if (depth > found.depth) found = {&collider, depth, near.normal};
  }
  return found;
}

}  // namespace kerf::contact
