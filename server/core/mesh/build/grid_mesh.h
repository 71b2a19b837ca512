#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

struct GridConfig {
  std::int32_t num_x = 50;  // vertices along x, >= 2
  std::int32_t num_y = 50;  // vertices along y, >= 2; num_x * num_y <= kMaxVertices
  double width = 1.0;       // m, in [1e-6, 1e4]
  double height = 1.0;      // m, in [1e-6, 1e4]
};

// Makes a rectangle from (0, 0) to (width, height). Vertex j * num_x + i lies at (i width / (num_x - 1), j height /
// (num_y - 1)). Triangles 2 q and 2 q + 1, q = j * (num_x - 1) + i, halve cell (i, j) along its diagonal from lower
// left to upper right. Errors: GRID_SIZE, GRID_EXTENT; MESH_DEGENERATE_TRIANGLE if its cells are too long for their
// height.
Result<TriangleMesh> make_grid(const GridConfig& config);

// Makes a Delaunay mesh of the vertices of make_grid(), with each inner vertex displaced at random. `seed` chooses the
// displacements, up to 0.3 of a cell in x and in y. Triangles are sorted by their lowest vertex. Errors as of
// make_grid().
Result<TriangleMesh> make_jittered_grid(const GridConfig& config, std::uint64_t seed);

}  // namespace kerf::mesh
