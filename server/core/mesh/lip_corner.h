#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Finds sharp corners: points where two fixed edges (lips, border, region borders) enclose material at an angle below
// 60 degrees. No refinement can widen such an angle, and without a guard refinement would never end there.
class LipCorners {
 public:
  explicit LipCorners(const TriangleMesh& mesh) : mesh_(mesh) {}

  static constexpr double kCosSharp = 0.5;  // cos 60 degrees

  // Returns the cosine of the smallest angle between two fixed edges at p with material in between. Returns kCosSharp
  // if no such angle is below 60 degrees.
  [[nodiscard]] double sharpest(PointId p);
  [[nodiscard]] bool is_sharp(PointId p) { return sharpest(p) > kCosSharp; }

  // Returns 0 unless edge pq is forced by a sharp corner: p and q lie on different lips of it, equally far from it.
  // Otherwise returns the number (>= 1) of lip edges from that corner to p or q, the larger of the two. Such an edge is
  // the "seditious" one of Miller, Pav and Walkington.
  [[nodiscard]] int edges_to_sharp_corner(PointId p, PointId q);

  // Returns where to split the fixed edge ab: the distance from a over `length` (of ab, lattice units), in [1/3, 2/3].
  // This is the middle, unless exactly one end is a sharp corner. Then the distance from that corner is a power of two
  // (lattice units), so that both lips of the corner are split alike.
  [[nodiscard]] double split_fraction(PointId a, PointId b, double length);

 private:
  // A point reached from a start point along fixed edges that run on nearly straight.
  struct Reach {
    PointId point = kNone;
    double distance = 0.0;  // lattice units, straight from the start point
    int edges = 0;          // number of fixed edges from the start point
  };

  void find_fixed_neighbours(PointId p, std::vector<PointId>& neighbours);
  void follow_lips(PointId p, std::vector<Reach>& reached);

  const TriangleMesh& mesh_;
  std::vector<TriangleId> fan_;
  std::vector<PointId> ends_, onward_;
  std::vector<Reach> from_p_, from_q_;
};

}  // namespace kerf::mesh
