#pragma once

#include <array>
#include <vector>

#include "render/renderer.h"

// Computes a sheet's shape at its vertices from its triangles.
namespace kerf::render {

using Float3 = std::array<float, 3>;

inline Float3 position(const Mesh& mesh, std::int32_t vertex) {
  const std::size_t at = 3 * static_cast<std::size_t>(vertex);
  return {mesh.positions[at], mesh.positions[at + 1], mesh.positions[at + 2]};
}
inline Float3 difference(Float3 a, Float3 b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Float3 cross(Float3 u, Float3 v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
inline float dot(Float3 u, Float3 v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}
// Returns the number of a triangle's look, see Mesh::looks.
inline float look_of(const Mesh& mesh, std::size_t triangle) {
  return mesh.looks.empty() ? 0.0F : static_cast<float>(mesh.looks[triangle]);
}
// Returns v / |v|, or `otherwise` if v vanishes.
Float3 unit(Float3 v, Float3 otherwise);

// Returns the unit normals of the vertices: area-weighted sums over their triangles; (0, 0, 1) if the sum vanishes.
std::vector<Float3> vertex_normals(const Mesh& mesh);

// Returns for each vertex the mean of the curvatures along its edges, times `length` (m), clamped to [-1, 1]. It is
// positive on ridges of the front side. `normals`: see vertex_normals().
std::vector<float> ridges(const Mesh& mesh, const std::vector<Float3>& normals, double length);

}  // namespace kerf::render
