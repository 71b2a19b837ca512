#pragma once

#include <Eigen/Core>

#include "server/core/contact/collider.h"

namespace kerf::contact {

// Signed distance of a point from the surface of a shape, and the normal there.
struct Proximity {
  double distance = 0.0;                  // m; true Euclidean distance to the surface, < 0 inside
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, unit; direction in which `distance` grows fastest
};

// A collider prepared for many queries: normals have length one, and rotations are matrices.
class PreparedCollider {
 public:
  enum class Kind { kPlane, kSphere, kBox, kCapsule };

  // `collider` must be valid.
  explicit PreparedCollider(const Collider& collider);

  // Returns the distance and normal at `point`, exact up to rounding. If several surface points are nearest, a fixed
  // rule picks one. This happens at the centre of a sphere, equally far from several faces of a box, and on the axis of
  // a capsule.
  [[nodiscard]] Proximity query(const Eigen::Vector3d& point) const;

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] double friction() const { return friction_; }
  // Returns the plane's point, the centre of a sphere or box, or the capsule's end a.  m
  [[nodiscard]] const Eigen::Vector3d& origin() const { return origin_; }
  // Returns the plane's unit normal (-), the half extents of a box (m), or b - a of a capsule (m).
  [[nodiscard]] const Eigen::Vector3d& vector() const { return vector_; }
  [[nodiscard]] const Eigen::Matrix3d& rotation() const { return rotation_; }  // box to world
  [[nodiscard]] double radius() const { return radius_; }                      // m
  // Returns a unit vector at right angles to the capsule's axis; it is the normal at points on the axis.  -
  [[nodiscard]] const Eigen::Vector3d& across() const { return across_; }

 private:
  void take(const Plane& plane);
  void take(const Sphere& sphere);
  void take(const OrientedBox& box);
  void take(const Capsule& capsule);
  [[nodiscard]] Proximity query_box(const Eigen::Vector3d& point) const;
  [[nodiscard]] Proximity query_capsule(const Eigen::Vector3d& point) const;

  Kind kind_ = Kind::kPlane;
  Eigen::Vector3d origin_{0.0, 0.0, 0.0};
  Eigen::Vector3d vector_{0.0, 0.0, 1.0};
  Eigen::Vector3d across_{0.0, 0.0, 1.0};
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  double radius_ = 0.0;
  double friction_ = 0.0;
};

}  // namespace kerf::contact
