#include "render/views.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace kerf::render {

namespace {

constexpr double kMinRadius = 1e-4;  // m; smallest radius of the content, so that even a point has a view volume.
// Smallest near distance over far distance, -. With 24 depth bits, steps of depth at the far plane are 1.2e-4 of its
// distance.
constexpr double kMinNearOverFar = 5e-4;

double half_height(const Camera& camera) {
  return std::tan(camera.vertical_fov * std::numbers::pi / 360.0);  // At distance 1 from the eye.
}

Matrix4 view_from_world(const ViewAxes& axes, Vec3 origin) {
  Matrix4 matrix;
  const std::array<Vec3, 3> rows{axes.right, axes.up, axes.back};
  for (std::size_t row = 0; row < 3; ++row) {
    matrix.at(row, 0) = rows[row].x;
    matrix.at(row, 1) = rows[row].y;
    matrix.at(row, 2) = rows[row].z;
    matrix.at(row, 3) = -dot(rows[row], origin);
  }
  matrix.at(3, 3) = 1.0;
  return matrix;
}

struct DepthRange {
  double near;  // m, > 0
  double far;   // m, > near
};

DepthRange depth_range(const Camera& camera, const ViewAxes& axes, const Bounds& seen) {
  const Vec3 half = 0.5 * (seen.upper - seen.lower);
  const double middle = dot(camera.eye - centre(seen), axes.back);
  const double reach = std::abs(axes.back.x) * half.x + std::abs(axes.back.y) * half.y + std::abs(axes.back.z) * half.z;
  // Adds a hundredth on both sides, because lines are drawn a little nearer than their surface.
  const double margin = 0.01 * std::max({reach, std::abs(middle), kMinRadius});
  const double far = std::max(middle + reach + margin, kMinRadius);
  return {std::max(middle - reach - margin, kMinNearOverFar * far), far};
}

// Returns the axes of the light's view; back is towards the light.
ViewAxes light_axes(Vec3 to_light) {
  const Vec3 right = perpendicular(to_light);
  return {right, cross(to_light, right), to_light};
}

}  // namespace

ViewAxes view_axes(const Camera& camera) {
  const Vec3 back = normalized(camera.eye - camera.target);
  const Vec3 right = normalized(cross(normalized(camera.up), back));
  return {right, cross(back, right), back};
}

Views make_views(const Camera& camera, double aspect, int height, const Bounds& lit, const Bounds& seen,
                 const std::optional<Vec3>& towards_key) {
  const ViewAxes axes = view_axes(camera);
  const auto [near, far] = depth_range(camera, axes, seen);
  const double tangent = half_height(camera);

  Views views;
  Matrix4 clip_from_view;
  clip_from_view.at(0, 0) = 1.0 / (aspect * tangent);
  clip_from_view.at(1, 1) = 1.0 / tangent;
  clip_from_view.at(2, 2) = -(far + near) / (far - near);
  clip_from_view.at(2, 3) = -2.0 * far * near / (far - near);
  clip_from_view.at(3, 2) = -1.0;
  views.clip_from_world = clip_from_view * view_from_world(axes, camera.eye);
  views.depth_per_fraction = clip_from_view.at(2, 3);
  views.pixel_fraction = 2.0 * tangent / height;

  // Puts the light, unless it has a place, over the left shoulder, high enough to light ground under the scene from
  // above.
  const Vec3 over_shoulder = 0.95 * normalized(camera.up) + 0.45 * axes.back - 0.5 * axes.right;
  views.to_light = normalized(towards_key.value_or(over_shoulder));
  const double extent = std::max(radius(lit), kMinRadius) * 1.02;
  Matrix4 clip_from_light;
  for (std::size_t k = 0; k < 2; ++k) clip_from_light.at(k, k) = 1.0 / extent;
  clip_from_light.at(2, 2) = -1.0 / extent;
  clip_from_light.at(3, 3) = 1.0;
  views.shadow_from_world = clip_from_light * view_from_world(light_axes(views.to_light), centre(lit));
  views.shadow_extent = 2.0 * extent;
  return views;
}

bool is_empty(const Bounds& bounds) {
  return bounds.lower.x > bounds.upper.x || bounds.lower.y > bounds.upper.y || bounds.lower.z > bounds.upper.z;
}

void extend(Bounds& bounds, Vec3 point) {
  if (is_empty(bounds)) {
    bounds = {point, point};
    return;
  }
  bounds.lower = {std::min(bounds.lower.x, point.x), std::min(bounds.lower.y, point.y),
                  std::min(bounds.lower.z, point.z)};
  bounds.upper = {std::max(bounds.upper.x, point.x), std::max(bounds.upper.y, point.y),
                  std::max(bounds.upper.z, point.z)};
}

Vec3 centre(const Bounds& bounds) {
  return 0.5 * (bounds.lower + bounds.upper);
}

double radius(const Bounds& bounds) {
  return 0.5 * norm(bounds.upper - bounds.lower);
}

Bounds bounds_of(const Mesh& mesh) {
  Bounds bounds;
  for (std::size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
    extend(bounds, {static_cast<double>(mesh.positions[i]), static_cast<double>(mesh.positions[i + 1]),
                    static_cast<double>(mesh.positions[i + 2])});
  }
  return bounds;
}

Camera fit_camera(std::span<const float> positions, double aspect, Vec3 from, Vec3 up) {
  Camera camera;
  camera.up = up;
  camera.eye = camera.target + 2.0 * normalized(from);
  if (positions.size() < 3) return camera;

  // Margin on each side of the image, as a share of its size.
  constexpr double kMargin = 0.03;
  const ViewAxes axes = view_axes(camera);
  const double tangent_y = (1.0 - 2.0 * kMargin) * half_height(camera);
  const double tangent_x = tangent_y * aspect;
  // Works in coordinates along the camera's axes, with the eye at e. The sides of the frustum enclose the points p
  // where
  //    |p.x - e.x| <= tangent_x (e.z - p.z).
  // Each side touches the point farthest along its normal.
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  double right = kNone, left = kNone, upper = kNone, lower = kNone, front = kNone, behind = kNone;
  for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
    const Vec3 point{static_cast<double>(positions[i]), static_cast<double>(positions[i + 1]),
                     static_cast<double>(positions[i + 2])};
    const double x = dot(point, axes.right), y = dot(point, axes.up), z = dot(point, axes.back);
    right = std::max(right, tangent_x * z + x);
    left = std::max(left, tangent_x * z - x);
    upper = std::max(upper, tangent_y * z + y);
    lower = std::max(lower, tangent_y * z - y);
    front = std::max(front, z);
    behind = std::max(behind, -z);
  }
  const double depth = front + behind;
  const double eye_z = std::max({0.5 * (right + left) / tangent_x, 0.5 * (upper + lower) / tangent_y,
                                 front + std::max(0.05 * depth, kMinRadius)});
  const Vec3 on_axis = 0.5 * (right - left) * axes.right + 0.5 * (upper - lower) * axes.up;
  camera.eye = on_axis + eye_z * axes.back;
  camera.target = on_axis + (front - 0.5 * depth) * axes.back;
  return camera;
}

}  // namespace kerf::render
