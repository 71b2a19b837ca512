#include "server/core/contact/collider.h"

#include <algorithm>
#include <cmath>

#include "server/base/check.h"
#include "server/core/contact/prepared_collider.h"
#include "server/core/linear/rotation.h"

namespace kerf::contact {

namespace {

constexpr double kMaxWorldCoordinate = 1.0e6;  // m
constexpr double kMaxExtent = 1.0e4;           // m
constexpr double kMaxFriction = 10.0;          // -

Status refuse(const std::string& reason, const std::string& message, const std::string& field) {
  return invalid_argument(reason, field + ": " + message, field);
}

Status check_vector(const Eigen::Vector3d& value, const std::string& path) {
  constexpr const char* kComponents[] = {".x", ".y", ".z"};
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(value[k])) return refuse("NOT_FINITE", "must be finite", path + kComponents[k]);
    if (std::abs(value[k]) > kMaxWorldCoordinate) {
      return refuse("OUT_OF_RANGE", "must be within +-1e6, is " + std::to_string(value[k]), path + kComponents[k]);
    }
  }
  return Nothing{};
}

Status check_extent(double value, const std::string& path) {
  if (!std::isfinite(value)) return refuse("NOT_FINITE", "must be finite", path);
  if (value <= 0.0 || value > kMaxExtent) {
    return refuse("OUT_OF_RANGE", "must be > 0 and <= 1e4 m, is " + std::to_string(value), path);
  }
  return Nothing{};
}

Status validate_shape(const Plane& plane, const std::string& path) {
  KERF_TRY(check_vector(plane.point, path + ".plane.point"));
  KERF_TRY(check_vector(plane.normal, path + ".plane.normal"));
  if (!(plane.normal.stableNorm() > 0.0)) {
    return refuse("NORMAL_ZERO", "must not be the zero vector", path + ".plane.normal");
  }
  return Nothing{};
}

Status validate_shape(const Sphere& sphere, const std::string& path) {
  KERF_TRY(check_vector(sphere.centre, path + ".sphere.center"));
  return check_extent(sphere.radius, path + ".sphere.radius_m");
}

Status validate_shape(const OrientedBox& box, const std::string& path) {
  KERF_TRY(check_vector(box.centre, path + ".box.center"));
  constexpr const char* kComponents[] = {".x", ".y", ".z"};
  for (int k = 0; k < 3; ++k) {
    KERF_TRY(check_extent(box.half_extents[k], path + ".box.half_extents_m" + kComponents[k]));
  }
  KERF_TRY(check_vector(box.axis, path + ".box.axis"));
  if (!std::isfinite(box.angle)) return refuse("NOT_FINITE", "must be finite", path + ".box.angle_rad");
  return Nothing{};
}

Status validate_shape(const Capsule& capsule, const std::string& path) {
  KERF_TRY(check_vector(capsule.a, path + ".capsule.a"));
  KERF_TRY(check_vector(capsule.b, path + ".capsule.b"));
  return check_extent(capsule.radius, path + ".capsule.radius_m");
}

double sign_of(double value) {
  return value < 0.0 ? -1.0 : 1.0;
}

// Returns a unit vector at right angles to `direction` (not zero) and to the axis of its smallest component, the first
// of equals.
Eigen::Vector3d perpendicular(const Eigen::Vector3d& direction) {
  int smallest = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(direction[k]) < std::abs(direction[smallest])) smallest = k;
  }
  const Eigen::Vector3d across = direction.cross(Eigen::Vector3d::Unit(smallest));
  return across.stableNormalized();
}

// Returns the distance and normal of a point at `offset` from the axis or centre of a round body. The normal is
// `fallback` if the offset is zero.
Proximity round_proximity(const Eigen::Vector3d& offset, double radius, const Eigen::Vector3d& fallback) {
  const double length = offset.stableNorm();
  if (length == 0.0) return {-radius, fallback};
  return {length - radius, offset / length};
}

}  // namespace

Status validate(const Collider& collider, const std::string& path) {
  KERF_TRY(std::visit([&](const auto& s) { return validate_shape(s, path); }, collider.shape));
  if (!std::isfinite(collider.friction)) return refuse("NOT_FINITE", "must be finite", path + ".friction");
  if (collider.friction < 0.0 || collider.friction > kMaxFriction) {
    return refuse("OUT_OF_RANGE", "must be in 0..10, is " + std::to_string(collider.friction), path + ".friction");
  }
  return Nothing{};
}

PreparedCollider::PreparedCollider(const Collider& collider) : friction_(collider.friction) {
  std::visit([this](const auto& shape) { take(shape); }, collider.shape);
}

void PreparedCollider::take(const Plane& plane) {
  kind_ = Kind::kPlane;
  origin_ = plane.point;
  vector_ = plane.normal.stableNormalized();
}

void PreparedCollider::take(const Sphere& sphere) {
  kind_ = Kind::kSphere;
  origin_ = sphere.centre;
  radius_ = sphere.radius;
}

void PreparedCollider::take(const OrientedBox& box) {
  kind_ = Kind::kBox;
  origin_ = box.centre;
  vector_ = box.half_extents;
  if (box.axis.stableNorm() > 0.0) {
    rotation_ = linear::rotation_about(box.axis.stableNormalized(), box.angle);
  }
}

void PreparedCollider::take(const Capsule& capsule) {
  kind_ = Kind::kCapsule;
  origin_ = capsule.a;
  vector_ = capsule.b - capsule.a;
  if (!vector_.isZero(0.0)) across_ = perpendicular(vector_);
  radius_ = capsule.radius;
}

Proximity PreparedCollider::query(const Eigen::Vector3d& point) const {
  switch (kind_) {
    case Kind::kPlane:
      return {(point - origin_).dot(vector_), vector_};
    case Kind::kSphere:
      return round_proximity(point - origin_, radius_, Eigen::Vector3d::UnitZ());
    case Kind::kBox:
      return query_box(point);
    case Kind::kCapsule:
      return query_capsule(point);
  }
  check_failed("kind_", __FILE__, __LINE__, "unknown shape");
}

Proximity PreparedCollider::query_box(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d local = rotation_.transpose() * (point - origin_);
  const Eigen::Vector3d excess = local.cwiseAbs() - vector_;  // m, how far the point is outside the box along each of
                                                              // its axes; below 0 inside
  if (excess.maxCoeff() > 0.0) {
    Eigen::Vector3d outward = excess.cwiseMax(0.0);
    for (int k = 0; k < 3; ++k) outward[k] *= sign_of(local[k]);
    const double distance = outward.stableNorm();
    return {distance, rotation_ * (outward / distance)};
  }
  int nearest = 0;  // axis of the nearest face, the first of equals
  for (int k = 1; k < 3; ++k) {
    if (excess[k] > excess[nearest]) nearest = k;
  }
  return {excess[nearest], rotation_.col(nearest) * sign_of(local[nearest])};
}

Proximity PreparedCollider::query_capsule(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d from_a = point - origin_;
  const double length_squared = vector_.squaredNorm();
  if (length_squared == 0.0) return round_proximity(from_a, radius_, Eigen::Vector3d::UnitZ());
  const double t = std::min(std::max(from_a.dot(vector_) / length_squared, 0.0), 1.0);
  const Eigen::Vector3d offset = from_a - t * vector_;
  if (offset.isZero(0.0)) return {-radius_, across_};
  return round_proximity(offset, radius_, Eigen::Vector3d::UnitZ());
}

}  // namespace kerf::contact
