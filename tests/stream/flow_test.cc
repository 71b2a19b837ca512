// Readers near and far, quick and slow, over wide links and narrow ones, simulated in time: how old their frames are,
// how many come, and that none of it touches another reader.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/service/stream/channel.h"
#include "tests/wire/changing_sheet.h"

namespace kerf::stream {
namespace {

using testing::ChangingSheet;
using namespace std::chrono_literals;

constexpr Nanoseconds kTick = 16'666'667ns;
constexpr Nanoseconds kResolution = 100us;
constexpr int kVertices = 500;

struct Reader {
  std::string name;
  Nanoseconds one_way{0};      // each way
  double bytes_per_s = 1.0e9;  // of the link to the reader
  Nanoseconds holds{100us};    // each frame, before it acknowledges and takes another
  double max_rate_hz = 0.0;
};

// A reader at the end of its link.
class Simulated {
 public:
  Simulated(Channel& channel, const Reader& reader)
      : reader_(reader),
        subscriber_(channel.subscribe({.flow = {.window = 0, .max_rate_hz = reader.max_rate_hz}}, [] {}).value()) {}

  void advance(Nanoseconds now) {
    while (!acks_.empty() && acks_.front().at <= now) {
      EXPECT_TRUE(subscriber_->acknowledge(acks_.front().sequence, now, acks_.front().held).ok());
      acks_.pop_front();
    }
    send(now);
    read(now);
  }

  // From when `from` is: ages of the frames at the moment they are read, the mean of their number a second.
  [[nodiscard]] double oldest_ms(Nanoseconds from) const {
    double oldest = 0.0;
    for (const Seen& each : seen_) {
      if (each.at >= from) oldest = std::max(oldest, std::chrono::duration<double, std::milli>(each.age).count());
    }
    return oldest;
  }
  [[nodiscard]] double rate_hz(Nanoseconds from, Nanoseconds to) const {
    const auto count = std::count_if(seen_.begin(), seen_.end(), [&](const Seen& each) { return each.at >= from; });
    return static_cast<double>(count) / std::chrono::duration<double>(to - from).count();
  }
  [[nodiscard]] std::int32_t window() const { return subscriber_->window(); }
  // Leaves out the first frame.
  [[nodiscard]] double longest_on_link_ms() const {
    return std::chrono::duration<double, std::milli>(longest_on_link_).count();
  }

 private:
  struct Arrival {
    std::int64_t sequence;
    Nanoseconds made;  // the tick that the frame shows
    Nanoseconds at;
  };
  struct Ack {
    std::int64_t sequence;
    Nanoseconds held;
    Nanoseconds at;
  };
  struct Seen {
    Nanoseconds at;
    Nanoseconds age;
  };

  void send(Nanoseconds now) {
    while (auto message = subscriber_->next(now).message) {
      v1::WatchResponse response;
      ASSERT_TRUE(response.ParseFromString(message->joined()));
      const Nanoseconds takes(
          static_cast<std::int64_t>(1.0e9 * static_cast<double>(message->size()) / reader_.bytes_per_s));
      link_free_ = std::max(link_free_, now) + takes;
      if (response.frame().sequence() > 1) longest_on_link_ = std::max(longest_on_link_, takes);
      on_the_way_.push_back(
          {response.frame().sequence(), response.frame().tick() * kTick, link_free_ + reader_.one_way});
    }
  }

  // Like a page that draws: takes a frame that has come, is busy with it, acknowledges.
  void read(Nanoseconds now) {
    if (busy_until_ && *busy_until_ > now) return;
    if (busy_until_) {
      acks_.push_back({reading_.sequence, now - reading_.at, now + reader_.one_way});
      busy_until_.reset();
    }
    if (on_the_way_.empty() || on_the_way_.front().at > now) return;
    reading_ = on_the_way_.front();
    on_the_way_.pop_front();
    reading_.at = now;  // the reader knows of it only now
    seen_.push_back({now, now - reading_.made});
    busy_until_ = now + reader_.holds;
  }

  Reader reader_;
  std::shared_ptr<Subscriber> subscriber_;
  std::deque<Arrival> on_the_way_;
  std::deque<Ack> acks_;
  Nanoseconds link_free_{0};
  Nanoseconds longest_on_link_{0};
  std::optional<Nanoseconds> busy_until_;
  Arrival reading_{};
  std::vector<Seen> seen_;
};

struct Outcome {
  std::vector<std::unique_ptr<Simulated>> readers;
  EncodeCounters counters;
};

// So many seconds of a sheet at 60 Hz.
Outcome run(const std::vector<Reader>& readers, Nanoseconds until) {
  const auto channel = std::make_shared<Channel>(64);
  ChangingSheet sheet(21, kVertices, 800);
  Outcome result;
  for (const Reader& reader : readers) result.readers.push_back(std::make_unique<Simulated>(*channel, reader));
  Nanoseconds next_tick = kTick;
  for (Nanoseconds now = 0ns; now < until; now += kResolution) {
    if (now >= next_tick) {
      sheet.move(0.002);
      channel->publish(sheet.snapshot());
      next_tick += kTick;
    }
    if (channel->counters().quantised == 0 && next_tick == kTick) continue;  // nothing published yet
    for (const auto& reader : result.readers) reader->advance(now);
  }
  result.counters = channel->counters();
  return result;
}

constexpr Nanoseconds kWarm = 4s;
constexpr Nanoseconds kEnd = 14s;

struct Expected {
  Reader reader;
  double least_rate_hz;
};

class Flow : public ::testing::TestWithParam<Expected> {};

// The promise: nothing older than a round trip and a frame, whoever reads and over whatever link; and about as many
// frames as reader and link can take.
TEST_P(Flow, FramesAreNoOlderThanARoundTripAndAFrame) {
  const auto& [reader, least_rate_hz] = GetParam();
  const Outcome result = run({reader}, kEnd);
  const Simulated& simulated = *result.readers[0];
  const double round_trip_ms = std::chrono::duration<double, std::milli>(2 * reader.one_way).count();
  const double tick_ms = std::chrono::duration<double, std::milli>(kTick).count();
  // The frame's own time on the link belongs to the way; one more may be before it there.
  EXPECT_LE(simulated.oldest_ms(kWarm), round_trip_ms + tick_ms + 2.0 * simulated.longest_on_link_ms() + 0.5)
      << "window " << simulated.window();
  EXPECT_GE(simulated.rate_hz(kWarm, kEnd), least_rate_hz) << "window " << simulated.window();
}

// Not before a window has been found either, nor while it grows.
TEST(FlowFirst, NoFrameWaitsBehindOneThatASlowReaderHolds) {
  for (const Reader& reader : {Reader{"FarAt2Hz", 100ms, 1e9, 500ms}, Reader{"FarAt10Hz", 50ms, 1e9, 100ms},
                               Reader{"FarAt20Hz", 80ms, 1e9, 50ms}, Reader{"VeryFarAt5Hz", 300ms, 1e9, 200ms}}) {
    const Outcome result = run({reader}, kEnd);
    const double round_trip_ms = std::chrono::duration<double, std::milli>(2 * reader.one_way).count();
    EXPECT_LE(result.readers[0]->oldest_ms(0s), round_trip_ms + 17.0 + 0.5) << reader.name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Readers, Flow,
    ::testing::Values(Expected{{"Beside", 50us}, 59.0}, Expected{{"BesideAt10Hz", 50us, 1e9, 100ms}, 8.0},
                      Expected{{"BesideAt2Hz", 50us, 1e9, 500ms}, 1.8}, Expected{{"Screen", 1ms, 1e9, 12ms}, 50.0},
                      Expected{{"Far", 50ms}, 50.0}, Expected{{"FarAt10Hz", 50ms, 1e9, 100ms}, 4.8},
                      Expected{{"FarAt2Hz", 100ms, 1e9, 500ms}, 1.4}, Expected{{"VeryFar", 150ms}, 20.0},
                      Expected{{"NarrowLink", 2ms, 40e3}, 12.0}, Expected{{"NarrowAndFar", 40ms, 60e3}, 10.0}),
    [](const auto& each) { return each.param.reader.name; });

TEST(FlowAmongOthers, AStalledReaderTakesNothingFromAnother) {
  const Reader quick{"quick", 1ms};
  const Reader stalled{"stalled", 50us, 1.0e9, 1h};
  std::vector<Reader> readers{quick};
  const Outcome alone = run(readers, 6s);
  for (int i = 0; i < 30; ++i) readers.push_back(stalled);
  const Outcome beside = run(readers, 6s);
  EXPECT_EQ(alone.readers[0]->rate_hz(0s, 6s), beside.readers[0]->rate_hz(0s, 6s));
  EXPECT_EQ(alone.readers[0]->oldest_ms(0s), beside.readers[0]->oldest_ms(0s));
  EXPECT_EQ(alone.counters.deltas, beside.counters.deltas);
}

TEST(FlowAmongOthers, ReadersOfOneRateShareTheirDeltas) {
  std::vector<Reader> readers;
  for (int i = 0; i < 12; ++i) readers.push_back({"slow", i * 300us, 1.0e9, 100us, 15.0});
  for (int i = 0; i < 12; ++i) readers.push_back({"quick", i * 300us});
  const Outcome result = run(readers, 5s);
  EXPECT_NEAR(result.readers[0]->rate_hz(1s, 5s), 15.0, 0.6);
  // One delta a tick for all quick ones, and one every fourth for the others; a joiner's keyframe.
  EXPECT_LE(result.counters.deltas, 5 * (60 + 15) + 60);
  EXPECT_GE(result.counters.taken, 12 * 4 * (50 + 14));
}

TEST(WindowControl, StaysWhereItIsFixedOrNothingIsTold) {
  WindowControl fixed(5);
  for (int i = 0; i < 50; ++i) fixed.acknowledged(300ms, 1ms, true, kTick);
  EXPECT_EQ(fixed.window(), 5);
  FlowControl untold({.window = 0});
  for (int i = 1; i < 50; ++i) {
    EXPECT_EQ(untold.window(), 1);
    untold.sent(100, 1, i * kTick);
    ASSERT_TRUE(untold.acknowledge(i, (i + 1) * kTick, 0ns).ok());
  }
}

TEST(FlowControl, ANewPlaceInTheWindowIsTakenHalfwayBetweenTwoFrames) {
  FlowControl flow({.window = 0});
  Nanoseconds now = 0ns;
  std::int64_t sequence = 0;
  while (flow.window() == 1) {  // a way of 100 ms, each frame held as long
    sequence = flow.sent(100, 12, now);
    now += 200ms;
    ASSERT_TRUE(flow.acknowledge(sequence, now, 100ms).ok());
    ASSERT_LT(sequence, 10);
  }
  ASSERT_TRUE(flow.permit(now).may_send);
  flow.sent(100, 12, now);
  const FlowControl::Permit early = flow.permit(now + 99ms);
  EXPECT_FALSE(early.may_send);
  EXPECT_EQ(early.wake_at, now + 100ms);
  EXPECT_TRUE(flow.permit(now + 100ms).may_send);
}

TEST(WindowControl, NeverLeavesItsRange) {
  WindowControl control(0);
  for (int i = 0; i < 200; ++i) {
    control.acknowledged(2s, 1us, true, kTick);
    ASSERT_GE(control.window(), 1);
    ASSERT_LE(control.window(), kMaxWindow);
  }
  EXPECT_EQ(control.window(), kMaxWindow);
  for (int i = 0; i < 200; ++i) control.acknowledged(1us, 1us, false, 1ms);
  EXPECT_EQ(control.window(), 1);
}

TEST(Subscriber, PausesWithoutOwingAnything) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(22, 20, 30);
  const auto viewer = channel->subscribe({.flow = {.window = 1, .ack_timeout = 10s}}, [] {}).value();
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  ASSERT_TRUE(viewer->next(0s).message);
  EXPECT_TRUE(channel->wants_snapshot());
  EXPECT_FALSE(viewer->set_frame_rate(0.0, true, 1s));
  EXPECT_FALSE(channel->wants_snapshot()) << "nobody looks";
  sheet.move(0.01);
  channel->publish(sheet.snapshot());  // under way when the pause began
  EXPECT_FALSE(viewer->next(100s).message) << "neither a frame nor the end for owing an acknowledgement";
  EXPECT_FALSE(viewer->ended());
  EXPECT_TRUE(viewer->set_frame_rate(0.0, false, 100s));
  EXPECT_TRUE(channel->wants_snapshot());
  ASSERT_TRUE(viewer->acknowledge(1, 101s).ok());
  EXPECT_FALSE(viewer->next(101s).message) << "what is there is as old as the pause is long";
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  const Subscriber::Next next = viewer->next(101s);
  ASSERT_TRUE(next.message);
  v1::WatchResponse response;
  ASSERT_TRUE(response.ParseFromString(next.message->joined()));
  EXPECT_EQ(response.frame().tick(), 3);
}

TEST(Subscriber, APaceIsNoAcknowledgement) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(22, 20, 30);
  const auto viewer = channel->subscribe({.flow = {.window = 1, .ack_timeout = 10s}}, [] {}).value();
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  ASSERT_TRUE(viewer->next(0s).message);
  for (const auto now : {3s, 6s, 9s}) EXPECT_FALSE(viewer->set_frame_rate(50.0, false, now));
  EXPECT_FALSE(viewer->next(9s).message);
  EXPECT_TRUE(viewer->next(10s).message);
  EXPECT_TRUE(viewer->ended());
}

TEST(Subscriber, ResumesFromWhatItsEpochHas) {
  const auto channel = std::make_shared<Channel>(4, "instance");
  ChangingSheet sheet(23, 200, 300);
  sheet.move(0.01);
  const auto first_frame = [&](SubscriberOptions options) {
    const auto viewer = channel->subscribe(options, [] {}).value();
    v1::WatchResponse response;
    EXPECT_TRUE(response.ParseFromString(viewer->next(0s).message->joined()));
    return response.frame();
  };
  const auto keeper = channel->subscribe({}, [] {}).value();
  channel->publish(sheet.snapshot());
  const v1::Frame fresh = first_frame({});
  EXPECT_EQ(fresh.epoch(), "instance-0");
  EXPECT_EQ(fresh.topology().base_version(), -1);
  const std::int32_t version = fresh.topology_version();

  EXPECT_FALSE(first_frame({.flow = {}, .epoch = "instance-0", .topology_version = version}).has_topology());
  sheet.cut(2);
  channel->publish(sheet.snapshot());
  EXPECT_EQ(first_frame({.flow = {}, .epoch = "instance-0", .topology_version = version}).topology().base_version(),
            version);
  EXPECT_EQ(first_frame({.flow = {}, .epoch = "earlier-0", .topology_version = version}).topology().base_version(), -1);
  EXPECT_EQ(first_frame({.flow = {}, .epoch = "instance-0", .topology_version = version + 9}).topology().base_version(),
            -1)
      << "a version that this epoch has not had";
  sheet.reset(50, 60);
  channel->publish(sheet.snapshot());
  EXPECT_EQ(first_frame({.flow = {}, .epoch = "instance-0", .topology_version = version}).topology().base_version(),
            -1);
}

}  // namespace
}  // namespace kerf::stream
