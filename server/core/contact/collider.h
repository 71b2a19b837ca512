#pragma once

#include <string>
#include <variant>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/result.h"

// Fixed bodies that a sheet rests on, and the signed distance to them. World coordinates, metres.
namespace kerf::contact {

// A solid half-space; the sheet stays on the side to which the normal points.
struct Plane {
  Eigen::Vector3d point{0.0, 0.0, 0.0};   // m, |component| <= 1e6; any point of the surface
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, outwards from the solid, any length > 0
};

struct Sphere {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};  // m
  double radius = 1.0;                    // m, > 0, <= 1e4
};

struct OrientedBox {
  Eigen::Vector3d centre{0.0, 0.0, 0.0};        // m
  Eigen::Vector3d half_extents{0.5, 0.5, 0.5};  // m, each > 0, <= 1e4
  Eigen::Vector3d axis{0.0, 0.0, 0.0};          // -, rotation axis, any length; zero: no rotation
  double angle = 0.0;                           // rad, about `axis`, right-handed
};

// All points within `radius` of the segment from a to b; a sphere if a = b.
struct Capsule {
  Eigen::Vector3d a{0.0, 0.0, 0.0};  // m
  Eigen::Vector3d b{0.0, 0.0, 1.0};  // m
  double radius = 0.1;               // m, > 0, <= 1e4
};

using Shape = std::variant<Plane, Sphere, OrientedBox, Capsule>;

struct Collider {
  Shape shape;
  double friction = 0.0;  // -, Coulomb's friction coefficient, in [0, 10]
};

// Refuses values that are not finite or outside the ranges above. Errors are kInvalidArgument NOT_FINITE, OUT_OF_RANGE
// or NORMAL_ZERO. `path` precedes the field's name in the error ("colliders[2]" -> "colliders[2].sphere.radius_m").
// Field names are those of kerf.v1.Collider.
Status validate(const Collider& collider, const std::string& path);

}  // namespace kerf::contact
