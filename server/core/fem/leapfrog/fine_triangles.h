#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Triangles of a mixed-precision sheet that are too flat for fixed-point positions. They are among the irregular lanes
// of MembraneLayout. Their forces are computed in double, from positions with their remainders, and replace the float
// forces of these lanes.
struct FineTriangles {
  double gradient = std::numeric_limits<double>::infinity();  // 1/m, threshold above which a triangle is fine
  std::vector<std::int32_t> place_of_lane;                    // by irregular lane: its index in `lanes`, or kNone
  std::vector<std::int32_t> lanes;                            // irregular lanes that are fine, in any order
  std::vector<mesh::TriangleId> slots;                        // slot of each of `lanes`
  std::vector<mesh::VertexId> vertices;                       // corners of all fine triangles, unique
  std::vector<std::int32_t> places;                           // 4 x corner_place() of each corner of each of `lanes`
  std::vector<float> forces;                                  // N, x 4, in the order of `places`
  // Constants and scratch in the order of `slots`. IrregularBlock::from is 4 x the index in `vertices`.
  std::vector<IrregularBlock<double>> blocks;
  std::vector<EdgeLanes<double>> edges;
  std::vector<LawLanes<double>> laws;
  std::vector<linear::Lanes16<double>> corner_x, corner_force;
  double unit = 1.0;  // m, unit of lengths in `blocks` and `edges`

  [[nodiscard]] bool empty() const { return lanes.empty(); }
  // Adds a lane to the set, or removes it.
  void set_lane(std::int32_t lane, bool is_fine);
  [[nodiscard]] LeapfrogArrays<double> arrays();
  // Sets `forces` to the results of leapfrog_irregular(), rounded to floats.
  void set_forces();
};

}  // namespace kerf::fem
