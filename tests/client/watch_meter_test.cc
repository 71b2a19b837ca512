#include "client/cli/watch_meter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kerf::cli {
namespace {

using testing::HasSubstr;

// Frames of 1000 bytes at `rate_hz` from `start_s` on, ages 1, 2, 3, ... ms.
void add_frames(int count, double start_s, double rate_hz, WatchMeter& meter) {
  for (int i = 0; i < count; ++i) {
    meter.add({start_s + i / rate_hz, 100 + i, 1000, 1.0 + i, i == 0 ? 0 : 2, 400, 3, 0.5});
  }
}

TEST(WatchMeter, NothingBeforeTheFirstFrame) {
  const WatchMeter meter;
  EXPECT_EQ(meter.status(), "waiting for the first frame");
  EXPECT_EQ(meter.summary(), "no frames");
}

TEST(WatchMeter, RatesAndAgesAreThoseOfTheLastTwoSeconds) {
  WatchMeter meter;
  add_frames(640, 0.0, 64.0, meter);  // ten seconds; then slower
  EXPECT_THAT(meter.status(), HasSubstr("64.0 fps  64.0 kB/s  age p50 576.0 p95 634.0 ms"));
  add_frames(17, 20.0, 8.0, meter);
  EXPECT_THAT(meter.status(), HasSubstr("tick 116  8.0 fps  8.0 kB/s  age p50 9.0 p95 16.0 ms"));
  EXPECT_THAT(meter.status(), HasSubstr("400 vertices 3 pieces  x0.50 real time"));
}

TEST(WatchMeter, OneFrameHasNoRate) {
  WatchMeter meter;
  add_frames(1, 5.0, 1.0, meter);
  EXPECT_THAT(meter.status(), HasSubstr("0.0 fps  0 B/s"));
  EXPECT_THAT(meter.summary(), HasSubstr("1 frame in 0.0 s (0.0 fps), 1.0 kB (1.0 kB a frame)"));
}

TEST(WatchMeter, TheSummaryIsOfAllFrames) {
  WatchMeter meter;
  add_frames(101, 0.0, 10.0, meter);
  EXPECT_EQ(meter.frames(), 101);
  EXPECT_EQ(meter.summary(),
            "101 frames in 10.0 s (10.0 fps), 101.0 kB (1.0 kB a frame), 200 ticks skipped\n"
            "age of frames: p50 51.0 ms, p95 96.0 ms, worst 101.0 ms");
}

TEST(WatchMeter, AgesAreKeptOfTheLastFramesOnly) {
  WatchMeter meter;
  add_frames(4096, 0.0, 1000.0, meter);
  for (int i = 0; i < 4096; ++i) meter.add({10.0 + i * 0.001, i, 10, 7.0, 0, 4, 1, 1.0});
  EXPECT_THAT(meter.summary(), HasSubstr("p50 7.0 ms, p95 7.0 ms, worst 7.0 ms"));
}

}  // namespace
}  // namespace kerf::cli
