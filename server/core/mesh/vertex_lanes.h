#pragma once

#include <array>
#include <cstddef>

namespace kerf::mesh {

// Number of vertices in a block that vector code works on. It is a multiple of any processor's vector width, so that
// results do not depend on the processor. Block b of a mesh holds the vertices from kVertexLanes * b on.
inline constexpr std::size_t kVertexLanes = 16;

// Positions and velocities of the vertices of a block, side by side.
struct alignas(64) VertexLanes {
  using Lanes = std::array<double, kVertexLanes>;
  std::array<Lanes, 3> x{};       // m
  std::array<Lanes, 3> v{};       // m/s
  std::array<Lanes, 3> before{};  // m, positions at the start of the substep
};

}  // namespace kerf::mesh
