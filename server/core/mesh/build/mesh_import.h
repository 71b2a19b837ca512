#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/element_names.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

inline constexpr double kMaxRestCoordinate = 1e4;  // m, largest magnitude of a coordinate of a sheet as given
// -; least height of a triangle over its longest edge. A flatter triangle is more than 1e12 times as stiff as a
// well-shaped one, so a solver in doubles would have no correct digits left. Below about 1e-15 even its area is lost in
// rounding.
inline constexpr double kMinFlatness = 1e-6;

// A sheet as indexed arrays.
struct IndexedMesh {
  Eigen::Matrix2Xd rest;              // 2 x V, m, |coordinate| <= kMaxRestCoordinate, V <= kMaxVertices
  Eigen::Matrix3Xi triangles;         // 3 x T, vertex ids
  std::vector<std::int32_t> regions;  // T labels >= 0; empty means that all are 0
  // A rest shape that is curved in space: 3 x V, m, |coordinate| <= kMaxRestCoordinate. `rest` then holds the material
  // coordinates, any one-to-one map of the surface to the plane; if it is 2 x 0, they are computed (see flattening.h).
  // If `surface` is 3 x 0, the rest shape is flat: it is `rest` itself.
  Eigen::Matrix3Xd surface;
};

// -; tolerance for joining triangles of a curved rest shape into one facet, over the longest edge of each triangle. The
// facet's affine map from the material plane must meet all their corners this closely.
inline constexpr double kSameFacet = 1e-7;

// Builds a mesh from a sheet of one or several components, with or without holes. Components may touch at points and
// along whole edges. Vertices at the same rest position share a point, and edges there whose vertices differ become
// cuts. So a sheet that was cut before keeps its cuts. A cut of only one inner edge is lost, since it doubles no
// vertex. A component whose triangles are all clockwise is turned over (corners 1 and 2 swapped). Errors list the
// offending triangles or vertices in the message; field = `rest`, `triangles`, `regions` or `surface`:
//   MESH_EMPTY, MESH_TOO_LARGE, MESH_NOT_FINITE, MESH_OUT_OF_RANGE, MESH_INDEX, MESH_REGIONS, MESH_UNUSED_VERTEX,
//   MESH_SURFACE, MESH_DEGENERATE_TRIANGLE (flatter than kMinFlatness, or a sheet of no size), MESH_NON_MANIFOLD_EDGE,
//   MESH_NON_MANIFOLD_VERTEX, MESH_INCONSISTENT_ORIENTATION, MESH_OVERLAP (triangles overlap, or a vertex lies inside
//   another triangle's edge); the errors of flatten() if it must compute the material coordinates.
// `names`: how messages name triangles and vertices.
Result<TriangleMesh> import_mesh(const IndexedMesh& input, const ElementNames& names = {});

}  // namespace kerf::mesh
