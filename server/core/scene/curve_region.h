#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/refine/size_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/region.h"

namespace kerf::scene {

// A MaterialCurve, flattened for a mesh. Says whether a place is within its reach, and on which side of the curve.
class CurveRegion {
 public:
  // `curve` must be valid; the mesh must outlive this.
  CurveRegion(const MaterialCurve& curve, const mesh::TriangleMesh& mesh);

  // Returns true if `at` (m, material coordinates) is within MaterialCurve::within of the curve. O(log chords).
  [[nodiscard]] bool reaches(const Eigen::Vector2d& at) const;
  // Returns a vector (-) to the left of the curve where it is nearest to `at`: the chord's unit vector, at a joint the
  // sum for both chords. O(chords).
  [[nodiscard]] Eigen::Vector2d left_at(const Eigen::Vector2d& at) const;
  // Returns an offset of `at` from the curve, of which only the sign matters: > 0 on the left.  m
  [[nodiscard]] double offset(const Eigen::Vector2d& at) const;

 private:
  struct Nearest {
    Eigen::Vector2d point{0.0, 0.0};  // m, the point of the curve nearest to the place
    Eigen::Vector2d left{0.0, 0.0};   // -, see left_at()
  };
  [[nodiscard]] Nearest nearest(const Eigen::Vector2d& at) const;

  const mesh::TriangleMesh& mesh_;
  double within_;                         // m; 0: kCurveTolerance times the local edge length
  std::vector<mesh::SizeSource> chords_;  // with growth 1 and length about 0, so that distance_ gives distances from
                                          // the curve
  mesh::SizeField distance_;
};

// Returns the vertices of a NearestBorder: all edges between material and one connected part of the void. `point`: m,
// material coordinates. Lips do not count as border. The result is unsorted, with repeats. `component`: the nearest
// border is sought in its room; the void around it also has the outer borders of others. Null: everywhere.
std::vector<mesh::VertexId> border_vertices(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& point,
                                            const ComponentPlace* component);

}  // namespace kerf::scene
