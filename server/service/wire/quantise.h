#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// Quantises positions to 16-bit integers in a box.
namespace kerf::wire {

// Represents an axis-aligned box in the world. Sizes are powers of two and the corner is a multiple of size / 16. Hence
// min + size and size / 65535 are exact: sender and receiver compute with the same numbers.
struct FrameBox {
  std::array<double, 3> min{};   // m
  std::array<double, 3> size{};  // m, > 0

  bool operator==(const FrameBox&) const = default;
};

// Returns the box for `positions` (3 V numbers, x y z interleaved, m, finite). `current`: the box of the frame before.
//
// A fresh box is on each axis the smallest power of two >= 1.25 times the sheet's extent there. On each axis, at least
// a quarter of the sheet's largest extent is assumed, because a flat sheet will not stay flat. The box is centred on
// the sheet to within size / 32, which leaves a margin of at least 6.8 % of its size on every side.
//
// `current` is kept while the sheet lies in it and none of its sides exceeds 8 times that of a fresh box. Thus a sheet
// that moves about a place keeps its box, and its frames can be deltas.
FrameBox choose_box(std::span<const double> positions, const std::optional<FrameBox>& current);

// Computes q = floor((p - min) * (65535 / size) + 0.5) per axis; 3 V numbers in 0..65535. The positions must lie in the
// box. The error is at most size / 131070.
std::vector<std::uint16_t> quantise(std::span<const double> positions, const FrameBox& box);

// Holds strains in 255 steps: strain = q |q| / 127^2 * scale for q in -127..127. Steps are finest about 0, because a
// few vertices, at pins and the ends of cuts, have many times the strain of the others.
struct QuantisedStrains {
  std::vector<std::int8_t> values;  // One per vertex.
  // -, the smallest power of two >= 2^-20 that no magnitude exceeds, but at most 2^10: larger strains are clipped.
  double scale = 0.0;
};
// Quantises strains; numbers that are not finite count as 0.
QuantisedStrains quantise_strains(std::span<const float> strains);

}  // namespace kerf::wire
