// Subscribers: what is sent to one, and when.

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/service/stream/channel.h"
#include "tests/stream/subscribing.h"
#include "tests/wire/changing_sheet.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::stream {
namespace {

using testing::ChangingSheet;
using testing::FrameMirror;

TEST(Subscriber, WindowBoundsTheFramesInFlight) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(5, 20, 30);
  int woken = 0;
  const auto viewer = subscribe(*channel, {.flow = {.window = 3}}, [&woken] { ++woken; });
  for (int tick = 0; tick < 10; ++tick) {
    sheet.move(0.01);
    channel->publish(sheet.snapshot());
    EXPECT_EQ(viewer->next(0ns).message.has_value(), tick < 3) << tick;
  }
  const int before = woken;
  ASSERT_TRUE(viewer->acknowledge(2).ok());
  EXPECT_EQ(woken, before + 1) << "an acknowledgement that opens the window";
  const v1::Frame newest = frame(*viewer);
  EXPECT_EQ(newest.tick(), 10);
  EXPECT_EQ(newest.stats().skipped(), 6);
  EXPECT_EQ(newest.base_tick(), 3);
}

TEST(Subscriber, ClosedWindowIsNotWokenByPublications) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(6, 20, 30);
  int woken = 0;
  const auto viewer = subscribe(*channel, {.flow = {.window = 1}}, [&woken] { ++woken; });
  for (int tick = 0; tick < 50; ++tick) {
    sheet.move(0.01);
    channel->publish(sheet.snapshot());
    if (woken > 0) viewer->next(0ns);
  }
  EXPECT_EQ(woken, 1);
}

TEST(Subscriber, UnsentBytesAreBounded) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(7, 1000, 30);
  const auto viewer = subscribe(*channel, {.flow = {.window = 8, .max_unacknowledged_bytes = 10'000}});
  std::size_t bytes = 0;
  int sent = 0;
  for (int tick = 0; tick < 8; ++tick) {
    sheet.move(0.3);
    channel->publish(sheet.snapshot());
    const Subscriber::Next next = viewer->next(0ns);
    if (!next.message) continue;
    EXPECT_LT(bytes, 10'000U) << "sent with the limit already reached";
    bytes += next.message->size();
    ++sent;
  }
  EXPECT_EQ(sent, 1) << "the first keyframe with its topology is beyond the limit already";
  ASSERT_TRUE(viewer->acknowledge(1).ok());
  EXPECT_TRUE(viewer->next(0ns).message);
}

TEST(Subscriber, RefusesToAcknowledgeWhatWasNotSent) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(8, 20, 30);
  const auto viewer = subscribe(*channel);
  for (const std::int64_t sequence : {0, 1, -1}) EXPECT_FALSE(viewer->acknowledge(sequence).ok());
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  frame(*viewer);
  EXPECT_TRUE(viewer->acknowledge(1).ok());
  EXPECT_TRUE(viewer->acknowledge(1).ok()) << "again is no error";
  const Status status = viewer->acknowledge(2);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(status.error().field, "ack.sequence");
}

TEST(Subscriber, EndsWhenNothingIsAcknowledgedForTooLong) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(9, 20, 30);
  const auto viewer = subscribe(*channel, {.flow = {.window = 2, .ack_timeout = 10s}});
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  frame(*viewer, 1s);
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  frame(*viewer, 5s);
  Subscriber::Next next = viewer->next(6s);
  EXPECT_EQ(next.wake_at, std::optional<Nanoseconds>(11s));
  ASSERT_TRUE(viewer->acknowledge(1).ok());
  next = viewer->next(14999ms);
  EXPECT_FALSE(next.message);
  EXPECT_EQ(next.wake_at, std::optional<Nanoseconds>(15s));
  next = viewer->next(15s);
  ASSERT_TRUE(next.message);
  EXPECT_EQ(parse(*next.message).ended().reason(), v1::Ended::TOO_SLOW);
  EXPECT_TRUE(viewer->ended());
}

TEST(Subscriber, KeepsToItsRate) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(10, 20, 30);
  const auto viewer = subscribe(*channel, {.flow = {.window = 1, .max_rate_hz = 20.0}});
  int sent = 0;
  Nanoseconds wake{0};
  for (int tick = 0; tick < 600; ++tick) {  // ten seconds at 60 Hz, with the timer that wake_at asks for
    const Nanoseconds now = std::chrono::nanoseconds(16'666'667) * tick;
    sheet.move(0.01);
    for (const Nanoseconds at : {std::min(wake, now), now}) {
      const Subscriber::Next next = viewer->next(at);
      if (next.wake_at) wake = *next.wake_at;
      if (!next.message) continue;
      ++sent;
      ASSERT_TRUE(viewer->acknowledge(sent).ok());
    }
    channel->publish(sheet.snapshot());
  }
  EXPECT_NEAR(sent, 200, 2);
}

TEST(Subscriber, NewBoxOrForgottenBaseMakesAKeyframe) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(11, 20, 30);
  const auto quick = subscribe(*channel, {.flow = {.window = 1}});
  const auto slow = subscribe(*channel, {.flow = {.window = 1}});
  const auto step = [&](double drift) {
    sheet.move(0.001, drift);
    channel->publish(sheet.snapshot());
    const v1::Frame next = frame(*quick);
    EXPECT_TRUE(quick->acknowledge(next.sequence()).ok());
    return next;
  };
  step(0.0);
  EXPECT_EQ(frame(*slow).base_tick(), -1);
  EXPECT_EQ(step(0.0).base_tick(), 1);
  ASSERT_TRUE(slow->acknowledge(1).ok());
  EXPECT_EQ(frame(*slow).base_tick(), 1) << "one tick was skipped, but its base is still known";
  EXPECT_EQ(step(100.0).base_tick(), -1) << "the sheet left the box";
  for (std::size_t i = 0; i < FrameHistory::kFrames; ++i) EXPECT_NE(step(0.0).base_tick(), -1);
  ASSERT_TRUE(slow->acknowledge(2).ok());
  EXPECT_EQ(frame(*slow).base_tick(), -1) << "its base has gone from the history";
}

TEST(Subscriber, RawReadersShareKeyframesOfTheirOwn) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(12, 200, 30);
  const auto compact = subscribe(*channel);
  const auto first = subscribe(*channel, {.flow = {}, .encoding = wire::Encoding::kRaw});
  const auto second = subscribe(*channel, {.flow = {}, .encoding = wire::Encoding::kRaw});
  FrameMirror mirror;
  for (int tick = 1; tick <= 4; ++tick) {
    sheet.move(0.001);
    if (tick == 3) sheet.cut(2);
    channel->publish(sheet.snapshot());
    const v1::Frame packed = frame(*compact);
    EXPECT_EQ(packed.encoding(), v1::COMPACT);
    const Subscriber::Next next = first->next(0ns);
    const Subscriber::Next same = second->next(0ns);
    ASSERT_TRUE(next.message && same.message);
    EXPECT_EQ(next.message->parts[1], same.message->parts[1]) << "not the same bytes";
    const v1::Frame raw = parse(*next.message).frame();
    EXPECT_EQ(raw.encoding(), v1::RAW);
    EXPECT_EQ(raw.base_tick(), -1);
    ASSERT_EQ(mirror.apply(raw), std::nullopt);
    for (const auto& viewer : {compact, first, second}) ASSERT_TRUE(viewer->acknowledge(tick).ok());
  }
  EXPECT_EQ(channel->counters().quantised, 4);
  EXPECT_EQ(channel->counters().keyframes, 1 + 4);
  EXPECT_EQ(channel->counters().deltas, 3);
  EXPECT_EQ(channel->counters().topologies, 2 + 2);
  EXPECT_EQ(channel->counters().predictors, 2) << "once a topology, not once a frame";
}

TEST(Subscriber, StrainsGoToWhoAsksAndAreEncodedOnce) {
  const auto channel = std::make_shared<Channel>(8);
  ChangingSheet sheet(16, 100, 150);
  const auto plain = subscribe(*channel);
  EXPECT_FALSE(channel->wants_strains());
  {
    const auto first = subscribe(*channel, {.flow = {}, .strains = true});
    const auto second = subscribe(*channel, {.flow = {}, .strains = true});
    EXPECT_TRUE(channel->wants_strains());
    FrameMirror mirror;
    for (int tick = 1; tick <= 5; ++tick) {
      sheet.move(0.001);
      const auto snapshot = sheet.snapshot(true);
      channel->publish(snapshot);
      EXPECT_EQ(frame(*plain).strain_scale(), 0.0);
      ASSERT_EQ(mirror.apply(frame(*first)), std::nullopt);
      ASSERT_EQ(mirror.strains.size(), snapshot->strains.size());
      for (std::size_t v = 0; v < mirror.strains.size(); ++v) {
        EXPECT_NEAR(mirror.strains[v], snapshot->strains[v], 0.0313 / 127.0);
      }
      frame(*second);
      for (const auto& viewer : {plain, first, second}) ASSERT_TRUE(viewer->acknowledge(tick).ok());
    }
    EXPECT_EQ(channel->counters().strains, 5);
    EXPECT_EQ(channel->counters().deltas, 4) << "the same for those with strains and those without";
  }
  EXPECT_FALSE(channel->wants_strains());
}

// Everything at once, at random: viewers of every window that take and acknowledge whenever they like.
TEST(Subscriber, HoldsItsPromisesUnderRandomAcknowledgements) {
  struct Viewer {
    std::shared_ptr<Subscriber> subscriber;
    FrameMirror mirror;
    int window = 1;
    std::int64_t acknowledged = 0;
    double eagerness = 0.5;
  };
  SeededRandom random(13);
  const auto channel = std::make_shared<Channel>(64);
  ChangingSheet sheet(14, 80, 120);
  std::vector<Viewer> viewers;
  int deltas = 0;
  int frames = 0;
  for (std::int64_t tick = 1; tick <= 3000; ++tick) {
    if (random.uniform() < 0.02 && viewers.size() < 40) {
      Viewer viewer;
      viewer.window = static_cast<int>(1 + random.below(8));
      viewer.eagerness = random.uniform();
      viewer.subscriber = subscribe(*channel, {.flow = {.window = viewer.window}});
      viewers.push_back(std::move(viewer));
    }
    if (random.uniform() < 0.01 && !viewers.empty()) viewers.erase(viewers.begin());
    sheet.move(0.002, random.uniform() < 0.01 ? 0.4 : 0.0);
    if (random.uniform() < 0.03) sheet.cut(2);
    if (random.uniform() < 0.002) sheet.reset(60, 90);
    const auto snapshot = sheet.snapshot();
    channel->publish(snapshot);
    for (Viewer& viewer : viewers) {
      if (random.uniform() > viewer.eagerness) continue;
      const Subscriber::Next next = viewer.subscriber->next(0ns);
      const std::int64_t in_flight = viewer.mirror.sequence - viewer.acknowledged;
      ASSERT_EQ(next.message.has_value(), in_flight < viewer.window && viewer.mirror.tick < tick);
      if (next.message) {
        const v1::Frame frame = parse(*next.message).frame();
        ASSERT_EQ(frame.tick(), tick) << "an old frame, though a newer one exists";
        ASSERT_EQ(frame.stats().skipped(), viewer.mirror.tick < 0 ? 0 : tick - viewer.mirror.tick - 1);
        ASSERT_EQ(viewer.mirror.apply(frame), std::nullopt);
        ASSERT_EQ(viewer.mirror.topology_version, snapshot->topology->version);
        ASSERT_EQ(viewer.mirror.triangles, snapshot->topology->triangles);
        ASSERT_EQ(viewer.mirror.pieces, snapshot->topology->pieces);
        for (std::size_t v = 0; v < viewer.mirror.quantised.size() / 3; ++v) {
          const std::array<double, 3> shown = viewer.mirror.position(v);
          for (std::size_t k = 0; k < 3; ++k) {
            const double exact = snapshot->positions(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(v));
            const double step = (viewer.mirror.box_max[k] - viewer.mirror.box_min[k]) / 65535.0;
            ASSERT_LE(std::abs(shown[k] - exact), 0.5001 * step);
          }
        }
        ++frames;
        deltas += frame.base_tick() == -1 ? 0 : 1;
      }
      if (random.uniform() < 0.7 && viewer.mirror.sequence > viewer.acknowledged) {
        const auto behind = static_cast<std::uint64_t>(viewer.mirror.sequence - viewer.acknowledged);
        viewer.acknowledged += static_cast<std::int64_t>(1 + random.below(behind));
        ASSERT_TRUE(viewer.subscriber->acknowledge(viewer.acknowledged).ok());
      }
    }
  }
  EXPECT_GT(frames, 5000);
  EXPECT_GT(deltas, frames / 2);
}

}  // namespace
}  // namespace kerf::stream
