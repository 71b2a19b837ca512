#pragma once

#include <cmath>

namespace kerf {

// A number as the sum of two doubles, |low| at most half a unit in the last place of `high`: 106 bits. The operations
// are those of Dekker ("A floating-point technique for extending the available precision", 1971) and Knuth.
struct DoubleDouble {
  double high = 0.0;
  double low = 0.0;

  [[nodiscard]] DoubleDouble operator-() const { return {-high, -low}; }
  [[nodiscard]] double rounded() const { return high + low; }
};

// Returns a + b without error, for |a| >= |b| or a = 0.
inline DoubleDouble quick_sum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

// Returns a + b without error.
inline DoubleDouble exact_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

// Returns a b without error, unless a factor is beyond 2^996 or the product near the subnormal numbers.
inline DoubleDouble exact_product(double a, double b) {
  const auto upper_half = [](double value) {
    const double scaled = 0x8000001p0 * value;  // 2^27 + 1
    return scaled - (scaled - value);
  };
  const double a_high = upper_half(a);
  const double b_high = upper_half(b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

// The operations below have relative errors of some 2^-104; sums of numbers of different sign have that relative to the
// larger one.
inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble sum = exact_sum(a.high, b.high);
  const DoubleDouble rest = exact_sum(a.low, b.low);
  const DoubleDouble partial = quick_sum(sum.high, sum.low + rest.high);
  return quick_sum(partial.high, partial.low + rest.low);
}

inline DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) {
  return a + -b;
}

inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const DoubleDouble product = exact_product(a.high, b.high);
  return quick_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

inline DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
  const double quotient = a.high / b.high;
  const DoubleDouble product = exact_product(quotient, b.high);
  const double rest = ((a.high - product.high) - product.low + a.low) - quotient * b.low;
  return quick_sum(quotient, rest / b.high);
}

inline DoubleDouble square_root(const DoubleDouble& a) {
  if (a.high == 0.0) return {};
  const double root = std::sqrt(a.high);
  const DoubleDouble square = exact_product(root, root);
  return quick_sum(root, ((a.high - square.high) - square.low + a.low) / (2.0 * root));
}

}  // namespace kerf
