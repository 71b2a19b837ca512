#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "server/core/mesh/triangle_mesh.h"

// Checks of meshes and of cuts that share nothing with server/core/mesh but the records: adjacency, sectors, pieces,
// loops and areas are found again from corners and coordinates, by other algorithms. Each function returns what is
// wrong in words, or nothing. The library links nothing of Kerf.
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
  std::int64_t welded_vertices = 0;  // points with material around them
  std::int64_t extra_fans = 0;       // sum over those points of (vertices - 1)
  // Points by the number of open edges (cut or border) that meet there: [1] are tips, [2] on a lip or border, [3] T
  // junctions, [4] crossings, [5] more.
  std::array<std::int64_t, 6> points_by_degree{};

  [[nodiscard]] std::int64_t characteristic() const { return vertices - edges + triangles; }
  // Returns the characteristic of the sheet before all cuts, which do not change it.
  [[nodiscard]] std::int64_t welded_characteristic() const { return characteristic() - extra_fans + lip_edges; }
};

// Ranges; orientation, exactly; a tiling of the domain without gap or overlap; adjacency and locks as edges demand; one
// vertex for each sector and one sector for each vertex (so: manifold, no bow-tie, tips single, lips in pairs that
// share their points); every lip open; pieces; Euler. `census`, where given, is filled if nothing is wrong.
Finding find_flaw(const mesh::TriangleMesh& mesh, Census* census = nullptr);

}  // namespace kerf::audit
