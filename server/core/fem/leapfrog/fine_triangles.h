#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Irregular triangles of a sheet in mixed precision that are too flat for fixed-point positions: their forces are made
// in double, from positions with their remainders, and put in place of those of their lanes.
struct FineTriangles {
  double gradient = std::numeric_limits<double>::infinity();  // 1/m, above which a triangle is one of them
  std::vector<std::int32_t> place_of_lane;                    // into `lanes`, or kNone; by irregular lane
  std::vector<std::int32_t> lanes;                            // in any order: lanes never mix
  std::vector<mesh::TriangleId> slots;                        // of the lanes
  std::vector<mesh::VertexId> vertices;                       // unique
  std::vector<std::int32_t> places;  // of forces: 4 x corner_place() of each corner of each slot
  std::vector<float> forces;         // N, x 4, for these places
  // Arrays of the slots in their order; `from` is 4 x the place in `vertices`.
  std::vector<IrregularBlock<double>> blocks;
  std::vector<EdgeLanes<double>> edges;
  std::vector<LawLanes<double>> laws;
  std::vector<Lanes16<double>> corner_x, corner_force;
  double unit = 1.0;  // m, of the constants

  [[nodiscard]] bool empty() const { return lanes.empty(); }
  // Makes a lane one of them, or no longer.
  void set_lane(std::int32_t lane, bool is_fine);
  [[nodiscard]] LeapfrogArrays<double> arrays();
  // Rounds what leapfrog_irregular() has made.
  void set_forces();
};

}  // namespace kerf::fem
