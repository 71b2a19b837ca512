#include "render/draw_list.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "render/borders.h"
#include "render/ground.h"
#include "render/shapes.h"
#include "render/sheet_shape.h"

namespace kerf::render {

namespace {

constexpr float kChecksAlongLongerSide = 10.0F;  // Pairs of a light and a dark band.
constexpr double kGroundRadius = 4.0;            // Radius of the ground's disc over the radius of the things on it.
constexpr double kRidgeLength = 0.03;  // Radius of the ridges drawn lightest, as a share of the sheet's diagonal.

struct TextureFrame {
  std::array<float, 2> origin{0.0F, 0.0F};  // m
  float checks_per_metre = 0.0F;            // 1/m; 0: no texture
};

TextureFrame texture_frame(const Mesh& mesh) {
  std::array<float, 2> lower = mesh.material_lower;
  std::array<float, 2> upper = mesh.material_upper;
  if (mesh.material_coordinates.size() >= 2 && lower == upper) {
    lower = upper = {mesh.material_coordinates[0], mesh.material_coordinates[1]};
    for (std::size_t i = 0; i < mesh.material_coordinates.size(); ++i) {
      lower[i % 2] = std::min(lower[i % 2], mesh.material_coordinates[i]);
      upper[i % 2] = std::max(upper[i % 2], mesh.material_coordinates[i]);
    }
  }
  const float side = std::max(upper[0] - lower[0], upper[1] - lower[1]);
  return {lower, mesh.material_coordinates.empty() || side <= 0.0F ? 0.0F : kChecksAlongLongerSide / side};
}

// Returns the tint of a piece. Piece 0 keeps the sheet's colours; the hues of consecutive other pieces are a golden
// angle apart.
std::array<std::uint8_t, 4> piece_tint(std::int32_t piece) {
  std::array<std::uint8_t, 4> tint{128, 128, 128, 255};
  if (piece == 0) return tint;
  const double hue = 2.0 * std::numbers::pi * std::fmod(piece * std::numbers::phi, 1.0);
  for (std::size_t k = 0; k < 3; ++k) {
    const double factor = 1.0 + 0.32 * std::cos(hue - 2.0 * std::numbers::pi / 3.0 * static_cast<double>(k));
    tint[k] = static_cast<std::uint8_t>(std::lround(128.0 * factor));
  }
  return tint;
}

std::array<std::uint8_t, 4> own_colour(const Mesh& mesh, std::size_t vertex) {
  const std::uint8_t* colour = &mesh.vertex_colours[3 * vertex];
  return {colour[0], colour[1], colour[2], 255};
}

std::vector<SurfaceVertex> sheet_vertices(const Mesh& mesh, const TextureFrame& texture,
                                          const std::vector<Float3>& normals, double ridge_length) {
  const std::vector<float> heights = ridges(mesh, normals, ridge_length);
  std::vector<SurfaceVertex> vertices;
  vertices.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto vertex = static_cast<std::size_t>(mesh.triangles[i]);
    std::array<float, 2> material{0.0F, 0.0F};
    if (!mesh.material_coordinates.empty()) {
      for (std::size_t k = 0; k < 2; ++k) {
        material[k] = (mesh.material_coordinates[2 * vertex + k] - texture.origin[k]) * texture.checks_per_metre;
      }
    }
    vertices.push_back({position(mesh, mesh.triangles[i]), normals[vertex], material,
                        mesh.vertex_colours.empty() ? piece_tint(mesh.piece_ids.empty() ? 0 : mesh.piece_ids[i / 3])
                                                    : own_colour(mesh, vertex),
                        look_of(mesh, i / 3)});
    vertices.back().tint[3] = static_cast<std::uint8_t>(128.5F + 127.0F * heights[vertex]);
  }
  return vertices;
}

// Adds the ground on `plane` to the list and extends `seen` by it. `lit` bounds the things that stand on the ground.
void add_ground(const Plane& plane, const Bounds& lit, Bounds& seen, DrawList& list) {
  const std::size_t first = list.ground.size();
  append_ground(plane, centre(lit), kGroundRadius * std::max(radius(lit), 1e-3), list.style.shadows, list);
  for (std::size_t i = first; i < list.ground.size(); ++i) {
    const Float3& p = list.ground[i].position;
    extend(seen, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  }
}

void add_solid(const Sphere& sphere, DrawList& list) {
  append_sphere(sphere, list.solids);
}

void add_solid(const Plane& /*ground*/, DrawList& /*list*/) {}

void add_solid(const Box& box, DrawList& list) {
  append_box(box, list.solids);
}

void add_solid(const Capsule& capsule, DrawList& list) {
  append_capsule(capsule, list.solids);
}

}  // namespace

DrawList make_draw_list(const Scene& scene, const Camera& camera, int width, int height) {
  DrawList list;
  list.width = width;
  list.height = height;
  list.style = scene.style;
  list.eye = camera.eye;
  list.up = normalized(camera.up);

  const TextureFrame texture = texture_frame(scene.mesh);
  list.textured = scene.style.texture && texture.checks_per_metre > 0.0F;
  list.coloured = !scene.mesh.vertex_colours.empty();
  Bounds lit = bounds_of(scene.mesh);
  list.sheet_size = 2.0 * radius(lit);
  const std::vector<Float3> normals = vertex_normals(scene.mesh);
  list.sheet = sheet_vertices(scene.mesh, texture, normals, kRidgeLength * list.sheet_size);
  if (scene.style.borders) list.borders = border_segments(scene.mesh, normals);

  for (const Collider& collider : scene.colliders) {
    extend(lit, collider);
    std::visit([&list](const auto& shape) { add_solid(shape, list); }, collider);
  }
  if (is_empty(lit)) extend(lit, camera.target);
  Bounds seen = lit;
  for (const Collider& collider : scene.colliders) {
    if (const auto* plane = std::get_if<Plane>(&collider)) add_ground(*plane, lit, seen, list);
  }
  if (scene.ground) add_ground(*scene.ground, lit, seen, list);
  list.views =
      make_views(camera, static_cast<double>(width) / height, height, lit, seen, scene.style.light.towards_key);
  return list;
}

}  // namespace kerf::render
