#pragma once

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/element_names.h"

namespace kerf::mesh {

// Most vertices of a surface that flatten() accepts. It factorises a sparse matrix with two unknowns per vertex.
inline constexpr Eigen::Index kMaxFlattenedVertices = 50'000;

enum class Flattening {
  // Least-squares conformal maps (Levy, Petitjean, Ray, Maillot 2002): keeps angles as well as possible, and leaves the
  // border free. Triangles may overlap where the surface is far from flat.
  kConformal,
  // Tutte's embedding: the longest border becomes a circle, and each other vertex is a weighted mean of its neighbours.
  // Weights are cotangents but at least 0.05, since the proof needs positive ones. Triangles never overlap (Floater
  // 2003, "One-to-one piecewise linear mappings over triangulations"); angles are kept less well.
  kConvex,
};

// Returns material coordinates (2 x V, m) for a surface in space. `surface`: 3 x V, m, finite. `triangles`: 3 x T,
// vertex ids in range, every vertex used. Each component keeps its area. It is rotated and moved to lie as near as
// possible to its own projection along its mean normal. The x axis of the projection is that of world x, or of world y
// if the mean normal points nearly along x. Several components lie side by side. Errors, field = `surface`:
//   MESH_NON_MANIFOLD_VERTEX, MESH_INCONSISTENT_ORIENTATION (or more than two triangles at an edge),
//   MESH_DEGENERATE_TRIANGLE: a triangle of the surface has no area,
//   MESH_NOT_FLATTENABLE: closed (no border), with handles, of no area, or no map was found,
//   MESH_TOO_LARGE: more than kMaxFlattenedVertices.
// `names`: how messages name vertices.
Result<Eigen::Matrix2Xd> flatten(const Eigen::Matrix3Xd& surface, const Eigen::Matrix3Xi& triangles, Flattening method,
                                 const ElementNames& names = {});

}  // namespace kerf::mesh
