#pragma once

#include <span>
#include <vector>

#include "server/core/mesh/mesh_editor.h"

namespace kerf::mesh {

// Moves points, in rest space, to where the worst triangle around them is best shaped, then restores the Delaunay
// property there. The reason around a cut: its path passes at any distance from old points, and refinement would have
// to grade the mesh down to the smallest of them; moved away, the elements stay large, and with them the explicit time
// step.
//
// Points on a locked edge or on a border between regions, and those of `fixed_vertices` (sorted), stay. Each of
// `candidates` (unique) is tried once in each of three sweeps, at the centre of its ring and in eight directions; a
// move is kept only if the quality of the worst triangle of the star (TriangleShape::quality) improves; stars where it
// is `well_shaped` (-) are left alone. Returns the points moved, sorted, unique.
std::vector<PointId> relax(MeshEditor& editor, std::span<const PointId> candidates,
                           std::span<const VertexId> fixed_vertices, double well_shaped);

}  // namespace kerf::mesh
