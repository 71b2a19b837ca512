#pragma once

#include <span>

#include "server/base/result.h"
#include "server/core/cut/cut_types.h"
#include "server/core/cut/path_scale.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/refine/refinement.h"

// Method::kElement: remeshing inside each element (triangle before the cut) by itself.
namespace kerf::cut {

// Locks the edges of the elements in `crossed`, and of those that share a corner with one: the path may be moved to a
// nearby point. So points inserted later are triangulated inside their element only. For each point, Lawson's flips
// give the same triangulation as the cavity of Bowyer and Watson (1981).
void lock_elements(mesh::MeshEditor& editor, std::span<const mesh::TriangleId> crossed);

struct BisectionConfig {
  double length_floor = 0.0;  // lattice units; edges of at most twice this length are not bisected
  std::int64_t max_insertions = 0;
  ElementLimits limits;
};

// The "adapted constrained Delaunay method" (ACDM). Bisects the longest edge of an ill-shaped triangle, which divides
// the triangle beyond it too. Then restores the Delaunay property inside the element, and repeats until no triangle is
// ill-shaped. An ill-shaped triangle exceeds both limits of ElementLimits. The limit of areas ends the loop, as each
// bisection halves an area. Flat caps, obtuse triangles with edges of similar length, do not count. Call
// lock_elements() before. Error: CUT_ELEMENT_BUDGET as of cut::apply(), if the editor has no slots left.
Result<mesh::RefinementCounts> bisect_ill_shaped(mesh::MeshEditor& editor, std::span<const mesh::TriangleId> seeds,
                                                 const PathScale& scale, const BisectionConfig& config);

}  // namespace kerf::cut
