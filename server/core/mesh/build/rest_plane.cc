#include "server/core/mesh/build/rest_plane.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace kerf::mesh {
namespace {

// Rounding moves a vertex by half a step along each axis; the best plane is that of rounded vertices, too.
constexpr double kRoundingShare = 0.75;

// Returns the sum of the triangles' area vectors. Components need not have one orientation, so a vector that points
// against the sum so far is turned round.
Eigen::Vector3d total_area(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xi& triangles) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    const Eigen::Vector3d a = world.col(triangles(0, t));
    const Eigen::Vector3d b = world.col(triangles(1, t));
    const Eigen::Vector3d c = world.col(triangles(2, t));
    const Eigen::Vector3d area = (b - a).cross(c - a);
    sum += sum.dot(area) < 0.0 ? Eigen::Vector3d(-area) : area;
  }
  return sum;
}

// Returns the axes of the plane across a unit vector. The first one is the projection of the world axis that is least
// along the normal.
std::pair<Eigen::Vector3d, Eigen::Vector3d> axes_across(const Eigen::Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Eigen::Vector3d u = (Eigen::Vector3d::Unit(axis) - normal[axis] * normal).normalized();
  return {u, normal.cross(u)};
}

double size_of(const Eigen::Matrix3Xd& world) {
  const Eigen::Vector3d extent = world.rowwise().maxCoeff() - world.rowwise().minCoeff();
  return extent.maxCoeff();
}

// Measures the heights over the plane, and computes coordinates if all are small enough.
void put_into_plane(const Eigen::Matrix3Xd& world, const Eigen::Vector3d& origin, const Eigen::Vector3d& normal,
                    PlaneFit& fit) {
  for (Eigen::Index v = 0; v < world.cols(); ++v) {
    const double height = std::abs(normal.dot(world.col(v) - origin));
    if (!(height > fit.height)) continue;
    fit.height = height;
    fit.farthest = v;
  }
  if (fit.height > fit.allowed) return;
  if (std::abs(normal.z()) > 1.0 - kFlatness) {
    fit.rest = world.topRows<2>();
    return;
  }
  const auto [u, w] = axes_across(normal);
  fit.rest.emplace(2, world.cols());
  for (Eigen::Index i = 0; i < world.cols(); ++i) {
    const Eigen::Vector3d offset = world.col(i) - origin;
    fit.rest->col(i) = Eigen::Vector2d(u.dot(offset), w.dot(offset));
  }
}

}  // namespace

PlaneFit fit_plane(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xi& triangles) {
  PlaneFit fit;
  const Eigen::Vector3d area = total_area(world, triangles);
  const double size = size_of(world);
  fit.has_normal = area.norm() > kFlatness * size * size;
  fit.allowed = kFlatness * size;
  if (fit.has_normal) put_into_plane(world, world.col(0), area.normalized(), fit);
  return fit;
}

PlaneFit fit_rounded_plane(const Eigen::Matrix3Xd& world, const Eigen::Matrix3Xi& triangles, double step, double most) {
  PlaneFit fit;
  const Eigen::Vector3d area = total_area(world, triangles);
  const double size = size_of(world);
  fit.has_normal = area.norm() > kFlatness * size * size;
  if (!fit.has_normal) return fit;
  const Eigen::Vector3d first = area.normalized();
  const auto [u, w] = axes_across(first);
  const Eigen::Vector3d middle = world.rowwise().mean();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d heights = Eigen::Vector2d::Zero();
  for (Eigen::Index v = 0; v < world.cols(); ++v) {
    const Eigen::Vector3d offset = world.col(v) - middle;
    const Eigen::Vector2d at(u.dot(offset), w.dot(offset));
    squares += at * at.transpose();
    heights += first.dot(offset) * at;
  }
  Eigen::Vector3d normal = first;
  if (std::abs(squares.determinant()) > 1e-12 * squares.trace() * squares.trace()) {
    const Eigen::Vector2d slope = squares.inverse() * heights;
    normal = (first - slope.x() * u - slope.y() * w).normalized();
  }
  fit.allowed = std::max(kFlatness * size, std::min(kRoundingShare * step * normal.cwiseAbs().sum(), most));
  put_into_plane(world, middle, normal, fit);
  return fit;
}

}  // namespace kerf::mesh
