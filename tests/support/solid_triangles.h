#pragma once

#include <array>
#include <vector>

#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::test {

// Returns the corners of the solid triangles of a mesh.
inline std::vector<std::array<mesh::VertexId, 3>> solid_triangles(const mesh::TriangleMesh& mesh) {
  std::vector<std::array<mesh::VertexId, 3>> triangles;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) triangles.push_back(mesh.vertices(t));
  }
  return triangles;
}

}  // namespace kerf::test
