#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Irregular triangles of a mixed-precision sheet that are too flat for fixed-point positions. Their forces are computed
// in double, from positions with their remainders, and replace those of their lanes.
struct FineTriangles {
  double gradient = std::numeric_limits<double>::infinity();  // 1/m, threshold above which a triangle is fine
  std::vector<std::int32_t> place_of_lane;                    // index in `lanes`, or kNone; by irregular lane
  std::vector<std::int32_t> lanes;                            // in any order: lanes never mix
  std::vector<mesh::TriangleId> slots;                        // by place in `lanes`
  std::vector<mesh::VertexId> vertices;                       // unique
  std::vector<std::int32_t> places;  // of forces: 4 x corner_place() of each corner of each slot
  std::vector<float> forces;         // N, x 4, for these places
  // Arrays of the slots in their order; `from` is 4 x the index in `vertices`.
  std::vector<IrregularBlock<double>> blocks;
  std::vector<EdgeLanes<double>> edges;
  std::vector<LawLanes<double>> laws;
  std::vector<linear::Lanes16<double>> corner_x, corner_force;
  double unit = 1.0;  // m, unit of the constants

  [[nodiscard]] bool empty() const { return lanes.empty(); }
  // Adds a lane to the set, or removes it.
  void set_lane(std::int32_t lane, bool is_fine);
  [[nodiscard]] LeapfrogArrays<double> arrays();
  // Rounds the results of leapfrog_irregular().
  void set_forces();
};

}  // namespace kerf::fem
