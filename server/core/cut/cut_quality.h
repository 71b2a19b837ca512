#pragma once

#include <span>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/strands.h"

namespace kerf::cut {

// Returns the solid triangles that the cut has made, from those in `rewritten`. A triangle is not new if one with the
// same three corners in the same places existed before the edit. So a triangle that lost a neighbour to a lip, or
// changed its slot, is not new. `undo`: log of the edit, after which the mesh is `mesh`. `moved`: points that the edit
// moved, sorted.
std::vector<mesh::TriangleId> new_triangles(const mesh::TriangleMesh& mesh, const mesh::UndoLog& undo,
                                            std::span<const mesh::TriangleId> rewritten,
                                            std::span<const mesh::PointId> moved);

// Returns the widths that kNearStrands and kNarrowGap give on this mesh. They are 0 for Method::kElement, which
// promises no angle.
mesh::StrandWidths strand_widths(const mesh::TriangleMesh& mesh, const CutOptions& options);

// Measures the shapes of `triangles` (sorted). Counts those with an angle below min_angle_deg, or near strands below
// kStrandAngle times that. Lists the sharp corners that allow such triangles.
CutQuality measure_quality(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> triangles,
                           double min_angle_deg, const mesh::StrandWidths& strand_widths);

}  // namespace kerf::cut
