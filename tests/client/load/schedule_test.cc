#include "client/load/schedule.h"

#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "client/load/histogram.h"
#include "client/load/recorder.h"

namespace kerf::load {
namespace {

using namespace std::chrono_literals;

// Simulates time that passes only when waited for or spent.
class FakeTime : public Waiter {
 public:
  [[nodiscard]] Nanoseconds now() const override { return now_; }
  bool wait_until(Nanoseconds time) override {
    if (time >= over_at_) return false;
    now_ = std::max(now_, time);
    return true;
  }
  void spend(Nanoseconds time) { now_ += time; }
  void end_at(Nanoseconds time) { over_at_ = time; }

 private:
  Nanoseconds now_{0};
  Nanoseconds over_at_{Nanoseconds::max()};
};

// 100 arrivals a second for 10 s, at a server that answers in 1 ms except during one second in the middle.
constexpr Schedule kHundredHz{Nanoseconds(0), 10ms};
constexpr Nanoseconds kStallBegin = 5s;
constexpr Nanoseconds kStallEnd = 6s;

TEST(Schedule, ArrivesAtEachTimeOnceAndNoneAtTheEnd) {
  FakeTime time;
  std::vector<std::int64_t> at_ms;
  const std::int64_t count = run_schedule(kHundredHz, 50ms, time, [&](std::int64_t k, Nanoseconds intended) {
    EXPECT_EQ(intended, k * 10ms);
    EXPECT_EQ(time.now(), intended);
    at_ms.push_back(microseconds(intended) / 1000);
  });
  EXPECT_EQ(count, 5);
  EXPECT_EQ(at_ms, (std::vector<std::int64_t>{0, 10, 20, 30, 40}));
}

TEST(Schedule, EndsWhenTheWaiterSaysSo) {
  FakeTime time;
  time.end_at(25ms);
  EXPECT_EQ(run_schedule(kHundredHz, 1s, time, [](auto, auto) {}), 3);
}

TEST(Schedule, AStalledServerShowsInEveryArrivalOfTheStall) {
  FakeTime time;
  Histogram latency_us;
  const std::int64_t count = run_schedule(kHundredHz, 10s, time, [&](std::int64_t /*k*/, Nanoseconds intended) {
    const bool stalled = intended >= kStallBegin && intended < kStallEnd;
    const Nanoseconds answered = (stalled ? kStallEnd : intended) + 1ms;
    latency_us.add(microseconds(answered - intended));
  });
  EXPECT_EQ(count, 1'000);
  EXPECT_EQ(latency_us.count_above(2'000), 100);
  EXPECT_LE(latency_us.quantile(0.5), 1'008);
  EXPECT_GE(latency_us.quantile(0.99), 900'000);
  EXPECT_EQ(latency_us.max(), 1'001'000);
}

// A sender that waits for each answer would note the stall once (a closed loop): here what it is late by is in every
// arrival that it delays, and none is left out.
TEST(Schedule, ASenderThatIsHeldUpCatchesUpAndItsDelayCounts) {
  FakeTime time;
  Histogram latency_us;
  const std::int64_t count = run_schedule(kHundredHz, 10s, time, [&](std::int64_t k, Nanoseconds intended) {
    time.spend(k == 500 ? 1s : 1ms);
    latency_us.add(microseconds(time.now() - intended));
  });
  EXPECT_EQ(count, 1'000);
  EXPECT_EQ(latency_us.max(), 1'000'000);
  // After the stall it makes up 9 ms with each arrival: 110 later ones are late by more than their own millisecond.
  EXPECT_EQ(latency_us.count_above(1'100), 111);
  EXPECT_GE(latency_us.quantile(0.99), 900'000);
}

TEST(Schedule, RealTimeComesAndEnds) {
  Stopper stopper;
  const Nanoseconds begin = now();
  EXPECT_TRUE(stopper.wait_until(begin - 1s));
  EXPECT_TRUE(stopper.wait_until(begin + 2ms));
  EXPECT_GE(now(), begin + 2ms);
  std::thread other([&] { stopper.stop(); });
  EXPECT_FALSE(stopper.wait_until(begin + 1h));
  other.join();
  EXPECT_TRUE(stopper.stopped());
  EXPECT_FALSE(stopper.wait_until(begin - 1s));
}

// Shown frames grow older from frame to frame: at 0, 10, 20 ... a frame 3 ms old, and one that stays for a second.
TEST(ShownAge, AFrameThatStaysCountsAtEveryTime) {
  ShownAge shown(kHundredHz);
  Histogram age_us;
  const auto sample = [&](Nanoseconds /*time*/, std::int64_t us) { age_us.add(us); };
  for (int k = 0; k <= 100; ++k) shown.frame(k * 10ms + 1ms, 3ms, true, sample);  // each 1 ms after a time
  EXPECT_EQ(age_us.count(), 100);                                                 // nothing was shown at the first
  EXPECT_EQ(age_us.min(), 12'000);
  EXPECT_EQ(age_us.quantile(1.0), 12'000);
  shown.frame(2s + 1ms, 3ms, true, sample);
  EXPECT_EQ(age_us.count(), 200);
  EXPECT_EQ(age_us.max(), 1'002'000);
  EXPECT_EQ(age_us.count_above(500'000), 51);  // 502 ms .. 1002 ms, less the width of a class
}

TEST(ShownAge, AFrameThatNoneFollowsCountsUntilTheEnd) {
  ShownAge shown(kHundredHz);
  Histogram age_us;
  const auto sample = [&](Nanoseconds /*time*/, std::int64_t us) { age_us.add(us); };
  shown.frame(1ms, 3ms, true, sample);
  shown.finish(1s, sample);
  EXPECT_EQ(age_us.count(), 100);
  EXPECT_EQ(age_us.max(), 1'002'000);
  shown.finish(2s, sample);
  EXPECT_EQ(age_us.count(), 100) << "nobody looks any more";
}

// Readers are there before it is known from when they count.
TEST(Recorder, CountsNothingBeforeItMeasures) {
  Recorder recorder;
  EXPECT_FALSE(recorder.counts(1s));
  recorder.frame(Role::kViewer, {1s, 5, 100, 0, false});
  recorder.measure(2s, 3s);
  EXPECT_FALSE(recorder.counts(1s));
  EXPECT_TRUE(recorder.counts(2s));
  EXPECT_FALSE(recorder.counts(3s));
  recorder.frame(Role::kViewer, {2s, 5, 100, 0, false});
  EXPECT_EQ(recorder.readers(Role::kViewer).frames, 1);
}

TEST(ShownAge, OfASheetThatSleepsNothingGrowsOld) {
  ShownAge shown(kHundredHz);
  Histogram age_us;
  const auto sample = [&](Nanoseconds /*time*/, std::int64_t us) { age_us.add(us); };
  shown.frame(1ms, 0ms, false, sample);
  shown.frame(10s, 0ms, true, sample);
  EXPECT_EQ(age_us.count(), 0);
  shown.frame(10s + 15ms, 0ms, true, sample);
  EXPECT_EQ(age_us.count(), 1);  // at 10.01 s; the one at 10 s was counted with the frame before
}

}  // namespace
}  // namespace kerf::load
