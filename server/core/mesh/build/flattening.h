#pragma once

#include <Eigen/Core>

#include "server/base/result.h"

namespace kerf::mesh {

// Vertices of a surface that flatten() takes: a sparse factorisation of twice as many unknowns.
inline constexpr Eigen::Index kMaxFlattenedVertices = 50'000;

enum class Flattening {
  // Least-squares conformal maps (Levy, Petitjean, Ray, Maillot 2002): angles are kept as well as can be, the border is
  // free. Triangles may overlap where the surface is far from flat.
  kConformal,
  // Tutte's embedding: the longest border lies on a circle, all other vertices at weighted means of their neighbours.
  // Weights are cotangents, but at least a twentieth, so that all are positive. Never overlaps (Floater 2003,
  // "One-to-one piecewise linear mappings over triangulations"); angles are kept less well.
  kConvex,
};

// Returns material coordinates (2 x V, m) for a surface in space. surface: 3 x V, m, finite; triangles: 3 x T, vertex
// ids in range, all vertices used. Each component keeps its area. It is rotated and moved to lie as near as possible to
// its own projection along its mean normal. The x axis of the projection lies along world x (or y, where the component
// faces x). Several components lie side by side. Errors, field = `surface`:
//   MESH_NON_MANIFOLD_VERTEX, MESH_INCONSISTENT_ORIENTATION (or more than two triangles at an edge),
//   MESH_DEGENERATE_TRIANGLE: a triangle of the surface has no area,
//   MESH_NOT_FLATTENABLE: closed (no border), with handles, of no area, or no map was found,
//   MESH_TOO_LARGE: more than kMaxFlattenedVertices.
Result<Eigen::Matrix2Xd> flatten(const Eigen::Matrix3Xd& surface, const Eigen::Matrix3Xi& triangles, Flattening method);

}  // namespace kerf::mesh
