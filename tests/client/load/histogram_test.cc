#include "client/load/histogram.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"

namespace kerf::load {
namespace {

// The least value that at least the share `q` of the sorted ones does not exceed.
std::int64_t exact_quantile(const std::vector<std::int64_t>& sorted, double q) {
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram histogram;
  for (int value = 255; value >= 0; --value) histogram.add(value);
  EXPECT_EQ(histogram.count(), 256);
  EXPECT_EQ(histogram.quantile(0.0), 0);
  EXPECT_EQ(histogram.quantile(0.5), 127);
  EXPECT_EQ(histogram.quantile(1.0), 255);
  EXPECT_EQ(histogram.count_above(127), 128);
  EXPECT_DOUBLE_EQ(histogram.mean(), 127.5);
}

TEST(Histogram, EmptyIsAllZero) {
  const Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.99), 0);
  EXPECT_EQ(histogram.max(), 0);
  EXPECT_EQ(histogram.mean(), 0.0);
}

// The promise: never below the true quantile, and above it by 1/128 at the most.
TEST(Histogram, QuantilesAreWithinOnePartIn128AtAnyScale) {
  SeededRandom random(7);
  for (int trial = 0; trial < 60; ++trial) {
    const double widest = random.uniform(1.0, 60.0);  // binary digits
    std::vector<std::int64_t> values(1 + random.below(2'000));
    Histogram histogram;
    for (std::int64_t& value : values) {
      value = static_cast<std::int64_t>(std::exp2(random.uniform(0.0, widest)));
      histogram.add(value);
    }
    std::sort(values.begin(), values.end());
    EXPECT_EQ(histogram.min(), values.front());
    EXPECT_EQ(histogram.max(), values.back());
    for (const double q : {0.0, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      const std::int64_t exact = exact_quantile(values, q);
      const std::int64_t found = histogram.quantile(q);
      ASSERT_GE(found, exact) << "trial " << trial << ", q " << q;
      ASSERT_LE(found - exact, exact / 128) << "trial " << trial << ", q " << q;
    }
  }
}

TEST(Histogram, TakesTheLargestValueAndNegativeOnes) {
  Histogram histogram;
  histogram.add(INT64_MAX);
  histogram.add(-5);
  EXPECT_EQ(histogram.max(), INT64_MAX);
  EXPECT_EQ(histogram.quantile(1.0), INT64_MAX);
  EXPECT_EQ(histogram.min(), 0);
}

TEST(Histogram, MergedIsAsIfAddedToOne) {
  SeededRandom random(11);
  Histogram all;
  Histogram parts[2];
  for (int i = 0; i < 5'000; ++i) {
    const auto value = static_cast<std::int64_t>(random.below(std::uint64_t{1} << (1 + i % 40)));
    all.add(value, 1 + i % 3);
    parts[i % 2].add(value, 1 + i % 3);
  }
  parts[0].merge(parts[1]);
  parts[0].merge(Histogram());
  EXPECT_EQ(parts[0].count(), all.count());
  EXPECT_EQ(parts[0].min(), all.min());
  EXPECT_EQ(parts[0].max(), all.max());
  EXPECT_NEAR(parts[0].mean(), all.mean(), 1e-9 * all.mean());
  for (int i = 0; i <= 1'000; ++i) ASSERT_EQ(parts[0].quantile(i / 1000.0), all.quantile(i / 1000.0)) << i;
}

}  // namespace
}  // namespace kerf::load
