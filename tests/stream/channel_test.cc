// Channels: what is sent to whom, and what it costs.

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/stream/channel.h"
#include "tests/stream/subscribing.h"
#include "tests/wire/changing_sheet.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::stream {
namespace {

using testing::ChangingSheet;
using testing::FrameMirror;

TEST(Channel, QuantisesAndBuildsNothingWithoutSubscribers) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(1, 50, 80);
  EXPECT_FALSE(channel->wants_snapshot());
  {
    const auto viewer = subscribe(*channel);
    EXPECT_TRUE(channel->wants_snapshot());
    for (int tick = 0; tick < 10; ++tick) {
      sheet.move(0.01);
      channel->publish(sheet.snapshot());
    }
    EXPECT_EQ(channel->counters().quantised, 0) << "nobody has taken a frame yet";
    frame(*viewer);
    EXPECT_EQ(channel->counters().quantised, 1);
  }
  EXPECT_FALSE(channel->wants_snapshot());
  EXPECT_EQ(channel->counters().keyframes, 1);
}

// Notes what the channel tells it.
class Note : public Reader {
 public:
  void wake() override { ++wakes; }
  void end(wire::EndReason) override { ++ends; }
  void leave() override {}
  int wakes = 0;
  int ends = 0;
};

TEST(Channel, ReadersOfAnyKindAreCountedWokenAndEnded) {
  const auto channel = std::make_shared<Channel>(2);
  ChangingSheet sheet(3, 50, 80);
  EXPECT_EQ(channel->newest().publication, 0);
  EXPECT_EQ(channel->newest().snapshot, nullptr);
  const auto note = std::make_shared<Note>();
  ASSERT_TRUE(channel->admit(note, false).ok());
  const auto viewer = subscribe(*channel);
  EXPECT_EQ(channel->admit(std::make_shared<Note>(), false).error().reason, "TOO_MANY_SUBSCRIBERS");
  EXPECT_FALSE(channel->wants_strains());
  channel->want_strains(*note, true);
  EXPECT_TRUE(channel->wants_strains());
  channel->publish(sheet.snapshot());
  EXPECT_EQ(note->wakes, 1);
  channel->leave(*note);
  channel->leave(*note);
  EXPECT_FALSE(channel->wants_strains());
  EXPECT_EQ(channel->num_subscribers(), 1);
  channel->publish(sheet.snapshot());
  EXPECT_EQ(note->wakes, 1);
  ASSERT_TRUE(channel->admit(note, false).ok());
  channel->ended(sheet::SinkEnd::kSheetDeleted);
  EXPECT_EQ(note->ends, 1);
}

TEST(Channel, ARevisionIsWhatTheSheetLooksLike) {
  const auto channel = std::make_shared<Channel>(2);
  ChangingSheet sheet(3, 50, 80);
  const auto publish = [&](const sheet::Snapshot& snapshot) {
    channel->publish(std::make_shared<const sheet::Snapshot>(snapshot));
    return channel->newest().revision;
  };
  sheet::Snapshot snapshot = *sheet.snapshot();
  EXPECT_EQ(publish(snapshot), 1);
  snapshot.stats.paused = true;
  EXPECT_EQ(publish(snapshot), 1) << "it is only paused";
  snapshot.positions(0, 0) += 0.25;
  EXPECT_EQ(publish(snapshot), 2);
  ++snapshot.tick;
  EXPECT_EQ(publish(snapshot), 3);
  snapshot.topology = std::make_shared<const sheet::Topology>(*snapshot.topology);
  EXPECT_EQ(publish(snapshot), 4);
  EXPECT_EQ(channel->newest().publication, 5);
}

TEST(Channel, EncodesOnceForAllWhoNeedTheSame) {
  const auto channel = std::make_shared<Channel>(64);
  ChangingSheet sheet(2, 500, 800);
  std::vector<std::shared_ptr<Subscriber>> viewers;
  for (int i = 0; i < 60; ++i) viewers.push_back(subscribe(*channel));
  std::vector<Bytes> bodies;
  for (int tick = 0; tick < 10; ++tick) {
    sheet.move(0.001);
    if (tick == 5) sheet.cut(2);
    channel->publish(sheet.snapshot());
    bodies.clear();
    for (const auto& viewer : viewers) {
      const Subscriber::Next next = viewer->next(0ns);
      ASSERT_TRUE(next.message);
      bodies.push_back(next.message->parts[1]);
      ASSERT_TRUE(viewer->acknowledge(tick + 1).ok());
    }
    for (const Bytes& body : bodies) EXPECT_EQ(body.get(), bodies.front().get()) << "not the same bytes, but a copy";
  }
  const EncodeCounters counters = channel->counters();
  EXPECT_EQ(counters.quantised, 10);
  EXPECT_EQ(counters.keyframes, 1);
  EXPECT_EQ(counters.deltas, 9);
  EXPECT_EQ(counters.topologies, 2);
  EXPECT_EQ(counters.taken, 600);
}

TEST(Channel, VersionsThatNoPatchLeadsFromShareTheFullOne) {
  const auto channel = std::make_shared<Channel>(64);
  ChangingSheet sheet(2, 500, 800);
  sheet.cut(2);
  channel->publish(sheet.snapshot());
  const std::int32_t newest = sheet.snapshot()->topology->version;
  const std::string epoch = frame(*subscribe(*channel)).epoch();
  std::vector<Bytes> patches;
  for (std::int32_t i = 1; i <= 50; ++i) {
    for (const std::int32_t version : {-i, newest + i}) {
      const auto viewer = subscribe(*channel, {.flow = {}, .epoch = epoch, .topology_version = version});
      patches.push_back(viewer->next(0ns).message->parts[2]);
    }
  }
  for (const Bytes& patch : patches) EXPECT_EQ(patch.get(), patches.front().get());
  EXPECT_EQ(channel->counters().topologies, 1);
}

TEST(Channel, ASheetThatWentBackBeginsAgainForEveryReader) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(5, 60, 90);
  const auto publish_as = [&](std::uint64_t serial, std::int64_t tick) {
    auto snapshot = std::make_shared<sheet::Snapshot>(*sheet.snapshot());
    snapshot->stats.sheet_serial = serial;
    snapshot->tick = tick;
    channel->publish(std::move(snapshot));
  };
  publish_as(1, 100);
  const auto follower = subscribe(*channel, {.flow = {.window = 8}});
  FrameMirror mirror;
  const v1::Frame first = frame(*follower);
  ASSERT_EQ(mirror.apply(first), std::nullopt);
  publish_as(1, 101);
  const v1::Frame second = frame(*follower);
  EXPECT_EQ(second.base_tick(), 100);
  EXPECT_TRUE(second.epoch().empty());
  ASSERT_EQ(mirror.apply(second), std::nullopt);
  sheet = ChangingSheet(6, 40, 50);  // Smaller, with an equal version.
  publish_as(2, 7);
  const v1::Frame back = frame(*follower);
  EXPECT_EQ(back.base_tick(), -1);
  EXPECT_EQ(back.tick(), 7);
  EXPECT_EQ(back.topology_version(), second.topology_version());
  EXPECT_EQ(back.topology().base_version(), -1);
  EXPECT_FALSE(back.epoch().empty());
  EXPECT_NE(back.epoch(), first.epoch());
  EXPECT_EQ(back.stats().skipped(), 0);
  ASSERT_EQ(mirror.apply(back), std::nullopt);
  EXPECT_EQ(mirror.triangles.size(), 50U);
  publish_as(2, 8);
  const v1::Frame on = frame(*follower);
  EXPECT_EQ(on.base_tick(), 7);
  EXPECT_TRUE(on.epoch().empty());
  EXPECT_EQ(mirror.apply(on), std::nullopt);
}

TEST(Channel, JoinerGetsTheKeyframeOfASleepingSheetAtOnce) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(3, 20, 30);
  const auto first = subscribe(*channel);
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  frame(*first);
  const auto second = subscribe(*channel);
  const v1::Frame joined = frame(*second);
  EXPECT_EQ(joined.base_tick(), -1);
  EXPECT_EQ(joined.topology().base_version(), -1);
  EXPECT_EQ(joined.sequence(), 1);
  EXPECT_FALSE(second->next(0ns).message) << "nothing newer was published";
}

TEST(Channel, RefusesMoreSubscribersThanItsLimit) {
  const auto channel = std::make_shared<Channel>(2);
  const auto first = subscribe(*channel);
  auto second = subscribe(*channel);
  const auto third = channel->subscribe({}, kIgnore);
  ASSERT_FALSE(third.ok());
  EXPECT_EQ(third.error().code, ErrorCode::kResourceExhausted);
  second.reset();
  EXPECT_TRUE(channel->subscribe({}, kIgnore).ok());
}

TEST(Channel, EndReachesEveryoneOnceAndLast) {
  const auto channel = std::make_shared<Channel>(4);
  ChangingSheet sheet(4, 20, 30);
  int woken = 0;
  const auto viewer = subscribe(*channel, {}, [&woken] { ++woken; });
  sheet.move(0.01);
  channel->publish(sheet.snapshot());
  channel->ended(sheet::SinkEnd::kSheetDeleted);
  EXPECT_EQ(woken, 2);
  const Subscriber::Next next = viewer->next(0ns);
  ASSERT_TRUE(next.message);
  EXPECT_EQ(parse(*next.message).ended().reason(), v1::Ended::SHEET_DELETED);
  EXPECT_TRUE(viewer->ended());
  EXPECT_FALSE(viewer->next(0ns).message);
  EXPECT_EQ(channel->subscribe({}, kIgnore).error().code, ErrorCode::kUnavailable);
}

// One thread publishes, as a sheet's strand does; others take and acknowledge; viewers come and go. For the thread
// sanitizer, and to check that no viewer waits for a frame that exists.
TEST(Channel, ServesThreadsWhileItIsPublishedTo) {
  const auto channel = std::make_shared<Channel>(64);
  ChangingSheet sheet(15, 60, 90);
  constexpr std::int64_t kTicks = 2000;
  std::atomic<bool> started{false};
  std::vector<std::thread> threads;
  std::atomic<int> finished{0};
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      std::atomic<int> ready{0};
      FrameMirror mirror;
      auto viewer =
          subscribe(*channel, {.flow = {.window = 1 + i}}, [&ready] { ready.fetch_add(1), ready.notify_all(); });
      while (!started) std::this_thread::yield();
      while (mirror.tick < kTicks) {
        const int seen = ready;
        if (const auto next = viewer->next(0ns); next.message) {
          ASSERT_EQ(mirror.apply(parse(*next.message).frame()), std::nullopt);
          ASSERT_TRUE(viewer->acknowledge(mirror.sequence).ok());
        } else {
          ready.wait(seen);
        }
      }
      viewer->leave();
      ++finished;
    });
  }
  std::thread guest([&] {
    for (int i = 0; i < 200; ++i) {
      const auto viewer = subscribe(*channel);
      static_cast<void>(viewer->next(0ns));
    }
  });
  started = true;
  for (std::int64_t tick = 0; tick < kTicks; ++tick) {
    sheet.move(0.002);
    if (tick % 100 == 50) sheet.cut(1);
    channel->publish(sheet.snapshot());
  }
  for (std::thread& thread : threads) thread.join();
  guest.join();
  EXPECT_EQ(finished, 4);
  EXPECT_EQ(channel->num_subscribers(), 0);
}

}  // namespace
}  // namespace kerf::stream
