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

  // Lattice units; infinite without tips.
  [[nodiscard]] double length_at(const LatticePoint& at) const;
};

// The curves that the fixed edges of a mesh stand for.
class BorderCurves {
 public:
  virtual ~BorderCurves() = default;
  // Returns the place on the curve between p and q at this distance from p (lattice units, less than that of q). A
  // fixed edge joins p and q.
  [[nodiscard]] virtual LatticePoint between(PointId p, PointId q, double distance) = 0;
  // Report the outcome of the last call of between(). add(): the place is a point now. miss(): it cannot be one, since
  // the mesh is too fine there for the edge to give way to the curve.
  virtual void add(PointId p, PointId q, PointId added) = 0;
  virtual void miss(PointId p, PointId q) = 0;
};

struct RefinementConfig {
  double min_angle_deg = 20.0;     // degrees, in [0, 28]; 0: triangles are refined for their size only
  double length_floor = 0.0;       // lattice units; edges this short are not split and not refined around
  StrandWidths strands;            // where triangles are near strands, which are refined less
  double strand_angle_deg = 20.0;  // degrees, in [0, min_angle_deg]; smallest angle near strands
  std::int64_t max_insertions = 0;
  // Scales the lengths above in proportion: they hold as given where edges are `lengths->mean` long. Not null.
  const EdgeLengths* lengths = nullptr;
  TipGrading grading;
  BorderCurves* border = nullptr;  // null: fixed edges are what they stand for
};

struct RefinementCounts {
  std::int64_t insertions = 0;
  bool stopped = false;  // max_insertions reached
};

// Refines the solid triangles in `seeds`, and those it rewrites, until no angle is below min_angle_deg except where the
// input forces one. Also no edge is then longer than the grading around tips allows. The method is Delaunay refinement
// after Ruppert (1995, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation"). Points are
// off-centres (Ungor 2004, "Off-centers: a new type of Steiner points"); fixed edges are split where encroached or in
// the way. There are two guards for sharp input corners. One is concentric shells around corners below 60 degrees
// (Ruppert, sec. 7). The other is by Miller, Pav, Walkington (2003, "When and why Ruppert's algorithm works"): it
// does not refine triangles whose shortest edge joins two lips of such a corner. Near strands (see Strands) no angle is
// below strand_angle_deg: triangles between lips are no higher than their gap, however many triangles fill it. In
// narrow gaps no angle is required: there lips are only split opposite each other, and needles span them. The void is
// never refined. Ends early where the editor's budget is exhausted.
RefinementCounts refine(MeshEditor& editor, std::span<const TriangleId> seeds, const RefinementConfig& config);

}  // namespace kerf::mesh
