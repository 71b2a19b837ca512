#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/mesh/vertex_lanes.h"

// Blocks of vertices of a leapfrog scheme in metres and seconds, and back, in vector code chosen for the processor at
// run time: the same bits on every processor.
namespace kerf::fem {

static_assert(mesh::kVertexLanes == kBlockLanes);

// The origin that positions of LeapfrogArrays count from, and their unit.
struct PositionFrame {
  std::array<double, 3> origin{};  // m
  const double* starts = nullptr;  // m, x, y, z of each vertex, in place of the origin; or null
  double unit = 1.0;               // m, a power of two
};

// `drift`: s, of the substep that led here from `before`.
template <typename T>
void load_vertices(const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                   mesh::VertexLanes& vertices);
// Those of which `changed` has the bit. Returns the largest component of their positions, in units;
// positions of floats beyond 2^30 are not right.
template <typename T>
double store_vertices(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                      std::size_t block, const LeapfrogArrays<T>& arrays);

}  // namespace kerf::fem
