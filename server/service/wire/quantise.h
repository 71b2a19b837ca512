#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// Positions as 16-bit integers in a box.
namespace kerf::wire {

// An axis-aligned box in the world. Sizes are powers of two and the corner is a multiple of size / 16, so that
// min + size and size / 65535 lose nothing: sender and receiver compute with the same numbers.
struct FrameBox {
  std::array<double, 3> min{};   // m
  std::array<double, 3> size{};  // m, > 0

  bool operator==(const FrameBox&) const = default;
};

// The box for `positions` (3 V numbers, x y z interleaved, m, finite) after `current`.
// A fresh box has on each axis the smallest power of two >= 1.25 times the sheet's extent there (or a quarter of its
// largest extent, if that is more: a flat sheet will not stay flat), centred to size / 32: at least 7 % of margin on
// every side. `current` is kept while the sheet lies in it and no axis of it is more than 8 times the fresh one's, so
// a sheet that moves about a place keeps its box and its frames can be deltas.
FrameBox choose_box(std::span<const double> positions, const std::optional<FrameBox>& current);

// q = floor((p - min) * (65535 / size) + 0.5), axis by axis; 3 V numbers in 0..65535. The positions must lie in the
// box. The error is at most size / 131070.
std::vector<std::uint16_t> quantise(std::span<const double> positions, const FrameBox& box);

// Strains in 255 steps: strain = q |q| / 127^2 * scale for q in -127..127. Finest about 0, as a few vertices, at pins
// and the ends of cuts, have many times the strain of the others.
struct QuantisedStrains {
  std::vector<std::int8_t> values;  // a vertex
  double scale = 0.0;               // -, the smallest power of two >= 2^-20 that none exceeds, +- 2^10 at most
};
// Numbers that are not finite count as 0.
QuantisedStrains quantise_strains(std::span<const float> strains);

}  // namespace kerf::wire
