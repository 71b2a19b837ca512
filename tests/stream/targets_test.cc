// The targets of the protocol that are counts and bytes, held by whole messages of real sheets as subscribers get them.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/core/fem/element/material.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "server/service/stream/channel.h"

namespace kerf::stream {
namespace {

using namespace std::chrono_literals;

constexpr double kDeltaBytesPerVertex = 3.2;
constexpr double kKeyframeBytesPerVertex = 5.2;
constexpr double kIndexBytesPerTriangle = 1.3;
constexpr double kBytesPerNewVertex = 24.0;
constexpr double kBytesPerChangedTriangle = 10.0;
constexpr std::size_t kStalledViewers = 100;
constexpr std::size_t kBytesOfStalledViewers = 100'000'000;  // of all of them together
constexpr Nanoseconds kTickAt60Hz = 16'666'667ns;

sheet::Sheet swinging(int side) {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = side;
  grid.rows = side;
  config.mesh = grid;
  config.material = fem::find_preset("demo").value();
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.emplace_back(scene::RegionEdge::kTopCorners);
  return sheet::Sheet::create(std::move(config)).value();
}

// A sheet and those who watch it, tick by tick.
class Stage {
 public:
  explicit Stage(int side) : sheet_(swinging(side)) { channel_->publish(sheet_.snapshot()); }

  std::shared_ptr<Subscriber> join(std::int32_t window = 0) {
    SubscriberOptions options;
    options.flow.window = window;
    options.flow.ack_timeout = 1h;  // of a viewer that holds its frames through the whole test
    return channel_->subscribe(options, [] {}).value();
  }
  void tick(std::span<const scene::Command> commands = {}) {
    sheet_.step(commands);
    channel_->publish(sheet_.snapshot());
  }
  [[nodiscard]] Nanoseconds now() const { return sheet_.tick() * kTickAt60Hz; }
  [[nodiscard]] const sheet::Sheet& sheet() const { return sheet_; }
  [[nodiscard]] EncodeCounters counters() const { return channel_->counters(); }

 private:
  std::shared_ptr<Channel> channel_ = std::make_shared<Channel>(256);
  sheet::Sheet sheet_;
};

struct Taken {
  v1::Frame frame;
  std::size_t bytes = 0;  // of the whole message
};

// The next frame, acknowledged.
std::optional<Taken> take(Subscriber& subscriber, Nanoseconds now) {
  const std::optional<Message> message = subscriber.next(now).message;
  if (!message) return std::nullopt;
  v1::WatchResponse response;
  EXPECT_TRUE(response.ParseFromString(message->joined()));
  EXPECT_TRUE(subscriber.acknowledge(response.frame().sequence(), now, 100us).ok());
  return Taken{response.frame(), message->size()};
}

TEST(StreamTargets, AJoinIsOneKeyframeWithItsTopologyThenDifferences) {
  Stage stage(50);
  for (int i = 0; i < 30; ++i) stage.tick();
  const auto viewer = stage.join();
  const double vertices = stage.sheet().mesh().num_vertices();
  const double triangles = stage.sheet().mesh().num_solid_triangles();
  const std::optional<Taken> first = take(*viewer, stage.now());
  ASSERT_TRUE(first);
  EXPECT_LT(first->frame.base_tick(), 0);
  EXPECT_EQ(first->frame.topology().base_version(), -1);
  EXPECT_FALSE(viewer->next(stage.now()).message) << "all that there is has come in one message";
  const double topology = static_cast<double>(first->frame.topology().ByteSizeLong());
  EXPECT_LE(static_cast<double>(first->frame.topology().triangles().size()), kIndexBytesPerTriangle * triangles);
  EXPECT_LE(static_cast<double>(first->bytes) - topology, kKeyframeBytesPerVertex * vertices);
  int differences = 0;
  for (int i = 0; i < 30; ++i) {
    stage.tick();
    const std::optional<Taken> next = take(*viewer, stage.now());
    ASSERT_TRUE(next);
    EXPECT_FALSE(next->frame.has_topology());
    EXPECT_EQ(next->frame.stats().skipped(), 0);
    differences += next->frame.base_tick() >= 0 ? 1 : 0;
  }
  EXPECT_GE(differences, 25) << "the others are keyframes, where the sheet left its box";
}

TEST(StreamTargets, ASheetThatIsCutAgainAndAgainKeepsToItsBytes) {
  Stage stage(50);
  const auto viewer = stage.join();
  ASSERT_TRUE(take(*viewer, stage.now()));
  double vertices_before = stage.sheet().mesh().num_vertices();
  double bytes = 0.0;
  double budget = 0.0;
  int cuts = 0;
  for (int i = 0; i < 60; ++i) {
    std::vector<scene::Command> commands;
    if (i % 5 == 4) {
      const double y = 0.1 + 0.013 * i;
      scene::Cut cut;
      cut.curve = cut::CubicBezier{{{0.2, y}, {0.4, y + 0.1}, {0.6, y - 0.1}, {0.8, y}}};
      commands.emplace_back(cut);
    }
    stage.tick(commands);
    const std::optional<Taken> next = take(*viewer, stage.now());
    ASSERT_TRUE(next);
    EXPECT_EQ(next->frame.tick(), stage.sheet().tick());
    EXPECT_EQ(next->frame.has_topology(), !commands.empty()) << "a cut comes with the frame of its tick";
    const double vertices = stage.sheet().mesh().num_vertices();
    bytes += static_cast<double>(next->bytes);
    budget += (next->frame.base_tick() >= 0 ? kDeltaBytesPerVertex : kKeyframeBytesPerVertex) * vertices;
    if (next->frame.has_topology()) {
      ++cuts;
      EXPECT_GE(next->frame.topology().base_version(), 0) << "what has changed, and not the whole";
      budget += kBytesPerNewVertex * (vertices - vertices_before) +
                kBytesPerChangedTriangle * next->frame.topology().num_listed_slots();
    }
    vertices_before = vertices;
  }
  EXPECT_EQ(cuts, 12);
  EXPECT_LE(bytes, budget);
}

// They hold the bytes that may be in flight to each of them, as if no two shared a byte.
TEST(StreamTargets, AHundredStalledViewersHoldLittleAndDelayNobody) {
  Stage stage(100);
  std::vector<std::shared_ptr<Subscriber>> stalled;
  for (std::size_t i = 0; i < kStalledViewers; ++i) stalled.push_back(stage.join(kMaxWindow));
  const auto lively = stage.join();
  std::vector<Message> held;
  std::int64_t frames = 0;
  constexpr int kTicks = 24;
  for (int i = 0; i < kTicks; ++i) {
    stage.tick();
    for (const auto& viewer : stalled) {
      while (auto message = viewer->next(stage.now()).message) held.push_back(*std::move(message));
    }
    const std::optional<Taken> next = take(*lively, stage.now());
    ASSERT_TRUE(next);
    EXPECT_EQ(next->frame.tick(), stage.sheet().tick()) << "no tick old";
    EXPECT_EQ(next->frame.stats().skipped(), 0);
    ++frames;
  }
  EXPECT_EQ(frames, kTicks);
  EXPECT_EQ(held.size(), kStalledViewers * kMaxWindow) << "then their windows are closed";
  std::size_t apart = 0;
  std::size_t shared = 0;
  std::set<const std::string*> seen;
  for (const Message& message : held) {
    apart += message.size();
    for (const Bytes& part : message.parts) shared += seen.insert(part.get()).second ? part->size() : 0;
  }
  EXPECT_LE(apart, kBytesOfStalledViewers);
  EXPECT_LE(shared, kBytesOfStalledViewers / 50) << "they share all but their heads";
  EXPECT_LE(stage.counters().keyframes + stage.counters().deltas, kTicks + 1) << "nothing is encoded for them alone";
}

}  // namespace
}  // namespace kerf::stream
