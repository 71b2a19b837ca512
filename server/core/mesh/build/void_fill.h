#pragma once

#include <span>
#include <vector>

#include "server/base/result.h"
#include "server/core/mesh/mesh_records.h"

namespace kerf::mesh {

// A side of a solid triangle with no solid triangle beyond it; the sheet lies to the left of from -> to.
struct BorderSide {
  PointId from = kNone;
  PointId to = kNone;
  TriangleId triangle = kNone;
  int corner = 0;  // opposite
};

// Completes `records`, which holds the sheet alone (points, solid triangles in all slots, adjacency, cut locks), to a
// tiling of the whole domain: adds the domain's corners as points and void triangles as slots, joins and locks the
// border. The void is the constrained Delaunay triangulation of the border. `border`: every border side once.
//
// Refuses (MESH_OVERLAP) a sheet that covers a place twice or has a point inside a border side. The test is exact: the
// number of triangles over a place is the winding number of the border about it, so it is enough that no two border
// sides cross and that no face between them has a winding number other than 0 and 1.
Status fill_void(MeshRecords& records, std::span<const BorderSide> border);

}  // namespace kerf::mesh
