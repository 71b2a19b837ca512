#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/strands.h"

namespace kerf::mesh {

// Edge lengths wanted around the tips of a cut: `length` at each tip, growing by `gradient` per unit of distance.
struct TipGrading {
  std::vector<LatticePoint> tips;
  double length = 0.0;    // lattice units, > 0
  double gradient = 0.5;  // -, > 0

  // Returns the edge length wanted at a place, lattice units; infinite if there are no tips.
  [[nodiscard]] double length_at(const LatticePoint& at) const;
};

// The curves that fixed edges of a mesh approximate. Points that split a fixed edge are placed on its curve.
class BorderCurves {
 public:
  virtual ~BorderCurves() = default;
  // Returns the place on the curve between p and q, the ends of a fixed edge, that has this distance from p.
  // `distance`: lattice units, less than the length of the edge.
  [[nodiscard]] virtual LatticePoint between(PointId p, PointId q, double distance) = 0;
  // Called after between(), with its outcome. add(): the place has become a point. miss(): it cannot become one, since
  // other triangles lie between the edge and the curve.
  virtual void add(PointId p, PointId q, PointId added) = 0;
  virtual void miss(PointId p, PointId q) = 0;
};

struct RefinementConfig {
  double min_angle_deg = 20.0;     // degrees, in [0, 28]; 0: triangles are refined for their size only
  double length_floor = 0.0;       // lattice units; edges this short are not split, and triangles with one are not
                                   // refined
  StrandWidths strands;            // widths below which triangles between strands are refined less
  double strand_angle_deg = 20.0;  // degrees, in [0, min_angle_deg]; smallest angle near strands
  std::int64_t max_insertions = 0;
  // Local edge lengths of the sheet. `length_floor` and `strands` hold where edges are `lengths->mean` long, and scale
  // in proportion elsewhere. Not null.
  const EdgeLengths* lengths = nullptr;
  TipGrading grading;
  BorderCurves* border = nullptr;  // null: fixed edges are exact, and are split on themselves
};

struct RefinementCounts {
  std::int64_t insertions = 0;
  bool stopped = false;  // true if max_insertions was reached
};

// Refines the solid triangles in `seeds`, and those that replace them. Ends when no angle is below min_angle_deg,
// except where the input forces one, and no edge is longer than `grading` allows. The method is Delaunay refinement
// after Ruppert (1995, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation"). Points are
// off-centres (Ungor 2004, "Off-centers: a new type of Steiner points"); a fixed edge is split if a new point would
// encroach on it or lie behind it. There are two guards for sharp input corners. One is concentric shells around
// corners below 60 degrees (Ruppert, sec. 7). The other is by Miller, Pav, Walkington (2003, "When and why Ruppert's
// algorithm works"): it does not refine triangles whose shortest edge joins two lips of such a corner. Near strands
// (see Strands) no angle is below strand_angle_deg: triangles between lips are no higher than their gap, however many
// triangles fill it. In narrow gaps no angle is required: there lips are only split opposite each other, and needles
// span them. The void is never refined. Ends early when the editor has no slots left.
RefinementCounts refine(MeshEditor& editor, std::span<const TriangleId> seeds, const RefinementConfig& config);

}  // namespace kerf::mesh
