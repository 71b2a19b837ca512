#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/base/result.h"
#include "server/mesh/mesh_editor.h"

namespace kerf::cut {

struct RefinementConfig {
  double min_angle_deg = 20.0;  // degrees, in (0, 28]
  double length_floor = 0.0;    // lattice units; edges this short are not split and not refined around
  std::int64_t max_insertions = 0;
};

struct RefinementCounts {
  std::int64_t insertions = 0;
  bool stopped = false;  // max_insertions reached
};

// Delaunay refinement of the solid triangles in `seeds`, and of those it rewrites, until no angle is below min_angle_deg
// but where the input forces one. After Ruppert (1995, "A Delaunay refinement algorithm for quality 2-dimensional mesh
// generation") with off-centres (Ungor 2004, "Off-centers: a new type of Steiner points"), fixed edges split where
// encroached or in the way, and two guards for sharp input corners: concentric shells around corners below 60 degrees
// (Ruppert, sec. 7) and no refinement of triangles whose shortest edge joins two lips of such a corner (Miller, Pav,
// Walkington 2003, "When and why Ruppert's algorithm works"). The void is never refined.
// Error: as of cut::apply(), where the editor's budget is exhausted.
Result<RefinementCounts> refine(mesh::MeshEditor& editor, std::span<const mesh::TriangleId> seeds,
                                const RefinementConfig& config);

}  // namespace kerf::cut
