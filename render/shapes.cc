#include "render/shapes.h"

#include <cmath>
#include <numbers>

namespace kerf::render {

namespace {

constexpr int kSegments = 64;  // Around a sphere or capsule.
constexpr int kRings = 16;     // From the equator of a sphere or cap to its pole.

SurfaceVertex vertex(Vec3 position, Vec3 normal) {
  return {{static_cast<float>(position.x), static_cast<float>(position.y), static_cast<float>(position.z)},
          {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)},
          {0.0F, 0.0F},
          {128, 128, 128, 128}};
}

void append_quad(const std::array<SurfaceVertex, 4>& quad, std::vector<SurfaceVertex>& out) {
  for (const std::size_t corner : {0U, 1U, 2U, 0U, 2U, 3U}) out.push_back(quad[corner]);
}

// Returns a point of the capsule's surface. `ring` is in [-kRings, kRings + 1]; rings 0 and 1 are the two ends of the
// cylinder.
SurfaceVertex capsule_vertex(const Capsule& capsule, const ViewAxes& axes, int ring, int segment) {
  const bool at_end = ring > 0;
  const double latitude = std::numbers::pi / 2.0 * (at_end ? ring - 1 : ring) / kRings;
  const double longitude = 2.0 * std::numbers::pi * (segment % kSegments) / kSegments;
  const Vec3 normal = std::cos(latitude) * (std::cos(longitude) * axes.right + std::sin(longitude) * axes.up) +
                      std::sin(latitude) * axes.back;
  return vertex((at_end ? capsule.end : capsule.start) + capsule.radius * normal, normal);
}

std::array<Vec3, 3> rotated_axes(const std::array<double, 4>& quaternion) {
  double square = 0.0;
  for (const double component : quaternion) square += component * component;
  const double s = 2.0 / square;
  const auto [w, x, y, z] = quaternion;
  return {Vec3{1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
          Vec3{s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)},
          Vec3{s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)}};
}

std::array<Vec3, 3> scaled_axes(const Box& box) {
  const std::array<Vec3, 3> axes = rotated_axes(box.rotation);
  return {box.half_extents.x * axes[0], box.half_extents.y * axes[1], box.half_extents.z * axes[2]};
}

void extend_by_ball(Bounds& bounds, Vec3 centre, double radius) {
  const Vec3 reach{radius, radius, radius};
  extend(bounds, centre - reach);
  extend(bounds, centre + reach);
}

void extend_by(Bounds& bounds, const Sphere& sphere) {
  extend_by_ball(bounds, sphere.centre, sphere.radius);
}

void extend_by(Bounds& /*bounds*/, const Plane& /*endless*/) {}

void extend_by(Bounds& bounds, const Box& box) {
  const std::array<Vec3, 3> axes = scaled_axes(box);
  const Vec3 reach{std::abs(axes[0].x) + std::abs(axes[1].x) + std::abs(axes[2].x),
                   std::abs(axes[0].y) + std::abs(axes[1].y) + std::abs(axes[2].y),
                   std::abs(axes[0].z) + std::abs(axes[1].z) + std::abs(axes[2].z)};
  extend(bounds, box.centre - reach);
  extend(bounds, box.centre + reach);
}

void extend_by(Bounds& bounds, const Capsule& capsule) {
  extend_by_ball(bounds, capsule.start, capsule.radius);
  extend_by_ball(bounds, capsule.end, capsule.radius);
}

}  // namespace

void append_sphere(const Sphere& sphere, std::vector<SurfaceVertex>& out) {
  append_capsule({sphere.centre, sphere.centre, sphere.radius}, out);
}

void append_capsule(const Capsule& capsule, std::vector<SurfaceVertex>& out) {
  const Vec3 along = capsule.end - capsule.start;
  const double length = norm(along);
  const Vec3 axis = length > 0.0 ? (1.0 / length) * along : Vec3{0.0, 0.0, 1.0};
  const Vec3 right = perpendicular(axis);
  const ViewAxes axes{right, cross(axis, right), axis};
  for (int ring = -kRings; ring <= kRings; ++ring) {
    if (ring == 0 && length == 0.0) continue;  // A sphere has no cylinder.
    for (int segment = 0; segment < kSegments; ++segment) {
      append_quad(
          {capsule_vertex(capsule, axes, ring, segment), capsule_vertex(capsule, axes, ring, segment + 1),
           capsule_vertex(capsule, axes, ring + 1, segment + 1), capsule_vertex(capsule, axes, ring + 1, segment)},
          out);
    }
  }
}

void append_box(const Box& box, std::vector<SurfaceVertex>& out) {
  const std::array<Vec3, 3> axes = scaled_axes(box);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 u = axes[(k + 1) % 3];
    const Vec3 v = axes[(k + 2) % 3];
    for (const double side : {1.0, -1.0}) {
      const Vec3 middle = box.centre + side * axes[k];
      const Vec3 normal = normalized(side * axes[k]);
      const Vec3 first = side * u;  // Reverses the order on the far side, so that every face looks outwards.
      append_quad({vertex(middle - first - v, normal), vertex(middle + first - v, normal),
                   vertex(middle + first + v, normal), vertex(middle - first + v, normal)},
                  out);
    }
  }
}

void extend(Bounds& bounds, const Collider& collider) {
  std::visit([&bounds](const auto& shape) { extend_by(bounds, shape); }, collider);
}

}  // namespace kerf::render
