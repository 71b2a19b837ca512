#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "render/linear.h"
#include "render/renderer.h"

namespace kerf::render {

namespace {

constexpr double kMinViewDistance = 1e-6;  // m, between eye and target; any shorter, and the view direction is noise.
constexpr double kMinUpSine = 1e-3;        // -, sine of the angle between up and the view direction.

Status invalid(std::string reason, std::string field, std::string message) {
  return {StatusCode::kInvalidArgument, std::move(reason), std::move(message), std::move(field)};
}

Status check_point(Vec3 point, const std::string& field) {
  if (!is_finite(point)) return invalid("NOT_FINITE", field, field + " must be finite");
  if (std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)}) > kMaxCoordinate) {
    return invalid("LIMIT_EXCEEDED", field, field + " must be within 1e6 m of the origin in each coordinate");
  }
  return {};
}

Status check_length(double length, const std::string& field) {
  if (!std::isfinite(length)) return invalid("NOT_FINITE", field, field + " must be finite");
  if (length <= 0.0) return invalid("SHAPE_DEGENERATE", field, field + " must be greater than 0");
  if (length > kMaxCoordinate) return invalid("LIMIT_EXCEEDED", field, field + " must be at most 1e6 m");
  return {};
}

Status check_shape(const Sphere& sphere, const std::string& field) {
  if (Status status = check_point(sphere.centre, field + ".centre"); !status.ok()) return status;
  return check_length(sphere.radius, field + ".radius");
}

Status check_shape(const Plane& plane, const std::string& field) {
  if (Status status = check_point(plane.point, field + ".point"); !status.ok()) return status;
  if (Status status = check_point(plane.normal, field + ".normal"); !status.ok()) return status;
  if (norm(plane.normal) < 1e-9) {
    return invalid("SHAPE_DEGENERATE", field + ".normal", field + ".normal must not be zero");
  }
  return {};
}

Status check_shape(const Box& box, const std::string& field) {
  if (Status status = check_point(box.centre, field + ".centre"); !status.ok()) return status;
  for (const double length : {box.half_extents.x, box.half_extents.y, box.half_extents.z}) {
    if (Status status = check_length(length, field + ".half_extents"); !status.ok()) return status;
  }
  double square = 0.0;
  for (const double component : box.rotation) square += component * component;
  if (!std::isfinite(square)) return invalid("NOT_FINITE", field + ".rotation", field + ".rotation must be finite");
  if (square < 1e-18) {
    return invalid("SHAPE_DEGENERATE", field + ".rotation", field + ".rotation must not be the zero quaternion");
  }
  return {};
}

Status check_shape(const Capsule& capsule, const std::string& field) {
  if (Status status = check_point(capsule.start, field + ".start"); !status.ok()) return status;
  if (Status status = check_point(capsule.end, field + ".end"); !status.ok()) return status;
  return check_length(capsule.radius, field + ".radius");
}

Status check_colour(const Colour& colour, const std::string& field) {
  for (const double channel : {colour.red, colour.green, colour.blue}) {
    if (!(channel >= 0.0 && channel <= 1.0)) {
      return invalid("COLOUR_OUT_OF_RANGE", field, "each channel of " + field + " must be in [0, 1]");
    }
  }
  return {};
}

Status check_coordinates(std::span<const float> values, const std::string& field) {
  const bool within = std::ranges::all_of(
      values, [](float value) { return std::abs(static_cast<double>(value)) <= kMaxCoordinate; });  // The comparison is
                                                                                                    // false for NaN.
  if (within) return {};
  const bool finite = std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
  return finite ? invalid("LIMIT_EXCEEDED", field, field + " must be within 1e6 m of the origin in each coordinate")
                : invalid("NOT_FINITE", field, field + " must be finite");
}

Status check_array_sizes(const Mesh& mesh) {
  if (mesh.positions.size() % 3 != 0) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.positions", "positions must hold 3 numbers a vertex");
  }
  if (mesh.triangles.size() % 3 != 0) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.triangles", "triangles must hold 3 vertex ids a triangle");
  }
  if (mesh.triangles.size() / 3 > kMaxTriangles) {
    return invalid("LIMIT_EXCEEDED", "scene.mesh.triangles",
                   std::to_string(mesh.triangles.size() / 3) + " triangles; at most " + std::to_string(kMaxTriangles));
  }
  if (!mesh.material_coordinates.empty() && mesh.material_coordinates.size() / 2 != mesh.positions.size() / 3) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.material_coordinates",
                   "material_coordinates must hold 2 numbers a vertex, or none");
  }
  if (!mesh.piece_ids.empty() && mesh.piece_ids.size() != mesh.triangles.size() / 3) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.piece_ids", "piece_ids must hold 1 id a triangle, or none");
  }
  if (!mesh.looks.empty() && mesh.looks.size() != mesh.triangles.size() / 3) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.looks", "looks must hold 1 number a triangle, or none");
  }
  if (!mesh.vertex_colours.empty() && mesh.vertex_colours.size() != mesh.positions.size()) {
    return invalid("ARRAY_SIZE_MISMATCH", "scene.mesh.vertex_colours",
                   "vertex_colours must hold 3 numbers a vertex, or none");
  }
  return {};
}

Status check_mesh(const Mesh& mesh) {
  if (Status status = check_array_sizes(mesh); !status.ok()) return status;
  if (Status status = check_coordinates(mesh.positions, "scene.mesh.positions"); !status.ok()) return status;
  if (Status status = check_coordinates(mesh.material_coordinates, "scene.mesh.material_coordinates"); !status.ok()) {
    return status;
  }
  if (Status status = check_coordinates(mesh.material_lower, "scene.mesh.material_lower"); !status.ok()) return status;
  if (Status status = check_coordinates(mesh.material_upper, "scene.mesh.material_upper"); !status.ok()) return status;
  const auto num_vertices = static_cast<std::int64_t>(mesh.positions.size() / 3);
  const auto outside =
      std::ranges::find_if(mesh.triangles, [&](std::int32_t vertex) { return vertex < 0 || vertex >= num_vertices; });
  if (outside != mesh.triangles.end()) {
    return invalid("INDEX_OUT_OF_RANGE", "scene.mesh.triangles",
                   "vertex id " + std::to_string(*outside) + "; there are " + std::to_string(num_vertices));
  }
  if (std::ranges::any_of(mesh.piece_ids, [](std::int32_t piece) { return piece < 0; })) {
    return invalid("INDEX_OUT_OF_RANGE", "scene.mesh.piece_ids", "piece ids must not be negative");
  }
  return {};
}

Status check_look(const Look& look, const std::string& field) {
  const std::array<std::pair<const Colour*, const char*>, 6> colours{{{&look.front, ".front"},
                                                                      {&look.back, ".back"},
                                                                      {&look.lips, ".lips"},
                                                                      {&look.finish.front_dye, ".finish.front_dye"},
                                                                      {&look.finish.back_dye, ".finish.back_dye"},
                                                                      {&look.finish.second, ".finish.second"}}};
  for (const auto& [colour, name] : colours) {
    if (Status status = check_colour(*colour, field + name); !status.ok()) return status;
  }
  return {};
}

Status check_surroundings(const Style& style) {
  const std::array<std::pair<const Colour*, const char*>, 4> colours{{{&style.background, "scene.style.background"},
                                                                      {&style.ground, "scene.style.ground"},
                                                                      {&style.ground_lines, "scene.style.ground_lines"},
                                                                      {&style.solids, "scene.style.solids"}}};
  for (const auto& [colour, field] : colours) {
    if (Status status = check_colour(*colour, field); !status.ok()) return status;
  }
  if (style.background_below) {
    if (Status s = check_colour(*style.background_below, "scene.style.background_below"); !s.ok()) return s;
  }
  if (!style.light.towards_key) return {};
  if (Status s = check_point(*style.light.towards_key, "scene.style.light.towards_key"); !s.ok()) return s;
  if (norm(*style.light.towards_key) > 1e-9) return {};
  return invalid("SHAPE_DEGENERATE", "scene.style.light.towards_key", "the direction of the key light is zero");
}

Status check_looks(const Scene& scene) {
  const std::vector<Look>& looks = scene.style.looks;
  if (looks.empty() || looks.size() > kMaxLooks) {
    return invalid("LIMIT_EXCEEDED", "scene.style.looks",
                   std::to_string(looks.size()) + " looks; must be 1 to " + std::to_string(kMaxLooks));
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (Status status = check_look(looks[i], "scene.style.looks[" + std::to_string(i) + "]"); !status.ok()) {
      return status;
    }
  }
  const auto count = static_cast<std::int32_t>(looks.size());
  if (std::ranges::any_of(scene.mesh.looks, [count](std::int32_t look) { return look < 0 || look >= count; })) {
    return invalid("INDEX_OUT_OF_RANGE", "scene.mesh.looks", "there are " + std::to_string(count) + " looks");
  }
  return {};
}

}  // namespace

Status validate(const Camera& camera) {
  const std::array<std::pair<Vec3, const char*>, 3> vectors{
      {{camera.eye, "camera.eye"}, {camera.target, "camera.target"}, {camera.up, "camera.up"}}};
  for (const auto& [vector, field] : vectors) {
    Status status = check_point(vector, field);
    if (status.reason == "NOT_FINITE") status.reason = "CAMERA_NOT_FINITE";
    if (!status.ok()) return status;
  }
  if (!std::isfinite(camera.vertical_fov)) {
    return invalid("CAMERA_NOT_FINITE", "camera.vertical_fov", "camera.vertical_fov must be finite");
  }
  if (camera.vertical_fov < 1.0 || camera.vertical_fov > 179.0) {
    return invalid("FOV_OUT_OF_RANGE", "camera.vertical_fov",
                   "camera.vertical_fov is " + std::to_string(camera.vertical_fov) + " degrees; must be in [1, 179]");
  }
  const Vec3 view = camera.target - camera.eye;
  if (norm(view) < kMinViewDistance) {
    return invalid("CAMERA_SINGULAR", "camera.target", "camera.target must differ from camera.eye by 1e-6 m or more");
  }
  if (norm(camera.up) < 1e-9) return invalid("CAMERA_SINGULAR", "camera.up", "camera.up must not be zero");
  if (norm(cross(normalized(view), normalized(camera.up))) < kMinUpSine) {
    return invalid("CAMERA_SINGULAR", "camera.up",
                   "camera.up must be at least 0.001 rad off the direction from camera.eye to camera.target");
  }
  return {};
}

Status validate_size(int width, int height) {
  const std::array<std::pair<int, const char*>, 2> sides{{{width, "width"}, {height, "height"}}};
  for (const auto& [side, field] : sides) {
    if (side < kMinImageSize || side > kMaxImageSize) {
      return invalid("SIZE_OUT_OF_RANGE", field,
                     std::string(field) + " is " + std::to_string(side) + " pixels; must be in [" +
                         std::to_string(kMinImageSize) + ", " + std::to_string(kMaxImageSize) + "]");
    }
  }
  return {};
}

Status validate(const Scene& scene) {
  if (Status status = check_mesh(scene.mesh); !status.ok()) return status;
  if (scene.colliders.size() > kMaxColliders) {
    return invalid("LIMIT_EXCEEDED", "scene.colliders",
                   std::to_string(scene.colliders.size()) + " colliders; at most " + std::to_string(kMaxColliders));
  }
  for (std::size_t i = 0; i < scene.colliders.size(); ++i) {
    const std::string field = "scene.colliders[" + std::to_string(i) + "]";
    Status status = std::visit([&](const auto& shape) { return check_shape(shape, field); }, scene.colliders[i]);
    if (!status.ok()) return status;
  }
  if (scene.ground) {
    if (Status status = check_shape(*scene.ground, "scene.ground"); !status.ok()) return status;
  }
  if (Status status = check_surroundings(scene.style); !status.ok()) return status;
  return check_looks(scene);
}

Status validate(const Scene& scene, const Camera& camera, int width, int height) {
  if (Status status = validate_size(width, height); !status.ok()) return status;
  if (Status status = validate(camera); !status.ok()) return status;
  return validate(scene);
}

}  // namespace kerf::render
