#include "server/base/elementary.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/base/state_hash.h"
#include "tests/support/trials.h"

namespace kerf {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// Returns the error of a result in units in the last place. The long double functions of the C library have 64 bits.
double error_of(double result, long double exact) {
  const auto rounded = static_cast<double>(exact);
  if (!std::isfinite(rounded) || !std::isfinite(result)) {
    return std::isnan(rounded) ? (std::isnan(result) ? 0.0 : kInfinite) : (result == rounded ? 0.0 : kInfinite);
  }
  int exponent = 0;
  static_cast<void>(std::frexp(rounded, &exponent));
  const int last_place = std::max(exponent - 53, -1074);
  return static_cast<double>(std::abs((static_cast<long double>(result) - exact) / std::ldexp(1.0L, last_place)));
}

class ElementaryAccuracy : public testing::Test {
 protected:
  // Returns a double with random bits: of any size, and now and then no number.
  double any() { return std::bit_cast<double>(random_.next()); }
  // Returns a number of any size between 2^-60 and 2^60.
  double scaled() { return std::ldexp(random_.uniform(0.5, 1.0), static_cast<int>(random_.below(121)) - 60); }
  template <class Function, class Exact, class Argument>
  void expect_error_below(double most, Function function, Exact exact, Argument argument) {
    for (int i = 0; i < trials_; ++i) {
      const double x = argument();
      ASSERT_LT(error_of(function(x), exact(static_cast<long double>(x))), most) << std::hexfloat << x;
    }
  }

  SeededRandom random_{test::first_seed() + 11};
  int trials_ = test::num_trials({2000, 50'000, 2'000'000});
};

TEST_F(ElementaryAccuracy, OfSineAndCosineIsThatOfTheirRounding) {
  const auto exact_sine = [](long double x) { return std::sin(x); };
  const auto exact_cosine = [](long double x) { return std::cos(x); };
  for (const double range : {0.8, 7.0, 1e6, 1e18}) {
    const auto argument = [&] { return random_.uniform(-range, range); };
    expect_error_below(0.6, sine, exact_sine, argument);
    expect_error_below(0.6, cosine, exact_cosine, argument);
  }
  expect_error_below(0.6, sine, exact_sine, [&] { return any(); });
  expect_error_below(0.6, cosine, exact_cosine, [&] { return any(); });
  const auto near_quarter_turns = [&] {
    return 0.5 * std::numbers::pi * std::floor(random_.uniform(-1e6, 1e6)) * (1.0 + 1e-15 * random_.uniform());
  };
  expect_error_below(0.6, sine, exact_sine, near_quarter_turns);
  expect_error_below(0.6, cosine, exact_cosine, near_quarter_turns);
}

TEST_F(ElementaryAccuracy, OfArcsIsThatOfTheirRounding) {
  const auto exact_arc = [](long double x) { return std::acos(x); };
  expect_error_below(0.6, arc_cosine, exact_arc, [&] { return random_.uniform(-1.0, 1.0); });
  expect_error_below(0.6, arc_cosine, exact_arc, [&] { return 1.0 - 1e-12 * random_.uniform(); });
  expect_error_below(0.6, arc_cosine, exact_arc, [&] { return 1e-12 * random_.uniform() - 1.0; });
  for (int i = 0; i < trials_; ++i) {
    for (const auto& [y, x] : {std::pair{random_.uniform(-1.0, 1.0), random_.uniform(-1.0, 1.0)},
                               std::pair{scaled(), -scaled()}, std::pair{any(), any()}}) {
      const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
      ASSERT_LT(error_of(arc_tangent(y, x), exact), 0.6) << std::hexfloat << y << " " << x;
    }
  }
}

TEST_F(ElementaryAccuracy, OfExponentialsAndLogarithmsIsThatOfTheirRounding) {
  const auto exact_exponential = [](long double x) { return std::exp(x); };
  const auto exact_logarithm = [](long double x) { return std::log(x); };
  expect_error_below(0.6, exponential, exact_exponential, [&] { return random_.uniform(-1.0, 1.0); });
  expect_error_below(0.6, exponential, exact_exponential, [&] { return random_.uniform(-708.0, 710.0); });
  expect_error_below(1.0, exponential, exact_exponential, [&] { return random_.uniform(-750.0, -700.0); });
  expect_error_below(0.6, exponential, exact_exponential, [&] { return any(); });
  expect_error_below(0.6, logarithm, exact_logarithm, [&] { return random_.uniform(0.5, 2.0); });
  expect_error_below(0.6, logarithm, exact_logarithm, [&] { return 1.0 + 1e-6 * random_.uniform(-1.0, 1.0); });
  expect_error_below(0.6, logarithm, exact_logarithm, [&] { return any(); });
  const auto exact_decimal = [](long double x) { return std::log10(x); };
  expect_error_below(0.6, decimal_logarithm, exact_decimal, [&] { return any(); });
  expect_error_below(0.6, decimal_logarithm, exact_decimal, [&] { return scaled(); });
}

TEST_F(ElementaryAccuracy, OfPowersIsBelowThreeQuarters) {
  for (int i = 0; i < trials_; ++i) {
    for (const auto& [x, y] : {std::pair{scaled(), random_.uniform(-16.0, 16.0)}, std::pair{scaled(), 0.5},
                               std::pair{-scaled(), std::floor(random_.uniform(-9.0, 9.0))},
                               std::pair{1.0 + 1e-9 * random_.uniform(), random_.uniform(-1e11, 1e11)}}) {
      const long double exact = std::pow(static_cast<long double>(x), static_cast<long double>(y));
      ASSERT_LT(error_of(power(x, y), exact), 0.75) << std::hexfloat << x << " " << y;
    }
  }
}

// Compares bits, but takes each NaN as equal to each other.
void expect_equal(double result, double expected, double x, double y = 0.0) {
  if (std::isnan(expected)) {
    EXPECT_TRUE(std::isnan(result)) << x << " " << y;
  } else {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(result), std::bit_cast<std::uint64_t>(expected)) << x << " " << y;
  }
}

// The C library has its special values from the C standard, as have these.
TEST(Elementary, HasTheSpecialValuesOfTheStandard) {
  constexpr std::array kSpecial{0.0,       1.0,    2.0,     0.5,       3.0,         1e300,  1e-300,
                                0x1p-1074, 0x1p60, 0x1p-60, kInfinite, kNotANumber, 0x1p-28};
  for (const double size : kSpecial) {
    for (const double x : {size, -size}) {
      expect_equal(sine(x), std::sin(x), x);
      expect_equal(cosine(x), std::cos(x), x);
      expect_equal(arc_cosine(x), std::acos(x), x);
      expect_equal(exponential(x), std::exp(x), x);
      expect_equal(logarithm(x), std::log(x), x);
      expect_equal(decimal_logarithm(x), std::log10(x), x);
      for (const double other : kSpecial) {
        for (const double y : {other, -other}) {
          expect_equal(arc_tangent(x, y), std::atan2(x, y), x, y);
          expect_equal(power(x, y), std::pow(x, y), x, y);
        }
      }
    }
  }
}

TEST(Elementary, IsSymmetricToTheLastBit) {
  SeededRandom random(3);
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-100.0, 100.0);
    const double y = random.uniform(-100.0, 100.0);
    EXPECT_EQ(sine(-x), -sine(x));
    EXPECT_EQ(cosine(-x), cosine(x));
    EXPECT_EQ(arc_tangent(-y, x), -arc_tangent(y, x));
    EXPECT_EQ(arc_tangent(y, 0x1p300 * x), arc_tangent(0x1p-300 * y, x));
    EXPECT_EQ(arc_tangent(x, x), x > 0.0 ? 0.25 * std::numbers::pi : -0.75 * std::numbers::pi);
  }
}

// The results of 8,000 calls, whose bits are those of every processor.
TEST(Elementary, HasTheBitsThatAreWrittenDown) {
  SeededRandom random(5);
  StateHash hash;
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(-20.0, 20.0);
    const double y = random.uniform(-2.0, 2.0);
    for (const double result : {sine(x), cosine(x), arc_tangent(y, x), arc_cosine(0.5 * y), exponential(x)})
      hash.add(result);
    for (const double result : {logarithm(x * x), decimal_logarithm(x * x), power(x * x, y)}) hash.add(result);
  }
  EXPECT_EQ(hash.value(), 0xbf167ad6640e5db3U);
}

}  // namespace
}  // namespace kerf
