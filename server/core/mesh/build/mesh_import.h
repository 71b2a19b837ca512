#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

inline constexpr double kMaxRestCoordinate = 1e4;  // m
// -; least height of a triangle, as a fraction of its longest edge. The stiffness of a flatter one is more than 1e12
// times that of a well-shaped one, which leaves a solver in doubles no digits; from about 1e-15 its area itself is lost
// in rounding.
inline constexpr double kMinFlatness = 1e-6;

// A sheet as indexed arrays.
struct IndexedMesh {
  Eigen::Matrix2Xd rest;              // 2 x V, m, |coordinate| <= kMaxRestCoordinate, V <= kMaxVertices
  Eigen::Matrix3Xi triangles;         // 3 x T, vertex ids
  std::vector<std::int32_t> regions;  // T labels >= 0, or empty: all 0
  // The rest shape in space, 3 x V, m, |coordinate| <= kMaxRestCoordinate; or 3 x 0: it is flat, and `rest` is it.
  // Where it is given, `rest` are material coordinates of its vertices, any one-to-one map to the plane, or 2 x 0: one
  // is made (see flattening.h).
  Eigen::Matrix3Xd surface;
};

// Tolerance for joining triangles of a rest surface into one facet, as a fraction of their longest edge. One affine map
// from the material plane must meet all their corners this closely.
inline constexpr double kSameFacet = 1e-7;

// Builds a mesh from a sheet of one or several components, with or without holes. Components may touch at points and
// along whole edges. Vertices of equal rest position are welded there, so a sheet that was cut before keeps its cuts.
// (A cut of a single edge inside doubles no vertex and leaves no trace in arrays.) A component whose triangles are all
// clockwise is turned over (corners 1 and 2 swapped). Errors list the offending triangles or vertices in the message;
// field = `rest`, `triangles` or `regions`:
//   MESH_EMPTY, MESH_TOO_LARGE, MESH_NOT_FINITE, MESH_OUT_OF_RANGE, MESH_INDEX, MESH_REGIONS, MESH_UNUSED_VERTEX,
//   MESH_DEGENERATE_TRIANGLE (flatter than kMinFlatness, or a sheet of no size), MESH_NON_MANIFOLD_EDGE,
//   MESH_NON_MANIFOLD_VERTEX, MESH_INCONSISTENT_ORIENTATION, MESH_OVERLAP (triangles overlap, or a vertex lies inside
//   another triangle's edge); of a surface without material coordinates also those of flatten().
Result<TriangleMesh> import_mesh(const IndexedMesh& input);

}  // namespace kerf::mesh
