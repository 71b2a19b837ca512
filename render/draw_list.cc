#include "render/draw_list.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "render/shapes.h"

namespace kerf::render {

namespace {

constexpr float kChecksAlongLongerSide = 20.0F;
constexpr double kGroundRadius = 4.0;  // of the disc, over the radius of what stands on it

using Float3 = std::array<float, 3>;

Float3 position(const Mesh& mesh, std::int32_t vertex) {
  const std::size_t at = 3 * static_cast<std::size_t>(vertex);
  return {mesh.positions[at], mesh.positions[at + 1], mesh.positions[at + 2]};
}

// Of each vertex: the sum of its triangles' normals weighted by their areas, made unit; (0, 0, 1) where that vanishes.
std::vector<Float3> vertex_normals(const Mesh& mesh) {
  std::vector<Float3> normals(mesh.positions.size() / 3, Float3{});
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Float3 a = position(mesh, mesh.triangles[t]);
    const Float3 b = position(mesh, mesh.triangles[t + 1]);
    const Float3 c = position(mesh, mesh.triangles[t + 2]);
    const Float3 u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Float3 v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    const Float3 n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Float3& sum = normals[static_cast<std::size_t>(mesh.triangles[t + corner])];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += n[k];
    }
  }
  for (Float3& n : normals) {
    const float length = std::hypot(n[0], n[1], n[2]);
    n = length > 0.0F && std::isfinite(length) ? Float3{n[0] / length, n[1] / length, n[2] / length}
                                               : Float3{0.0F, 0.0F, 1.0F};
  }
  return normals;
}

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

// Piece 0 keeps the sheet's colours; the others lean towards hues as far from one another as golden angles are.
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

std::vector<SurfaceVertex> sheet_vertices(const Mesh& mesh, const TextureFrame& texture) {
  const std::vector<Float3> normals = vertex_normals(mesh);
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
                                                    : own_colour(mesh, vertex)});
  }
  return vertices;
}

// The plane, and how far it reaches into what is seen.
void add_ground(const Plane& plane, const Bounds& lit, Bounds& seen, DrawList& list) {
  const double reach = kGroundRadius * std::max(radius(lit), 1e-3);
  const std::size_t first = list.ground.size();
  append_ground(plane, centre(lit), reach, list.ground);
  for (std::size_t i = first; i < list.ground.size(); ++i) {
    const Float3& p = list.ground[i].position;
    extend(seen, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  }
}

void add_solid(const Collider& collider, DrawList& list) {
  if (const auto* sphere = std::get_if<Sphere>(&collider)) append_sphere(*sphere, list.solids);
  if (const auto* box = std::get_if<Box>(&collider)) append_box(*box, list.solids);
  if (const auto* capsule = std::get_if<Capsule>(&collider)) append_capsule(*capsule, list.solids);
}

}  // namespace

std::vector<std::array<std::int32_t, 2>> border_edges(std::span<const std::int32_t> triangles,
                                                      std::size_t num_vertices) {
  // Edges are chained by their lower vertex; few share one, so a chain is a handful long.
  struct Edge {
    std::int32_t upper;
    std::int32_t uses;
    std::size_t next;
  };
  constexpr std::size_t kEnd = static_cast<std::size_t>(-1);
  std::vector<std::size_t> first(num_vertices, kEnd);
  std::vector<Edge> edges;
  edges.reserve(triangles.size());
  std::vector<std::size_t> edge_of(triangles.size());  // of the side from corner i to the next of its triangle
  const auto next_corner = [](std::size_t i) { return i % 3 == 2 ? i - 2 : i + 1; };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto [lower, upper] = std::minmax({triangles[i], triangles[next_corner(i)]});
    std::size_t& head = first[static_cast<std::size_t>(lower)];
    std::size_t at = head;
    while (at != kEnd && edges[at].upper != upper) at = edges[at].next;
    if (at == kEnd) {
      at = edges.size();
      edges.push_back({upper, 0, head});
      head = at;
    }
    ++edges[at].uses;
    edge_of[i] = at;
  }
  std::vector<std::array<std::int32_t, 2>> borders;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (edges[edge_of[i]].uses == 1) borders.push_back({triangles[i], triangles[next_corner(i)]});
  }
  return borders;
}

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
  list.sheet = sheet_vertices(scene.mesh, texture);
  if (scene.style.borders) {
    for (const auto& [start, end] : border_edges(scene.mesh.triangles, scene.mesh.positions.size() / 3)) {
      list.borders.push_back({position(scene.mesh, start), position(scene.mesh, end)});
    }
  }

  Bounds lit = bounds_of(scene.mesh);
  for (const Collider& collider : scene.colliders) extend(lit, collider);
  if (is_empty(lit)) extend(lit, camera.target);
  Bounds seen = lit;
  for (const Collider& collider : scene.colliders) {
    add_solid(collider, list);
    if (const auto* plane = std::get_if<Plane>(&collider)) add_ground(*plane, lit, seen, list);
  }
  if (scene.ground) add_ground(*scene.ground, lit, seen, list);
  list.views = make_views(camera, static_cast<double>(width) / height, height, lit, seen);
  return list;
}

}  // namespace kerf::render
