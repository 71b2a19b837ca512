// Values that are measured for the frames of a stream: which frames have them, and what they cost.

#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/sheet/sheet.h"
#include "server/service/stream/channel.h"
#include "tests/stream/subscribing.h"
#include "tests/support/scenes.h"

namespace kerf::stream {
namespace {

// Returns the tick, and the number of measurements so far.
class CountingMeter : public Meter {
 public:
  explicit CountingMeter(Nanoseconds* clock = nullptr, Nanoseconds takes = 0ns) : clock_(clock), takes_(takes) {}
  std::vector<double> measure(const sheet::Sheet& sheet, std::uint64_t /*serial*/) override {
    if (clock_ != nullptr) *clock_ += takes_;
    return {static_cast<double>(sheet.tick()), static_cast<double>(++count)};
  }
  [[nodiscard]] const std::vector<std::string>& columns() const override { return columns_; }

  int count = 0;

 private:
  Nanoseconds* const clock_;
  const Nanoseconds takes_;
  const std::vector<std::string> columns_{"tick", "count"};
};

class MeasuringTest : public ::testing::Test {
 protected:
  void step() {
    sheet_.step({});
    publish();
  }
  // As the host does after a tick, or if a sink is to be refreshed.
  void publish() {
    const std::shared_ptr<sheet::Snapshot> snapshot = sheet_.snapshot(stats_);
    channel_->measure(sheet_, *snapshot);
    channel_->publish(snapshot);
  }
  std::shared_ptr<Subscriber> watch(const std::shared_ptr<CountingMeter>& meter, std::int32_t window = 1) {
    SubscriberOptions options;
    options.flow.window = window;
    options.meter = meter;
    return subscribe(*channel_, options);
  }

  Nanoseconds now_{0};
  std::shared_ptr<Channel> channel_ = std::make_shared<Channel>(8, "instance", nullptr, [this] { return now_; });
  sheet::Sheet sheet_ = sheet::Sheet::create(scenes::hanging(4)).value();
  sheet::RunStats stats_;
};

TEST_F(MeasuringTest, AFrameHasTheValuesOfItsTickAndTheFirstOneTheirNames) {
  const auto meter = std::make_shared<CountingMeter>();
  const auto viewer = watch(meter);
  const auto other = subscribe(*channel_);
  step();
  const v1::Frame first = frame(*viewer);
  EXPECT_EQ(first.tick(), 1);
  EXPECT_EQ(std::vector<double>(first.probe_values().begin(), first.probe_values().end()),
            (std::vector<double>{1.0, 1.0}));
  EXPECT_EQ(std::vector<std::string>(first.probe_columns().begin(), first.probe_columns().end()), meter->columns());
  EXPECT_EQ(frame(*other).probe_values_size(), 0);
  ASSERT_TRUE(viewer->acknowledge(1).ok());
  viewer->next(0ns);
  step();
  const v1::Frame second = frame(*viewer);
  ASSERT_EQ(second.probe_values_size(), 2);
  EXPECT_EQ(second.probe_values(0), 2.0);
  EXPECT_EQ(second.probe_columns_size(), 0);
}

TEST_F(MeasuringTest, SkippedFramesCostNothing) {
  const auto meter = std::make_shared<CountingMeter>();
  const auto viewer = watch(meter);
  step();
  frame(*viewer);
  for (int tick = 0; tick < 10; ++tick) step();
  EXPECT_EQ(meter->count, 1) << "the window was full";
  ASSERT_TRUE(viewer->acknowledge(1).ok());
  const Subscriber::Next next = viewer->next(0ns);
  EXPECT_FALSE(next.message) << "the newest snapshot was not measured";
  EXPECT_FALSE(next.wants_snapshot) << "a tick will bring another";
  step();
  const v1::Frame late = frame(*viewer);
  EXPECT_EQ(late.tick(), 12);
  EXPECT_EQ(late.probe_values(0), 12.0);
  EXPECT_EQ(late.stats().skipped(), 10);
  EXPECT_EQ(meter->count, 2);
  ASSERT_TRUE(viewer->acknowledge(2).ok());
  viewer->next(0ns);
  ASSERT_FALSE(viewer->set_frame_rate(0.0, true, 0ns));
  step();
  EXPECT_EQ(meter->count, 2) << "it is paused";
}

TEST_F(MeasuringTest, ASheetAtRestIsPublishedAgainOnce) {
  const auto meter = std::make_shared<CountingMeter>();
  const auto viewer = watch(meter);
  step();
  frame(*viewer);
  step();
  stats_.paused = true;
  publish();
  ASSERT_TRUE(viewer->acknowledge(1).ok());
  EXPECT_TRUE(viewer->next(0ns).wants_snapshot);
  EXPECT_FALSE(viewer->next(0ns).wants_snapshot) << "it was asked for";
  publish();
  EXPECT_EQ(frame(*viewer).probe_values(0), 2.0);
  EXPECT_EQ(meter->count, 2);
}

TEST_F(MeasuringTest, WhatTakesLongIsMeasuredLessOften) {
  const auto meter = std::make_shared<CountingMeter>(&now_, 10ms);
  const auto viewer = watch(meter, 8);
  step();
  EXPECT_EQ(frame(*viewer, now_).tick(), 1);
  viewer->next(now_);
  now_ = 49ms;
  step();
  EXPECT_FALSE(viewer->next(now_).message) << "10 ms were spent on measuring 39 ms ago";
  EXPECT_EQ(meter->count, 1);
  now_ = 50ms;
  step();
  EXPECT_EQ(frame(*viewer, now_).tick(), 3);

  viewer->next(now_);
  stats_.sleeping = true;
  step();
  const Subscriber::Next next = viewer->next(now_);
  EXPECT_FALSE(next.wants_snapshot);
  EXPECT_EQ(next.wake_at, Nanoseconds(100ms)) << "nothing else would wake it";
  now_ = 100ms;
  EXPECT_TRUE(viewer->next(now_).wants_snapshot);
}

TEST_F(MeasuringTest, ManyReadersTakeTurns) {
  std::vector<std::shared_ptr<CountingMeter>> meters;
  std::vector<std::shared_ptr<Subscriber>> viewers;
  for (int i = 0; i < 6; ++i) {
    meters.push_back(std::make_shared<CountingMeter>(&now_, 1ms));
    viewers.push_back(watch(meters.back()));
  }
  const auto counts = [&] {
    std::vector<int> all;
    for (const auto& meter : meters) all.push_back(meter->count);
    return all;
  };
  step();
  EXPECT_EQ(counts(), (std::vector<int>{1, 1, 0, 0, 0, 0})) << "2 ms before a tick at most";
  now_ += 8ms;
  step();
  EXPECT_EQ(counts(), (std::vector<int>{1, 1, 1, 1, 0, 0}));
  now_ += 8ms;
  step();
  EXPECT_EQ(counts(), (std::vector<int>{1, 1, 1, 1, 1, 1}));
}

TEST_F(MeasuringTest, NoFrameIsEverWithoutItsValues) {
  std::mt19937 random(7);  // NOLINT(cert-msc51-cpp): the same trials every time
  const auto meter = std::make_shared<CountingMeter>(&now_, 300us);
  const auto viewer = watch(meter, 3);
  std::int64_t sent = 0;
  std::int64_t acknowledged = 0;
  for (int i = 0; i < 4000; ++i) {
    now_ += std::chrono::microseconds(random() % 1000);
    stats_.paused = random() % 8 == 0;
    switch (random() % 4) {
      case 0:
        step();
        break;
      case 1:
        if (acknowledged < sent) {
          acknowledged = sent;
          ASSERT_TRUE(viewer->acknowledge(sent, now_).ok());
        }
        break;
      default: {
        const Subscriber::Next next = viewer->next(now_);
        if (next.wants_snapshot) publish();
        if (!next.message) break;
        const v1::Frame frame = parse(*next.message).frame();
        sent = frame.sequence();
        ASSERT_EQ(frame.probe_values_size(), 2);
        ASSERT_EQ(frame.probe_values(0), static_cast<double>(frame.tick()));
      }
    }
  }
  EXPECT_GT(sent, 100);
  EXPECT_LT(meter->count, 2 * sent) << "about one measurement a frame";
}

}  // namespace
}  // namespace kerf::stream
