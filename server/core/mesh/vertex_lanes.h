#pragma once

#include <array>
#include <cstddef>

namespace kerf::mesh {

// Vertices that vector code works on at a time; a multiple of what any processor does at once, so that results do not
// depend on the processor. Block b of a mesh holds the vertices kVertexLanes b and following.
inline constexpr std::size_t kVertexLanes = 16;

// Moving vertices of a block, side by side.
struct alignas(64) VertexLanes {
  using Lanes = std::array<double, kVertexLanes>;
  std::array<Lanes, 3> x{};       // m
  std::array<Lanes, 3> v{};       // m/s
  std::array<Lanes, 3> before{};  // m, where they were when the substep began
};

}  // namespace kerf::mesh
