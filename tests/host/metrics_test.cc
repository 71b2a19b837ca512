#include "server/service/host/metrics.h"

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

TEST(Metrics, HistogramPutsBoundsIntoTheirOwnClass) {
  DurationHistogram histogram;
  histogram.add(0.0);
  histogram.add(1.0e-5);
  histogram.add(1.1e-5);
  histogram.add(2.0);
  EXPECT_EQ(histogram.counts.front(), 2U);
  EXPECT_EQ(histogram.counts[1], 1U);
  EXPECT_EQ(histogram.counts.back(), 1U);
  EXPECT_EQ(histogram.total, 4U);
  EXPECT_NEAR(histogram.sum, 2.000021, 1e-12);
}

}  // namespace
}  // namespace kerf::host
