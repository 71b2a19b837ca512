// The scene that deploy/run shows to a first visitor.
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "kerf/v1/scene.pb.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/json.h"
#include "server/service/wire/scene_codec.h"
#include "tests/support/paths.h"

namespace kerf::wire {
namespace {

TEST(DemoScene, TellsItsStoryRaisesNoFlagAndFallsAsleepWithinTwentySecondsOfItsLastCut) {
  std::ifstream file(test::source_path("deploy/scenes/demo.json"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  v1::Scene scene;
  ASSERT_TRUE(from_json(text, scene).ok());
  const Result<scene::SheetConfig> config = decode_scene(scene);
  ASSERT_TRUE(config.ok()) << config.error().message;
  ASSERT_FALSE(config->commands.empty());
  const std::int64_t last_cut = config->commands.back().tick;
  sheet::Sheet demo = sheet::Sheet::create(*config).value();
  fem::FlagCounts flags{};
  double largest_share = 0.0;
  const std::int64_t end = last_cut + 20 * 60;
  EXPECT_GT(config->repeat_after, last_cut + 600) << "the disc has time to drop";
  while (demo.tick() < end) {
    const sheet::TickReport report = demo.step({});
    for (const sheet::ScheduledReply& cut : report.scheduled) EXPECT_TRUE(cut.reply.ok());
    fem::count_flags(report.stats.flags, flags);
    largest_share = std::max(largest_share, report.stats.strained_share);
    if (report.at_rest) break;
  }
  EXPECT_TRUE(demo.at_rest());
  EXPECT_EQ(flags, fem::FlagCounts{});
  EXPECT_LT(largest_share, 0.005) << "patches hold the cloth without tearing at it";
  ASSERT_EQ(demo.pieces().size(), 2U);
  double lowest = 1.0;
  for (const scene::Piece& piece : demo.pieces()) lowest = std::min(lowest, piece.world_centroid.z());
  EXPECT_LT(lowest, 0.05) << "the disc lies on the floor";
}

}  // namespace
}  // namespace kerf::wire
