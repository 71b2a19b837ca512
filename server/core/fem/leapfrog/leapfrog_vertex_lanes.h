#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fem/leapfrog/leapfrog_kernels.h"
#include "server/core/mesh/vertex_lanes.h"

// Conversion of blocks of vertices of a leapfrog scheme to metres and seconds and back, in vector code chosen for the
// processor at run time. Results have the same bits on every processor.
namespace kerf::fem {

static_assert(mesh::kVertexLanes == linear::kBlockLanes);

// Origin and unit of positions in LeapfrogArrays.
struct PositionFrame {
  std::array<double, 3> origin{};  // m
  const double* starts = nullptr;  // m, x, y, z of an origin for each vertex, in place of `origin`; or null
  double unit = 1.0;               // m, a power of two
};

// Loads a block of vertices. `drift`, s, is that of the last substep; vertices.before becomes the positions before it.
template <typename T>
void load_vertices(const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t block, double drift,
                   mesh::VertexLanes& vertices);
// Stores the vertices whose bits are set in `changed`. Returns the largest component of their positions, in units.
// Float positions beyond 2^30 are wrong.
template <typename T>
double store_vertices(const mesh::VertexLanes& vertices, std::uint32_t changed, const PositionFrame& frame,
                      std::size_t block, const LeapfrogArrays<T>& arrays);

// Writes positions (m) and velocities (m/s) of a block to x, y, z of each vertex in turn. `x` and `v` are those of
// vertex 0; all vertices of the block must exist.
template <typename T>
void write_vertices(const LeapfrogArrays<T>& arrays, const PositionFrame& frame, std::size_t block, double* x,
                    double* v);

}  // namespace kerf::fem
