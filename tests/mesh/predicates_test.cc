// Exact predicates against schoolbook integers of any length.

#include "server/core/mesh/predicates.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/lattice.h"

namespace kerf::mesh {
namespace {

// Sign and magnitude, base 2^32: slow and plain, and shares no code with what it checks.
class BigInteger {
 public:
  BigInteger(std::int64_t value) : is_negative_(value < 0) {  // NOLINT(google-explicit-constructor)
    auto magnitude = static_cast<std::uint64_t>(value);
    if (is_negative_) magnitude = ~magnitude + 1;
    for (; magnitude != 0; magnitude >>= 32) digits_.push_back(static_cast<std::uint32_t>(magnitude));
  }
  friend BigInteger operator*(const BigInteger& a, const BigInteger& b) {
    BigInteger product(0);
    product.is_negative_ = a.is_negative_ != b.is_negative_;
    product.digits_.assign(a.digits_.size() + b.digits_.size(), 0);
    for (std::size_t i = 0; i < a.digits_.size(); ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < b.digits_.size() || carry != 0; ++j) {
        const std::uint64_t factor = j < b.digits_.size() ? b.digits_[j] : 0;
        carry += product.digits_[i + j] + a.digits_[i] * factor;
        product.digits_[i + j] = static_cast<std::uint32_t>(carry);
        carry >>= 32;
      }
    }
    product.trim();
    return product;
  }
  friend BigInteger operator+(const BigInteger& a, const BigInteger& b) {
    BigInteger sum(0);
    if (a.is_negative_ == b.is_negative_) {
      sum.is_negative_ = a.is_negative_;
      std::uint64_t carry = 0;
      for (std::size_t i = 0; i < std::max(a.digits_.size(), b.digits_.size()) || carry != 0; ++i) {
        carry += (i < a.digits_.size() ? a.digits_[i] : 0ULL) + (i < b.digits_.size() ? b.digits_[i] : 0ULL);
        sum.digits_.push_back(static_cast<std::uint32_t>(carry));
        carry >>= 32;
      }
      return sum;
    }
    const bool a_is_larger = compare_magnitudes(a, b) >= 0;
    const BigInteger& large = a_is_larger ? a : b;
    const BigInteger& small = a_is_larger ? b : a;
    sum.is_negative_ = large.is_negative_;
    std::int64_t borrow = 0;
    for (std::size_t i = 0; i < large.digits_.size(); ++i) {
      std::int64_t digit = static_cast<std::int64_t>(large.digits_[i]) - borrow;
      digit -= i < small.digits_.size() ? static_cast<std::int64_t>(small.digits_[i]) : 0;
      borrow = digit < 0 ? 1 : 0;
      sum.digits_.push_back(static_cast<std::uint32_t>(digit + (borrow << 32)));
    }
    sum.trim();
    return sum;
  }
  friend BigInteger operator-(const BigInteger& a, BigInteger b) {
    b.is_negative_ = !b.is_negative_;
    return a + b;
  }
  [[nodiscard]] int sign() const { return digits_.empty() ? 0 : (is_negative_ ? -1 : 1); }

 private:
  static int compare_magnitudes(const BigInteger& a, const BigInteger& b) {
    if (a.digits_.size() != b.digits_.size()) return a.digits_.size() < b.digits_.size() ? -1 : 1;
    for (std::size_t i = a.digits_.size(); i-- > 0;) {
      if (a.digits_[i] != b.digits_[i]) return a.digits_[i] < b.digits_[i] ? -1 : 1;
    }
    return 0;
  }
  void trim() {
    while (!digits_.empty() && digits_.back() == 0) digits_.pop_back();
  }
  std::vector<std::uint32_t> digits_;
  bool is_negative_ = false;
};

BigInteger area(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c) {
  return BigInteger(a.x) * b.y - BigInteger(b.x) * a.y + BigInteger(b.x) * c.y - BigInteger(c.x) * b.y +
         BigInteger(c.x) * a.y - BigInteger(a.x) * c.y;
}

BigInteger lift(const LatticePoint& p) {
  return BigInteger(p.x) * p.x + BigInteger(p.y) * p.y;
}

// The 4 x 4 determinant with rows (x, y, x^2 + y^2, 1), expanded along the third column: no differences taken first.
int in_circle_by_definition(const LatticePoint& a, const LatticePoint& b, const LatticePoint& c,
                            const LatticePoint& d) {
  return (lift(a) * area(b, c, d) - lift(b) * area(a, c, d) + lift(c) * area(a, b, d) - lift(d) * area(a, b, c)).sign();
}

LatticePoint random_point(SeededRandom& random, std::int64_t reach) {
  const auto coordinate = [&] {
    return static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(2 * reach + 1))) - reach;
  };
  const std::int64_t x = coordinate();
  return {x, coordinate()};
}

std::int64_t nudge(SeededRandom& random) {
  return static_cast<std::int64_t>(random.below(3)) - 1;
}

// A point as near as the lattice allows to a random place on line ab.
LatticePoint nearly_on(SeededRandom& random, const LatticePoint& a, const LatticePoint& b) {
  const double t = random.uniform(0.0, 1.0);
  return {a.x + static_cast<std::int64_t>(t * static_cast<double>(b.x - a.x)) + nudge(random),
          a.y + static_cast<std::int64_t>(t * static_cast<double>(b.y - a.y)) + nudge(random)};
}

TEST(Predicates, OrientationMatchesLongIntegersNearLines) {
  SeededRandom random(1);
  int num_zero = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t reach = i % 2 == 0 ? kMaxCoordinate - 1 : 6;
    const LatticePoint a = random_point(random, reach);
    const LatticePoint b = random_point(random, reach);
    const LatticePoint c = nearly_on(random, a, b);
    const int expected = area(a, b, c).sign();
    ASSERT_EQ(orient2d(a, b, c), expected);
    ASSERT_EQ(orient2d(b, a, c), -expected);
    num_zero += expected == 0;
  }
  EXPECT_GT(num_zero, 1000);
}

TEST(Predicates, DoublesOfLongIntegersAreThoseOfACast) {
  SeededRandom random(11);
  const auto check = [](Int128 value) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(to_double(value)), std::bit_cast<std::uint64_t>(static_cast<double>(value)));
    EXPECT_EQ(std::bit_cast<std::uint64_t>(to_double(-value)),
              std::bit_cast<std::uint64_t>(static_cast<double>(-value)));
  };
  for (int bits = 0; bits < 126; ++bits) {
    const Int128 power = Int128{1} << bits;
    for (int low = 0; low < bits; ++low) {  // ties, and what is just beside them
      for (const int off : {-1, 0, 1}) check(power + (Int128{1} << low) + off);
    }
    for (int i = 0; i < 200; ++i) {
      const auto high = static_cast<Int128>(random.below(std::uint64_t{1} << 62));
      check(((high << 62) | static_cast<Int128>(random.below(std::uint64_t{1} << 62))) % power);
    }
  }
  check(0);
}

TEST(Predicates, OrientationIsPositiveCounterClockwise) {
  EXPECT_EQ(orient2d({0, 0}, {1, 0}, {0, 1}), 1);
  EXPECT_EQ(orient2d({0, 0}, {0, 1}, {1, 0}), -1);
  constexpr std::int64_t m = kMaxCoordinate;
  EXPECT_EQ(orient2d({-m, -m}, {m, m}, {m - 1, m}), 1);
  EXPECT_EQ(orient2d({-m, -m}, {m, m}, {0, 0}), 0);
}

// Eight points at one distance from a centre, moved by at most one unit: the filter can say nothing about most of them.
TEST(Predicates, InCircleMatchesLongIntegersNearCircles) {
  SeededRandom random(2);
  int num_zero = 0, num_tested = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t reach = i % 2 == 0 ? kMaxCoordinate / 4 : 20;
    const LatticePoint centre = random_point(random, reach);
    const LatticePoint arm = random_point(random, reach);
    const auto on_circle = [&] {
      std::int64_t x = arm.x, y = arm.y;
      const std::uint64_t which = random.below(8);
      if ((which & 1) != 0) std::swap(x, y);
      LatticePoint p{centre.x + ((which & 2) != 0 ? x : -x), centre.y + ((which & 4) != 0 ? y : -y)};
      if (random.below(2) == 0) p.x += nudge(random);
      return p;
    };
    LatticePoint a = on_circle(), b = on_circle();
    const LatticePoint c = on_circle(), d = on_circle();
    if (orient2d(a, b, c) == 0) continue;
    if (orient2d(a, b, c) < 0) std::swap(a, b);
    const int expected = in_circle_by_definition(a, b, c, d);
    ASSERT_EQ(in_circle(a, b, c, d), expected);
    ASSERT_EQ(in_circle_exact(a, b, c, d), expected);
    ASSERT_EQ(in_circle(b, c, a, d), expected);
    num_zero += expected == 0;
    ++num_tested;
  }
  EXPECT_GT(num_tested, 10000);
  EXPECT_GT(num_zero, 1000);
}

TEST(Predicates, InCircleHoldsAtTheCornersOfTheDomain) {
  constexpr std::int64_t m = kMaxCoordinate;
  EXPECT_EQ(in_circle({-m, -m}, {m, -m}, {m, m}, {-m, m}), 0);
  EXPECT_EQ(in_circle({-m, -m}, {m, -m}, {m, m}, {-m + 1, m}), 1);
  EXPECT_EQ(in_circle({-m, -m + 1}, {m, -m + 1}, {m, m - 1}, {-m, m}), -1);
}

TEST(Predicates, SegmentsCrossOnlyInTheirInterior) {
  EXPECT_TRUE(segments_cross({0, 0}, {4, 4}, {0, 4}, {4, 0}));
  EXPECT_FALSE(segments_cross({0, 0}, {4, 4}, {2, 2}, {4, 0}));  // touches
  EXPECT_FALSE(segments_cross({0, 0}, {4, 4}, {1, 1}, {3, 3}));  // overlaps
  EXPECT_FALSE(segments_cross({0, 0}, {1, 1}, {0, 4}, {4, 0}));
}

// |2 (v n - q d)| <= d for each coordinate: q is the nearest integer to v n / d.
TEST(Predicates, CrossingIsRoundedToTheNearestLatticePoint) {
  SeededRandom random(4);
  int num_tested = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::int64_t reach = i % 2 == 0 ? kMaxCoordinate / 2 : 30;
    const LatticePoint a = random_point(random, reach), b = random_point(random, reach);
    const LatticePoint c = random_point(random, reach), d = random_point(random, reach);
    if (!segments_cross(a, b, c, d)) continue;
    ++num_tested;
    const LatticePoint p = rounded_crossing(a, b, c, d);
    BigInteger numerator = area(c, d, a);
    BigInteger denominator = numerator - area(c, d, b);
    if (denominator.sign() < 0) numerator = BigInteger(0) - numerator, denominator = BigInteger(0) - denominator;
    for (const auto& [value, share] : {std::pair{b.x - a.x, p.x - a.x}, std::pair{b.y - a.y, p.y - a.y}}) {
      const BigInteger remainder = BigInteger(2) * (BigInteger(value) * numerator - BigInteger(share) * denominator);
      ASSERT_LE((remainder - denominator).sign(), 0);
      ASSERT_GE((remainder + denominator).sign(), 0);
    }
  }
  EXPECT_GT(num_tested, 2000);
  EXPECT_EQ(rounded_projection({0, 0}, {10, 0}, {4, 7}), (LatticePoint{4, 0}));
  EXPECT_EQ(rounded_projection({0, 0}, {10, 0}, {-4, 7}), (LatticePoint{0, 0}));
  EXPECT_EQ(rounded_projection({0, 0}, {10, 10}, {4, 0}), (LatticePoint{2, 2}));
}

TEST(Lattice, IsFineCentredAndReversible) {
  for (const double size : {1e-6, 0.3, 1.0, 1.5, 20000.0}) {
    for (const double shift : {0.0, -0.7, 3.0}) {
      const Eigen::AlignedBox2d box(Eigen::Vector2d(shift * size, 0.0),
                                    Eigen::Vector2d((shift + 1.0) * size, 0.2 * size));
      const Lattice lattice = Lattice::for_bounds(box);
      EXPECT_LT(lattice.spacing, size * 0x1.0p-50);
      for (const Eigen::Vector2d& corner : {box.min(), box.max()}) {
        ASSERT_TRUE(lattice.contains(corner));
        const LatticePoint p = lattice.nearest(corner);
        EXPECT_LE(std::abs(p.x), kMaxCoordinate / 2);
        EXPECT_LE((lattice.position(p) - corner).cwiseAbs().maxCoeff(), 0.5 * lattice.spacing + 1e-15 * corner.norm());
        if (lattice.origin.cwiseAbs().maxCoeff() > 2.0 * size) continue;
        EXPECT_EQ(lattice.nearest(lattice.position(p)), p);
      }
      EXPECT_FALSE(lattice.contains(box.max() + Eigen::Vector2d(4.0 * size, 0.0)));
      EXPECT_TRUE(lattice.contains(box.max() + Eigen::Vector2d(0.99 * size, 0.99 * size)));
    }
  }
}

TEST(Lattice, KeepsDyadicPositionsExactly) {
  const Lattice lattice = Lattice::for_bounds(Eigen::AlignedBox2d(Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 1)));
  EXPECT_EQ(lattice.origin, Eigen::Vector2d::Zero());
  const Eigen::Vector2d position(0.375, 0.0009765625);
  EXPECT_EQ(lattice.position(lattice.nearest(position)), position);
}

}  // namespace
}  // namespace kerf::mesh
