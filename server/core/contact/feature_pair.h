#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "server/core/contact/sheet_features.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// A vertex and a triangle, or two edges, without a common vertex. Side a is the vertex or the first edge.
struct FeaturePair {
  enum class Kind : std::uint8_t { kVertexTriangle, kEdgeEdge };
  Kind kind = Kind::kVertexTriangle;
  std::int32_t a = 0, b = 0;                 // vertex id and triangle, or two edges, of SheetFeatures
  std::array<mesh::VertexId, 4> vertices{};  // a first: one, or two for edges
  double thickness = 0.0;                    // m, distance to be kept
  double least = 0.0;                        // m, distance at which the check lets a pair come no nearer
  double altitude = 0.0;                     // m, least of the triangles at the pair
  float speed = 0.0F;                        // m/s, most by which corners of both sides move along each other's lines

  [[nodiscard]] std::size_t num_a() const { return kind == Kind::kVertexTriangle ? 1 : 2; }
};

// The shortest way between both sides of a pair.
struct Separation {
  Eigen::Vector3d normal{0.0, 0.0, 1.0};  // -, unit, from b to a; any unit vector at distance 0
  double distance = 0.0;                  // m
  std::array<double, 4> weights{};        // -, sum w_i x_i is the way from b to a; each side sums to +1 or -1
};

// Four positions, m, in the order of FeaturePair::vertices.
using PairPositions = std::array<Eigen::Vector3d, 4>;

inline PairPositions positions_of(const FeaturePair& pair, const linear::VertexField& x) {
  return {x.col(pair.vertices[0]), x.col(pair.vertices[1]), x.col(pair.vertices[2]), x.col(pair.vertices[3])};
}

// See Ericson 2005, "Real-Time Collision Detection", 5.1.5 and 5.1.9.
Separation separation(FeaturePair::Kind kind, const PairPositions& x);

// Returns true if the pair stands for its separation, rather than another pair that has the same one. A vertex next to
// an edge is left to the triangle that owns the edge, one next to a vertex to the first triangle there. Edges whose
// ends are nearest are left to pairs of a vertex and a triangle.
bool stands_for_separation(const SheetFeatures& features, const FeaturePair& pair, const Separation& separation);

// Returns true if no feature next to the nearest one of side b is nearer to side a. If two vertices are nearest, side a
// is looked at too. For pairs that stand for their separation.
bool is_in_cones(const SheetFeatures& features, const FeaturePair& pair, const Separation& separation,
                 const linear::VertexField& x);

// Returns the gap between two planes perpendicular to `normal` (-, unit), one at each side. m, < 0 if they overlap.
double gap_along(std::size_t num_a, const Eigen::Vector3d& normal, const PairPositions& x);

// Returns true if both sides stay farther apart than `gap` (m) while all vertices move straight from `from` to `to`.
// They must be so at the start. False may also mean that this could not be decided. See Li, Kaufman, Jiang 2021,
// "Codimensional Incremental Potential Contact", 5: additive continuous collision detection.
bool stays_apart(FeaturePair::Kind kind, const PairPositions& from, const PairPositions& to, double gap);

}  // namespace kerf::contact
