#pragma once

#include <span>
#include <vector>

#include "server/base/result.h"
#include "server/core/mesh/build/element_names.h"
#include "server/core/mesh/mesh_data.h"

namespace kerf::mesh {

// An edge of a solid triangle with no solid triangle beyond it. The sheet lies to the left of from -> to.
struct BorderSide {
  PointId from = kNone;
  PointId to = kNone;
  TriangleId triangle = kNone;
  int corner = 0;  // corner of the triangle opposite the edge
};

// Completes `data` to a tiling of the whole domain. On entry it holds only the sheet: points, solid triangles in all
// slots, adjacency, cut locks. Adds the domain's corners as points and void triangles as slots; makes neighbours across
// the border and locks its edges. The void is the constrained Delaunay triangulation of the border. `border`: every
// border side once.
//
// Error: MESH_OVERLAP if the sheet covers a place twice or has a point inside a border side. The test is exact, as the
// number of triangles over a place is the winding number of the border about it. So it is enough that no two border
// sides cross and that every face between them has winding number 0 or 1.
// `names`: how messages name triangles and vertices.
Status fill_void(MeshData& data, std::span<const BorderSide> border, const ElementNames& names);

}  // namespace kerf::mesh
