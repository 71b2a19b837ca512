#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/box_tree.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// Triangles that pass through each other, decided by exact arithmetic.
//
// Two triangles pass through each other if they share no vertex, do not lie in one plane, and their interiors have a
// point in common. An edge of one then passes through the other. It does not count if
//   - they only touch: a corner, an edge or both on the other triangle, or two edges that cross in one point. The lips
//     of a cut touch in whole edges when they are born.
//   - they overlap in one plane;
//   - one of them has no area;
//   - a coordinate is not finite or beyond 2^300 m. Coordinates below 2^-300 m count as 0.
// The answer depends on the positions alone: not on the order of triangles or corners, nor on the processor.

struct Intersections {
  std::int64_t count = 0;
  // Two indices of triangles each, the lower one first, ascending: all pairs, or those that come first.
  std::vector<std::array<std::int32_t, 2>> pairs;
};

// Counts and lists such pairs. It keeps its memory, which grows with the triangles but not with the pairs.
class IntersectionSearch {
 public:
  using Triangles = std::span<const std::array<mesh::VertexId, 3>>;  // ids of the corners

  // Returns the number of pairs of triangles that pass through each other at `positions`, 3 x V, m.
  std::int64_t count(Triangles triangles, const linear::VertexField& positions);
  // Returns that number and the pairs, of which at most `most_pairs` are listed.
  Intersections find(Triangles triangles, const linear::VertexField& positions, std::size_t most_pairs);

 private:
  template <typename Found>
  void for_each_pair(Triangles triangles, const linear::VertexField& positions, const Found& found);

  std::vector<Eigen::Vector3d> points_;  // m
  std::vector<Box> boxes_;               // by triangle
  BoxTree tree_;
};

}  // namespace kerf::contact
