#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Constants of kLanes consecutive triangle slots, an array of structures of arrays: lane l of block b is slot kLanes *
// b + l. The constants of a block are contiguous, so a loop over blocks reads one stream of memory. A loop over the
// lanes of a block works on equal fields side by side. A compiler turns it into vector code of up to 8 doubles. Lanes
// never mix, so results do not depend on the width. A slot without material has area 0 and exerts exactly no force.
inline constexpr int kLanes = 8;

struct alignas(64) ElementBlock {
  // Rows of Dm^-1 in material axes, 1/m: gradients of the shape functions of corners 1 and 2. Corner 0 has minus their
  // sum. F = [x1 - x0, x2 - x0] Dm^-1.
  std::array<std::array<double, kLanes>, 2> g1{};  // [component][lane]
  std::array<std::array<double, kLanes>, 2> g2{};
  std::array<double, kLanes> area{};                           // m^2, of the rest triangle; 0 without material
  std::array<std::array<mesh::VertexId, kLanes>, 3> vertex{};  // [corner][lane]; 0 without material
  std::array<std::uint8_t, kLanes> material{};                 // in the sheet's MaterialTable; 0 without material

  // Returns true if all lanes, including those without material, have the law of lane 0.
  [[nodiscard]] bool has_one_material() const {
    return std::bit_cast<std::uint64_t>(material) == material[0] * 0x0101010101010101U;
  }
};

}  // namespace kerf::fem
