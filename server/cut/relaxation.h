#pragma once

#include <span>
#include <vector>

#include "server/mesh/mesh_editor.h"

namespace kerf::cut {

// Moves old points near the path, in rest space, to where the worst triangle around them is best shaped, then restores
// the Delaunay property there. Why: the path passes at any distance from old points, and refinement would have to grade
// the mesh down to the smallest of them; moved away, the elements stay large, and with them the explicit time step.
//
// Points on a locked edge or on a border between regions, and those of `fixed_vertices` (sorted), stay. Each of
// `candidates` (unique) is tried once in each of three sweeps, at the centre of its ring and in eight directions; a
// move is kept only if the quality of the worst triangle of the star (TriangleShape::quality) improves; stars where it
// is `well_shaped` (-) are left alone. Returns the points moved, sorted, unique.
std::vector<mesh::PointId> relax(mesh::MeshEditor& editor, std::span<const mesh::PointId> candidates,
                                 std::span<const mesh::VertexId> fixed_vertices, double well_shaped);

}  // namespace kerf::cut
