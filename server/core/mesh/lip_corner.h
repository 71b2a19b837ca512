#pragma once

#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Sharp corners between fixed edges (lips, border, region borders): points where two of them meet at less than 60
// degrees with material in between. No refinement can widen such an angle; without a guard, refinement would never end
// there.
class LipCorners {
 public:
  explicit LipCorners(const TriangleMesh& mesh) : mesh_(mesh) {}

  static constexpr double kCosSharp = 0.5;  // cos 60 degrees

  // Cosine of the smallest angle between two fixed edges at p with material in between, if below 60 degrees, and else
  // kCosSharp.
  [[nodiscard]] double sharpest(PointId p);
  [[nodiscard]] bool is_sharp(PointId p) { return sharpest(p) > kCosSharp; }

  // Returns 0 unless a sharp corner forces edge pq; then the number of lip edges (>= 1) from the corner to the farther
  // of p and q. A corner does so if p and q lie equally far from it, one on each of its lips. Such an edge is
  // the "seditious" one of Miller, Pav and Walkington.
  [[nodiscard]] int edges_to_sharp_corner(PointId p, PointId q);

  // Returns the place to split the fixed edge ab of this length (lattice units), as a fraction from a, in [1/3, 2/3].
  // This is the middle, unless just one end is a sharp corner. Then its distance from the corner is a power of two
  // (lattice units), so that the parts of both lips of the corner match.
  [[nodiscard]] double split_fraction(PointId a, PointId b, double length);

 private:
  // A point on the fixed edges that run on from another, and how it lies from there.
  struct Reach {
    PointId point = kNone;
    double distance = 0.0;  // lattice units, straight
    int edges = 0;          // between the two
  };

  void find_fixed_neighbours(PointId p, std::vector<PointId>& neighbours);
  void follow_lips(PointId p, std::vector<Reach>& reached);

  const TriangleMesh& mesh_;
  std::vector<TriangleId> fan_;
  std::vector<PointId> ends_, onward_;
  std::vector<Reach> from_p_, from_q_;
};

}  // namespace kerf::mesh
