#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/refine/size_field.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/region.h"

namespace kerf::sheet {

// A MaterialCurve on a mesh, flattened; finds whether it reaches a place, and on which side of it the place lies.
class CurveRegion {
 public:
  // `curve`: valid.
  CurveRegion(const MaterialCurve& curve, const mesh::TriangleMesh& mesh);

  // Returns true if `at` (m, material) is within reach. O(log chords).
  [[nodiscard]] bool reaches(const Eigen::Vector2d& at) const;
  // -, sum of the unit vectors to the left of the chords nearest to `at`: one, or at a joint two. O(chords).
  [[nodiscard]] Eigen::Vector2d left_at(const Eigen::Vector2d& at) const;
  // m, to the left of the curve; the sign counts.
  [[nodiscard]] double offset(const Eigen::Vector2d& at) const;

 private:
  struct Nearest {
    Eigen::Vector2d point{0.0, 0.0};  // m, of the curve
    Eigen::Vector2d left{0.0, 0.0};   // -, see left_at()
  };
  [[nodiscard]] Nearest nearest(const Eigen::Vector2d& at) const;

  const mesh::TriangleMesh& mesh_;
  double within_;                         // m; 0: kCurveTolerance of the edge length there
  std::vector<mesh::SizeSource> chords_;  // with growth 1, so that the field's lengths are distances
  mesh::SizeField distance_;
};

// Vertices on the whole border around the hole, or around the outside, that comes nearest to `point` (m, material):
// edges between material and one connected part of the void. Lips are no border. Unsorted, some of them twice.
std::vector<mesh::VertexId> border_vertices(const mesh::TriangleMesh& mesh, const Eigen::Vector2d& point);

}  // namespace kerf::sheet
