#pragma once

#include <span>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/strands.h"

namespace kerf::cut {

// Returns the solid triangles made by the cut: those among `rewritten` that were not in the mesh before the edit with
// the same three corners in the same places. A triangle that lost a neighbour to a lip, or changed its slot, is not
// new. `undo`: of the edit, whose mesh is `mesh`; `moved`: points that it moved, sorted.
std::vector<mesh::TriangleId> new_triangles(const mesh::TriangleMesh& mesh, const mesh::UndoLog& undo,
                                            std::span<const mesh::TriangleId> rewritten,
                                            std::span<const mesh::PointId> moved);

// Returns the widths by kNearStrands and kNarrowGap; 0 for Method::kElement, which refines to no angle.
mesh::StrandWidths strand_widths(const mesh::TriangleMesh& mesh, const CutOptions& options);

// Measures `triangles` (sorted) against min_angle_deg, near strands of these widths against kStrandAngle of it, and
// lists the corners that excuse those below it.
CutQuality measure_quality(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> triangles,
                           double min_angle_deg, const mesh::StrandWidths& strand_widths);

}  // namespace kerf::cut
