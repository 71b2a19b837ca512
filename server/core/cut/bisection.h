#pragma once

#include <span>

#include "server/base/result.h"
#include "server/core/cut/path_scale.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/refine/refinement.h"

// The source's remeshing: element by element.
namespace kerf::cut {

// Locks the edges of the elements in `crossed` and of those that share a corner with one: the path may be laid on a
// nearby point. So points inserted later are triangulated inside their element only. Lawson's flips make the
// triangulation that the cavity of Bowyer and Watson (1981) makes, each new point by itself.
void lock_elements(mesh::MeshEditor& editor, std::span<const mesh::TriangleId> crossed);

struct BisectionConfig {
  double length_floor = 0.0;  // lattice units; edges up to twice as long are not bisected
  std::int64_t max_insertions = 0;
};

// Adapted constrained Delaunay method: bisects the longest edge of each ill-shaped triangle, and with it the triangle
// across. Then restores the Delaunay property inside the element; repeats until none is left. A triangle is ill-shaped
// if longest / shortest edge is above 3 and its area above 3 % of that of the sheet's elements there. The second
// condition ends the loop, as each bisection halves an area. Flat caps, whose edges are alike, are not seen. Elements
// must have been locked. Error: as of cut::apply(), where the editor's budget is exhausted.
Result<mesh::RefinementCounts> bisect_ill_shaped(mesh::MeshEditor& editor, std::span<const mesh::TriangleId> seeds,
                                                 const PathScale& scale, const BisectionConfig& config);

}  // namespace kerf::cut
