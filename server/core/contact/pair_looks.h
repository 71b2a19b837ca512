#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/contact/feature_pair.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

// Looks at many pairs of features at once, in vector code that is chosen for the processor at run time. Results have
// the same bits on every processor.
namespace kerf::contact {

// A vector of each vertex as floats side by side, by vertex id.
using FloatLanes = std::array<std::vector<float>, 3>;

// Positions as floats relative to their mean.
struct FloatPositions {
  FloatLanes x;                           // m
  Eigen::Vector3d middle{0.0, 0.0, 0.0};  // m
  float extent = 0.0F;                    // m, largest coordinate

  // Sets the positions of some vertices, which must be all that have been set before or all of a sheet.
  void set(const linear::VertexField& from, std::span<const mesh::VertexId> vertices);
  // Sets those of vertices that moved since.
  void update(const linear::VertexField& from, std::span<const mesh::VertexId> vertices);
  // Returns a bound of the error of heights of these points above each other, m.
  [[nodiscard]] float rounding() const { return 1e-6F * extent; }
};
// Sets the floats of some vertices.
void set_floats(const linear::VertexField& from, std::span<const mesh::VertexId> vertices, FloatLanes& to);

// Pairs of one kind: vertices side by side, and which of them.
struct PairSelection {
  FeaturePair::Kind kind;
  const std::array<std::vector<std::int32_t>, 4>& vertices;
  std::span<const std::int32_t> indices;
};

// Sets `distances` (m) to those of the pairs selected, negative for edges whose nearest points are ends. Sets
// `closing` (m/s) to the speeds at which the nearest points approach. By place in the selection; errors are those of
// floats.
void look_at(const PairSelection& pairs, const FloatLanes& x, const FloatLanes& v, std::span<float> distances,
             std::span<float> closing);

// Appends to `kept` the pairs selected whose sides are not separated by a plane perpendicular to the shortest way at
// `from`. A plane that separates them at `from` and `to` does so between. The gaps must be larger than a tenth of the
// distance, and than `least` (m, by pair) or 0.999 of the distance.
void keep_unseparated(const PairSelection& pairs, std::span<const float> least, const FloatPositions& from,
                      const FloatPositions& to, std::vector<std::int32_t>& kept);

}  // namespace kerf::contact
