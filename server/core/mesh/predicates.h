#pragma once

#include <bit>
#include <compare>
#include <cstdint>

namespace kerf::mesh {

__extension__ using Int128 = __int128;

// A point in material coordinates, on the lattice of the mesh (see Lattice). |x|, |y| <= 2^52, so that every difference
// of two coordinates is exact in a double and has at most 54 bits with its sign.
struct LatticePoint {
  std::int64_t x = 0;  // lattice units
  std::int64_t y = 0;  // lattice units
  // NOLINTNEXTLINE(modernize-use-nullptr): a false alarm on defaulted comparisons
  friend auto operator<=>(const LatticePoint&, const LatticePoint&) = default;
};

inline constexpr std::int64_t kMaxCoordinate = std::int64_t{1} << 52;

// All predicates below are exact for every pair of valid points. Signs are -1, 0 or 1. Bits, with differences |d| <=
// 2^53: orient2d |2A| <= 2^107 (128 bits suffice); in_circle <= 3 * 2^107 * 2^107 < 2^216 (256 bits suffice).

// Returns twice the signed area of (a, b, c), lattice units squared; > 0 if counter-clockwise.
inline Int128 doubled_area(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return static_cast<Int128>(b.x - a.x) * (c.y - a.y) - static_cast<Int128>(b.y - a.y) * (c.x - a.x);
}

// Converts to the nearest double, ties to even. The result is that of a cast, but a cast calls a slower library
// function.
inline double to_double(Int128 value) {
  __extension__ using Uint128 = unsigned __int128;
  if (value == static_cast<std::int64_t>(value)) return static_cast<double>(static_cast<std::int64_t>(value));
  const Uint128 magnitude = value < 0 ? -static_cast<Uint128>(value) : static_cast<Uint128>(value);
  // Takes the 63 leading bits. Sets the last of them if any lower bit is set, so that the rounding is that of the whole
  // number.
  const auto high = static_cast<std::uint64_t>(magnitude >> 64);
  const int shift = high == 0 ? 1 : 65 - std::countl_zero(high);
  const bool has_rest = (magnitude & ((Uint128{1} << shift) - 1)) != 0;
  const auto leading = static_cast<std::int64_t>(magnitude >> shift) | (has_rest ? 1 : 0);
  const double scale = std::bit_cast<double>(static_cast<std::uint64_t>(1023 + shift) << 52);
  const double rounded = scale * static_cast<double>(leading);
  return value < 0 ? -rounded : rounded;
}

// Returns 1 if a, b, c turn counter-clockwise, -1 if clockwise, 0 if collinear.
inline int orient2d(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  const Int128 area = doubled_area(a, b, c);
  return area > 0 ? 1 : (area < 0 ? -1 : 0);
}

// Returns the dot product (b - a) . (d - c), lattice units squared.
inline Int128 dot(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  return static_cast<Int128>(b.x - a.x) * (d.x - c.x) + static_cast<Int128>(b.y - a.y) * (d.y - c.y);
}

// Returns 1 if d lies strictly inside the circle of the counter-clockwise triangle (a, b, c), 0 if on it, -1 if
// outside. Almost always a floating-point filter decides (Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic
// and Fast Robust Geometric Predicates", bound A); otherwise 256-bit integers.
int in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d);

// Returns the same as in_circle, always with integers; declared for tests of the filter.
int in_circle_exact(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d);

// Returns true if the open segments ab and cd cross at one point interior to both (touching and overlapping do not
// count).
bool segments_cross(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d);

// Returns the lattice point nearest to the crossing of lines ab and cd. Each coordinate is rounded to nearest (ties
// away from a), so at most half a unit off in x and in y. The lines must not be parallel and the crossing must lie
// between a and b (inclusive).
LatticePoint rounded_crossing(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                              const LatticePoint& d);

// Returns the lattice point nearest to the point of segment ab that is nearest to p, rounded as above; a != b.
LatticePoint rounded_projection(const LatticePoint& a, const LatticePoint& b, const LatticePoint& p);

}  // namespace kerf::mesh
