#pragma once

#include <span>
#include <vector>

#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {

// Moves points, in rest space, to where the worst triangle around them is best shaped, then restores the Delaunay
// property there. A cut may pass very close to old points, and refinement would have to make triangles as small as that
// distance. If these points move away, the triangles stay large, and so does the explicit time step.
//
// Points with a fixed edge and points of `fixed_vertices` (sorted) stay. Each of `candidates` (unique) is tried once in
// each of three sweeps, at the centre of its neighbours and in eight directions. A move is kept only if it improves the
// worst TriangleShape::quality of the triangles around the point. A point stays if this worst quality is at least
// `well_shaped` (-). Returns the points moved, sorted, unique.
std::vector<PointId> relax(MeshEditor& editor, std::span<const PointId> candidates,
                           std::span<const VertexId> fixed_vertices, double well_shaped);

}  // namespace kerf::mesh
