#include "server/base/elementary.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "server/base/double_double.h"

namespace kerf {
namespace {

__extension__ using Product128 = unsigned __int128;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr DoubleDouble kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr DoubleDouble kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

// Returns c[0] + x (c[1] + x (c[2] + ...)).
template <std::size_t n>
double polynomial(const std::array<double, n>& coefficients, double x) {
  double sum = coefficients[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) sum = coefficients[i] + x * sum;
  return sum;
}

// 2 / pi in binary, after 64 zeros. It is long enough for the largest double.
constexpr std::array<std::uint64_t, 21> kTwoOverPi{
    0,
    0xa2f9836e4e441529ULL,
    0xfc2757d1f534ddc0ULL,
    0xdb6295993c439041ULL,
    0xfe5163abdebbc561ULL,
    0xb7246e3a424dd2e0ULL,
    0x06492eea09d1921cULL,
    0xfe1deb1cb129a73eULL,
    0xe88235f52ebb4484ULL,
    0xe99c7026b45f7e41ULL,
    0x3991d639835339f4ULL,
    0x9c845f8bbdf9283bULL,
    0x1ff897ffde05980fULL,
    0xef2f118b5a0a6d1fULL,
    0x6d367ecf27cb09b7ULL,
    0x4f463f669e5fea2dULL,
    0x7527bac7ebe5f17bULL,
    0x3d0739f78a5292eaULL,
    0x6bfb5fb11f8d5d08ULL,
    0x56033046fc7b6babULL,
    0xf0cfbc209af4361dULL,
};

// An angle as quadrants * pi / 2 + rest, with |rest| <= pi / 4 and the quadrants counted modulo 4.
struct ReducedAngle {
  std::uint64_t quadrants = 0;
  DoubleDouble rest;  // rad
};

// Reduces an angle >= 0 by the method of Payne and Hanek (1983): of the product with 2 / pi, only those bits are
// computed that are neither multiples of 4 nor too small to matter.
ReducedAngle reduce(double angle) {
  if (angle <= 0.5 * kHalfPi.high) return {0, {angle, 0.0}};
  const auto bits = std::bit_cast<std::uint64_t>(angle);
  const std::uint64_t mantissa = (bits & ((1ULL << 52U) - 1)) | (1ULL << 52U);
  const auto exponent = static_cast<std::int64_t>(bits >> 52U) - 1075;  // angle = mantissa * 2^exponent
  // The first bit of 2 / pi whose product is no multiple of 4 has weight 2^(2 - exponent).
  const auto first = static_cast<std::size_t>(exponent - 2 + 64);
  std::array<std::uint64_t, 3> window{};
  for (std::size_t i = 0; i < window.size(); ++i) {
    const std::size_t word = first / 64 + i;
    const std::size_t shift = first % 64;
    window[i] = kTwoOverPi[word] << shift;
    if (shift > 0) window[i] |= kTwoOverPi[word + 1] >> (64 - shift);
  }
  // angle * 2 / pi modulo 4, in units of 2^-190, from the highest word to the lowest.
  const Product128 lowest = Product128{mantissa} * window[2];
  const Product128 middle = Product128{mantissa} * window[1] + static_cast<std::uint64_t>(lowest >> 64U);
  const std::uint64_t highest = mantissa * window[0] + static_cast<std::uint64_t>(middle >> 64U);
  std::array<std::uint64_t, 3> turns{highest, static_cast<std::uint64_t>(middle), static_cast<std::uint64_t>(lowest)};
  const std::uint64_t quadrants = ((turns[0] >> 61U) + 1) >> 1U;  // rounded
  turns[0] -= quadrants << 62U;
  const bool is_negative = (turns[0] >> 63U) != 0;
  if (is_negative) {
    turns[2] = ~turns[2] + 1;
    turns[1] = ~turns[1] + (turns[2] == 0 ? 1 : 0);
    turns[0] = ~turns[0] + (turns[1] == 0 && turns[2] == 0 ? 1 : 0);
  }
  DoubleDouble rest;
  double weight = 0x1p-30;  // of the upper half of a word, in quadrants
  for (const std::uint64_t word : turns) {
    for (const std::uint64_t half : {word >> 32U, word & UINT64_C(0xffffffff)}) {
      rest = rest + DoubleDouble{static_cast<double>(half) * weight, 0.0};
      weight *= 0x1p-32;
    }
  }
  rest = rest * kHalfPi;
  return {quadrants & 3U, is_negative ? -rest : rest};
}

// Taylor series; the first term left out is below 2^-62 of the result for |rest| <= pi / 4.
double sine_of_rest(const DoubleDouble& rest) {
  static constexpr std::array<double, 7> kSeries{1.0 / 120.0,         -1.0 / 5040.0,      1.0 / 362880.0,
                                                 -1.0 / 39916800.0,   1.0 / 6227020800.0, -1.0 / 1307674368e3,
                                                 1.0 / 355687428096e3};
  constexpr DoubleDouble kSixth{1.0 / 6.0, 0x1.5555555555555p-57};
  const DoubleDouble square = rest * rest;
  const DoubleDouble tail{polynomial(kSeries, square.high) * square.high * square.high, 0.0};
  return (rest + rest * (tail - square * kSixth)).rounded();
}

double cosine_of_rest(const DoubleDouble& rest) {
  static constexpr std::array<double, 8> kSeries{1.0 / 24.0,          -1.0 / 720.0,          1.0 / 40320.0,
                                                 -1.0 / 3628800.0,    1.0 / 479001600.0,     -1.0 / 87178291200.0,
                                                 1.0 / 20922789888e3, -1.0 / 6402373705728e3};
  const DoubleDouble square = exact_product(rest.high, rest.high);
  const DoubleDouble head = quick_sum(1.0, -0.5 * square.high);
  const double fourth = polynomial(kSeries, square.high) * square.high * square.high;
  return head.high + (head.low + (fourth - (0.5 * square.low + rest.high * rest.low)));
}

// arctan(k / 8)
constexpr std::array<DoubleDouble, 9> kArcTangents{{
    {0.0, 0.0},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
}};

// Returns arctan(a / b) for 0 <= a <= b: that of the nearest k / 8, and a series for the rest.
DoubleDouble first_octant(const DoubleDouble& a, const DoubleDouble& b) {
  static constexpr std::array<double, 8> kSeries{-1.0 / 3.0,  1.0 / 5.0,  -1.0 / 7.0,  1.0 / 9.0,
                                                 -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0, 1.0 / 17.0};
  const auto nearest = static_cast<std::size_t>(8.0 * (a.high / b.high) + 0.5);
  const DoubleDouble step{0.125 * static_cast<double>(nearest), 0.0};
  const DoubleDouble rest = (a - step * b) / (b + step * a);
  const double square = rest.high * rest.high;
  return kArcTangents[nearest] + quick_sum(rest.high, rest.low + polynomial(kSeries, square) * square * rest.high);
}

// Returns the angle of the point (x, y), y >= 0 and not both 0. Neither is beyond 2^600, and the larger one is above
// 2^-600.
double angle_of(const DoubleDouble& y, double x) {
  const DoubleDouble width{std::abs(x), 0.0};
  const bool is_steep = y.high > width.high;
  DoubleDouble angle = is_steep ? kHalfPi - first_octant(width, y) : first_octant(y, width);
  if (std::signbit(x)) angle = kPi - angle;
  return angle.rounded();
}

// Scales numbers out of the range of angle_of(), and handles those beside which the other one vanishes. y >= 0.
double upper_half_turn(double y, double x) {
  const double width = std::abs(x);
  if (std::isinf(y)) {
    if (!std::isinf(x)) return kHalfPi.high;
    return (x > 0.0 ? 0.5 : 1.5) * kHalfPi.high;
  }
  if (y == 0.0 || std::isinf(x)) return std::signbit(x) ? kPi.high : 0.0;
  constexpr double kVanishing = 0x1p-60;
  if (x > 0.0 && y < kVanishing * width) return y / x;  // arctan(t) = t
  const double larger = std::max(y, width);
  const double scale = larger > 0x1p500 ? 0x1p-600 : larger < 0x1p-400 ? 0x1p600 : 1.0;
  return angle_of({y * scale, 0.0}, x * scale);
}

constexpr double kLn2High = 0x1.62e42fee00000p-1;  // 32 bits: products with an exponent are exact
constexpr DoubleDouble kLn2Low{0x1.a39ef35793c76p-33, 0x1.cc01f97b57a08p-87};

// Returns the logarithm of a positive finite number with some 64 bits.
DoubleDouble precise_logarithm(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  if (mantissa < 0x1.6a09e667f3bcdp-1) {  // sqrt(0.5)
    mantissa *= 2.0;
    --exponent;
  }
  // log m = 2 artanh(s), s = (m - 1) / (m + 1): a series in s^2 < 0.03, of which two terms need more than a double.
  static constexpr std::array<double, 11> kSeries{1.0 / 5.0,  1.0 / 7.0,  1.0 / 9.0,  1.0 / 11.0,
                                                  1.0 / 13.0, 1.0 / 15.0, 1.0 / 17.0, 1.0 / 19.0,
                                                  1.0 / 21.0, 1.0 / 23.0, 1.0 / 25.0};
  constexpr DoubleDouble kThird{1.0 / 3.0, 0x1.5555555555555p-56};
  const DoubleDouble s = exact_sum(mantissa, -1.0) / exact_sum(mantissa, 1.0);
  const DoubleDouble square = s * s;
  const DoubleDouble tail{polynomial(kSeries, square.high) * square.high * square.high, 0.0};
  const DoubleDouble twice{2.0 * s.high, 2.0 * s.low};
  const DoubleDouble of_mantissa = twice + twice * (square * kThird + tail);
  const auto whole = static_cast<double>(exponent);
  return DoubleDouble{whole * kLn2High, 0.0} + (DoubleDouble{whole, 0.0} * kLn2Low + of_mantissa);
}

// Returns the exponential of a finite number.
double exponential_of(const DoubleDouble& x) {
  if (x.high > 710.0) return kInfinity;
  if (x.high < -746.0) return 0.0;
  constexpr double kPerLn2 = 0x1.71547652b82fep+0;
  const double exponent = std::floor(x.high * kPerLn2 + 0.5);
  const DoubleDouble rest = (x - DoubleDouble{exponent * kLn2High, 0.0}) - DoubleDouble{exponent, 0.0} * kLn2Low;
  // Taylor series of exp(rest) - 1 - rest - rest^2 / 2, |rest| <= 0.35.
  static constexpr std::array<double, 12> kSeries{
      1.0 / 6.0,      1.0 / 24.0,      1.0 / 120.0,      1.0 / 720.0,       1.0 / 5040.0,       1.0 / 40320.0,
      1.0 / 362880.0, 1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0, 1.0 / 87178291200.0};
  const DoubleDouble square = rest * rest;
  const double cube = polynomial(kSeries, rest.high) * square.high * rest.high;
  const DoubleDouble head = exact_sum(1.0, rest.high);
  const DoubleDouble sum = exact_sum(head.high, 0.5 * square.high);
  const double factor = sum.high + (sum.low + (head.low + (rest.low + (0.5 * square.low + cube))));
  return std::ldexp(factor, static_cast<int>(exponent));
}

// Returns what both logarithms make of an argument without a finite logarithm.
double logarithm_without_value(double x) {
  if (x == 0.0) return -kInfinity;
  return x > 0.0 ? x : kNan;
}

bool has_logarithm(double x) {
  return x > 0.0 && std::isfinite(x);
}

}  // namespace

double sine(double angle) {
  if (!std::isfinite(angle)) return kNan;
  if (std::abs(angle) < 0x1p-27) return angle;
  const auto [quadrants, rest] = reduce(std::abs(angle));
  const double value = (quadrants & 1U) != 0 ? cosine_of_rest(rest) : sine_of_rest(rest);
  return (quadrants >= 2) != (angle < 0.0) ? -value : value;
}

double cosine(double angle) {
  if (!std::isfinite(angle)) return kNan;
  const auto [quadrants, rest] = reduce(std::abs(angle));
  const double value = (quadrants & 1U) != 0 ? sine_of_rest(rest) : cosine_of_rest(rest);
  return quadrants == 1 || quadrants == 2 ? -value : value;
}

double arc_tangent(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  return std::copysign(upper_half_turn(std::abs(y), x), y);
}

double arc_cosine(double cosine) {
  if (!(std::abs(cosine) <= 1.0)) return kNan;
  if (cosine == 1.0) return 0.0;
  const DoubleDouble square = exact_product(cosine, cosine);
  return angle_of(square_root(DoubleDouble{1.0, 0.0} - square), cosine);
}

double exponential(double x) {
  if (std::isnan(x)) return kNan;
  if (std::isinf(x)) return x > 0.0 ? x : 0.0;
  return exponential_of({x, 0.0});
}

double logarithm(double x) {
  return has_logarithm(x) ? precise_logarithm(x).rounded() : logarithm_without_value(x);
}

double decimal_logarithm(double x) {
  constexpr DoubleDouble kPerLn10{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
  return has_logarithm(x) ? (precise_logarithm(x) * kPerLn10).rounded() : logarithm_without_value(x);
}

double power(double x, double y) {
  if (y == 0.0 || x == 1.0) return 1.0;
  if (std::isnan(x) || std::isnan(y)) return kNan;
  const double size = std::abs(x);
  if (std::isinf(y) && size == 1.0) return 1.0;
  const bool is_whole = std::isinf(y) || std::floor(y) == y;
  const bool is_odd = std::isfinite(y) && std::fmod(y, 2.0) != 0.0 && is_whole;
  if (x < 0.0 && std::isfinite(x) && !is_whole) return kNan;
  double result = 0.0;
  if (size == 0.0 || std::isinf(size) || std::isinf(y)) {
    result = (size > 1.0) == (y > 0.0) ? kInfinity : 0.0;
  } else {
    // A logarithm is 0 or above 2^-53 and below 2^10, so an exponent beyond 2^66 leaves the range of doubles.
    const DoubleDouble exponent{std::fmin(std::fmax(y, -0x1p66), 0x1p66), 0.0};
    result = exponential_of(precise_logarithm(size) * exponent);
  }
  return std::signbit(x) && is_odd ? -result : result;
}

}  // namespace kerf
