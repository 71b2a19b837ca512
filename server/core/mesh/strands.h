#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/triangle_mesh.h"
#include "server/core/mesh/triangle_shape.h"

namespace kerf::mesh {

// Distances below which strands (lips, or lips and the border, that face each other or cross) count as close. Lengths
// hold where edges are EdgeLengths::mean long, elsewhere in proportion.
struct StrandWidths {
  double near = 0.0;    // lattice units, >= 0; strands closer than this are near each other; 0: none are
  double narrow = 0.0;  // lattice units, in [0, near]; gaps below this are spanned by needles
};

// Finds the triangles between and beside strands that are much closer than an edge length. The answer depends on lips,
// border and the triangle alone, and stays the same while lips are split and other triangles refined.
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

  // `lengths`: not null where `widths.near` is above 0. It and the mesh must outlive this.
  Strands(const TriangleMesh& mesh, const StrandWidths& widths, const EdgeLengths* lengths)
      : mesh_(mesh), widths_(widths), lengths_(lengths) {}

  // Place of the solid triangle t, which has this shape.
  [[nodiscard]] Place place_of(TriangleId t, const TriangleShape& shape);

 private:
  // Returns true if strands face each other closer than `reach` (lattice units) across the middle of an edge, or lips
  // cross within `reach` of it. The edge is that of t opposite corner c.
  [[nodiscard]] bool has_strands(TriangleId t, int c, double reach);
  // Takes note of a point of lips or border at this offset from the middle. True where lips cross in it.
  bool record_end(PointId p, const Eigen::Vector2d& offset);
  // Takes note of the place of a lip or border that is nearest to the middle. True where another faces it.
  bool record_foot(const Eigen::Vector2d& foot);

  const TriangleMesh& mesh_;
  StrandWidths widths_;
  const EdgeLengths* lengths_;
  double reach_ = 0.0;
  std::vector<TriangleId> found_, fan_;
  std::vector<PointId> ends_;
  std::vector<Eigen::Vector2d> feet_;  // from the middle, lattice units
};

}  // namespace kerf::mesh
