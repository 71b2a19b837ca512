#include "server/core/mesh/predicates.h"

#include <cmath>

#include "server/base/check.h"

namespace kerf::mesh {
namespace {

__extension__ using Uint128 = unsigned __int128;

// An integer of 256 bits in two's complement, for sums of products of two 128-bit integers.
struct Int256 {
  Uint128 low = 0;
  Int128 high = 0;

  Int256& operator+=(Int256 other) {  // by value: x += x must work
    low += other.low;
    const Uint128 carry = low < other.low ? 1 : 0;
    high = static_cast<Int128>(static_cast<Uint128>(high) + static_cast<Uint128>(other.high) + carry);
    return *this;
  }
  [[nodiscard]] Int256 negated() const {
    const Uint128 flipped_low = ~low + 1;
    return {flipped_low, static_cast<Int128>(~static_cast<Uint128>(high) + (flipped_low == 0 ? 1 : 0))};
  }
  [[nodiscard]] int sign() const {
    if (high < 0) return -1;
    return high > 0 || low > 0 ? 1 : 0;
  }
};

Int256 multiply_unsigned(Uint128 a, Uint128 b) {
  constexpr Uint128 kMask = ~std::uint64_t{0};
  // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): it takes 128-bit shifts for undefined
  const Uint128 a0 = a & kMask, a1 = a >> 64, b0 = b & kMask, b1 = b >> 64;
  const Uint128 p00 = a0 * b0, p01 = a0 * b1, p10 = a1 * b0, p11 = a1 * b1;
  const Uint128 middle = (p00 >> 64) + (p01 & kMask) + (p10 & kMask);
  return {(middle << 64) | (p00 & kMask), static_cast<Int128>(p11 + (p01 >> 64) + (p10 >> 64) + (middle >> 64))};
}

Int256 multiply(Int128 a, Int128 b) {
  const Uint128 absolute_a = a < 0 ? -static_cast<Uint128>(a) : static_cast<Uint128>(a);
  const Uint128 absolute_b = b < 0 ? -static_cast<Uint128>(b) : static_cast<Uint128>(b);
  const Int256 product = multiply_unsigned(absolute_a, absolute_b);
  return (a < 0) != (b < 0) ? product.negated() : product;
}

// Returns round(value * numerator / denominator), ties away from zero; 0 <= numerator <= denominator, denominator > 0,
// |value| <= 2^53. Starts from a floating-point guess (relative error < 2^-50, so off by a few units at most) and walks
// to the exact answer: the integer q with |2 (value * numerator - q * denominator)| <= denominator.
std::int64_t rounded_share(std::int64_t value, Int128 numerator, Int128 denominator) {
  const bool negative = value < 0;
  const std::int64_t magnitude = negative ? -value : value;
  const double guess =
      static_cast<double>(magnitude) * (static_cast<double>(numerator) / static_cast<double>(denominator));
  std::int64_t q = std::llrint(guess);
  const Int256 product = multiply(magnitude, numerator);
  const auto doubled_remainder = [&](std::int64_t quotient) {
    Int256 remainder = product;
    remainder += multiply(quotient, denominator).negated();
    remainder += remainder;
    return remainder;
  };
  const Int256 one_denominator{static_cast<Uint128>(denominator), 0};
  for (int guard = 0; guard < 64; ++guard) {
    Int256 above = doubled_remainder(q);
    Int256 below = above;
    above += one_denominator.negated();  // 2 r - d >= 0: the next integer is nearer, or as near (away from zero)
    below += one_denominator;            // 2 r + d < 0: the one before is nearer
    if (above.sign() >= 0) {
      ++q;
    } else if (below.sign() < 0) {
      --q;
    } else {
      return negative ? -q : q;
    }
  }
  KERF_CHECK(false, "the floating-point guess of a rounded quotient is within a few units");
  return 0;
}

LatticePoint point_at(const LatticePoint& a, const LatticePoint& b, Int128 numerator, Int128 denominator) {
  return {a.x + rounded_share(b.x - a.x, numerator, denominator),
          a.y + rounded_share(b.y - a.y, numerator, denominator)};
}

}  // namespace

int in_circle_exact(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  const std::int64_t adx = a.x - d.x, ady = a.y - d.y;
  const std::int64_t bdx = b.x - d.x, bdy = b.y - d.y;
  const std::int64_t cdx = c.x - d.x, cdy = c.y - d.y;
  const auto lift = [](std::int64_t x, std::int64_t y) {
    return static_cast<Int128>(x) * x + static_cast<Int128>(y) * y;
  };
  const auto minor = [](std::int64_t x1, std::int64_t y1, std::int64_t x2, std::int64_t y2) {
    return static_cast<Int128>(x1) * y2 - static_cast<Int128>(y1) * x2;
  };
  Int256 determinant = multiply(lift(adx, ady), minor(bdx, bdy, cdx, cdy));
  determinant += multiply(lift(bdx, bdy), minor(cdx, cdy, adx, ady));
  determinant += multiply(lift(cdx, cdy), minor(adx, ady, bdx, bdy));
  return determinant.sign();
}

int in_circle(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  // Differences are exact in double (at most 53 bits). Shewchuk's bound A would even allow rounded ones.
  const double adx = static_cast<double>(a.x - d.x), ady = static_cast<double>(a.y - d.y);
  const double bdx = static_cast<double>(b.x - d.x), bdy = static_cast<double>(b.y - d.y);
  const double cdx = static_cast<double>(c.x - d.x), cdy = static_cast<double>(c.y - d.y);
  const double bdxcdy = bdx * cdy, cdxbdy = cdx * bdy;
  const double cdxady = cdx * ady, adxcdy = adx * cdy;
  const double adxbdy = adx * bdy, bdxady = bdx * ady;
  const double alift = adx * adx + ady * ady;
  const double blift = bdx * bdx + bdy * bdy;
  const double clift = cdx * cdx + cdy * cdy;
  const double determinant = alift * (bdxcdy - cdxbdy) + blift * (cdxady - adxcdy) + clift * (adxbdy - bdxady);
  const double permanent = (std::abs(bdxcdy) + std::abs(cdxbdy)) * alift +
                           (std::abs(cdxady) + std::abs(adxcdy)) * blift +
                           (std::abs(adxbdy) + std::abs(bdxady)) * clift;
  constexpr double kEpsilon = 0x1.0p-53;
  constexpr double kBoundA = (10.0 + 96.0 * kEpsilon) * kEpsilon;
  const double bound = kBoundA * permanent;
  if (determinant > bound) return 1;
  if (-determinant > bound) return -1;
  return in_circle_exact(a, b, c, d);
}

bool segments_cross(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c, const LatticePoint& d) {
  return orient2d(a, b, c) * orient2d(a, b, d) < 0 && orient2d(c, d, a) * orient2d(c, d, b) < 0;
}

// The crossing is at a + t (b - a), t = A / (A - B), A and B the areas of (c, d, a) and (c, d, b).
LatticePoint rounded_crossing(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                              const LatticePoint& d) {
  Int128 numerator = doubled_area(c, d, a);
  Int128 denominator = numerator - doubled_area(c, d, b);
  KERF_DCHECK(denominator != 0, "the lines cross");
  if (denominator < 0) numerator = -numerator, denominator = -denominator;
  KERF_DCHECK(numerator >= 0 && numerator <= denominator, "the crossing lies between a and b");
  return point_at(a, b, numerator, denominator);
}

LatticePoint rounded_projection(const LatticePoint& a, const LatticePoint& b, const LatticePoint& p) {
  const Int128 denominator = dot(a, b, a, b);
  KERF_DCHECK(denominator > 0, "a segment to project on has a length");
  const Int128 numerator = dot(a, b, a, p);
  if (numerator <= 0) return a;
  if (numerator >= denominator) return b;
  return point_at(a, b, numerator, denominator);
}

}  // namespace kerf::mesh
