#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "server/core/mesh/triangle_mesh.h"

// Checks meshes and cuts from the records of server/core/mesh alone. Adjacency, sectors (fans of triangles around a
// point between open edges), pieces, loops and areas are computed from corners and coordinates by other algorithms.
// Each function describes the first fault, or returns nothing. The library links nothing of Kerf.
namespace kerf::audit {

using Finding = std::optional<std::string>;

// Counts the parts of a sheet, in the opened mesh unless stated otherwise.
struct Census {
  std::int64_t vertices = 0;
  std::int64_t edges = 0;
  std::int64_t triangles = 0;
  std::int64_t pieces = 0;
  std::int64_t loops = 0;            // closed chains of boundary edges
  std::int64_t lip_edges = 0;        // welded edges that are cut
  std::int64_t welded_vertices = 0;  // points that are a corner of a triangle with material
  std::int64_t extra_fans = 0;       // sum over welded_vertices of (number of the point's vertices - 1)
  // Points by the number of open edges (cut or border) that meet there: [1]: tips; [2]: on a lip or border; [3]: T
  // junctions; [4]: crossings; [5]: more edges.
  std::array<std::int64_t, 6> points_by_degree{};

  [[nodiscard]] std::int64_t characteristic() const { return vertices - edges + triangles; }
  // Returns the characteristic of the sheet before all cuts, which do not change it.
  [[nodiscard]] std::int64_t welded_characteristic() const { return characteristic() - extra_fans + lip_edges; }
};

// Checks a mesh:
//   all indices are in range, and all triangles counter-clockwise, exactly;
//   the triangles tile the domain without gap or overlap;
//   adjacency and locks are those that the edges imply;
//   each sector has one vertex and each vertex one sector, so the mesh is a manifold without bow-ties;
//   every lip is open; the pieces and Euler's formula are right.
// `census`, if not null, is filled if nothing is wrong.
Finding find_flaw(const mesh::TriangleMesh& mesh, Census* census = nullptr);

}  // namespace kerf::audit
