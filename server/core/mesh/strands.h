#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/triangle_mesh.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {

// Distances below which strands count as close. A strand is a lip or border seen beside another one that it faces or
// crosses. The distances hold where edges are EdgeLengths::mean long, and scale in proportion elsewhere.
struct StrandWidths {
  double near = 0.0;    // lattice units, >= 0; strands closer than this are near each other; 0: no strands are
  double narrow = 0.0;  // lattice units, in [0, near]; needles may span gaps narrower than this
};

// Finds the triangles between and beside strands that are much closer to each other than an edge length. The answer
// depends only on the triangle, lips and border. So it does not change when lips are split or other triangles are
// refined.
class Strands {
 public:
  enum class Place {
    kElsewhere,
    // Two strands face each other across the middle of the triangle's shortest edge, closer than `near`. Or a lip of
    // one cut meets another cut within `near` of that middle.
    kNear,
    // The shortest edge joins two fixed edges without being one, and is shorter than `narrow`.
    kNarrow,
  };

  // `lengths`: local edge lengths; not null if `widths.near` is above 0. Both `lengths` and the mesh must outlive this.
  Strands(const TriangleMesh& mesh, const StrandWidths& widths, const EdgeLengths* lengths)
      : mesh_(mesh), widths_(widths), lengths_(lengths) {}

  // Classifies the solid triangle t. `shape`: its shape in the rest shape.
  [[nodiscard]] Place place_of(TriangleId t, const TriangleShape& shape);

 private:
  // Looks at the middle of the edge of t opposite corner c. Returns true if strands face each other across it, closer
  // than `reach` (lattice units), or lips cross within `reach` of it.
  [[nodiscard]] bool has_strands(TriangleId t, int c, double reach);
  // Records a point of lips or border at this offset (lattice units) from the middle of the edge. Returns true if lips
  // cross there, or another strand faces it.
  bool record_end(PointId p, const Eigen::Vector2d& offset);
  // Records the place of a lip or border that is nearest to the middle of the edge. Returns true if a place recorded
  // before faces it.
  bool record_foot(const Eigen::Vector2d& foot);

  const TriangleMesh& mesh_;
  StrandWidths widths_;
  const EdgeLengths* lengths_;
  double reach_ = 0.0;
  std::vector<TriangleId> found_, fan_;
  std::vector<PointId> ends_;
  std::vector<Eigen::Vector2d> feet_;  // recorded places, from the middle of the edge, lattice units
};

}  // namespace kerf::mesh
