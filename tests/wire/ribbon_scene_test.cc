// The scene of a ribbon laid over a cloth, as an example of several components.
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "kerf/v1/scene.pb.h"
#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/json.h"
#include "server/service/wire/scene_codec.h"
#include "tests/support/paths.h"
#include "tests/support/solid_triangles.h"

namespace kerf::wire {
namespace {

constexpr std::int64_t kEnd = 420;  // ticks, three seconds after the cuts

scene::SheetConfig ribbon_scene() {
  std::ifstream file(test::source_path("deploy/scenes/ribbon.json"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  v1::Scene scene;
  EXPECT_TRUE(from_json(text, scene).ok());
  const Result<scene::SheetConfig> config = decode_scene(scene);
  EXPECT_TRUE(config.ok()) << config.error().message;
  return config.value();
}

TEST(RibbonScene, LiesOnTheClothAndIsCutWithItWhileNothingPassesThroughAnything) {
  const scene::SheetConfig config = ribbon_scene();
  ASSERT_EQ(config.commands.size(), 1U);
  const auto& cuts = std::get<scene::CutBatch>(config.commands[0].command).cuts;
  ASSERT_EQ(cuts.size(), 2U);
  EXPECT_EQ(cuts[0].component, "cloth");
  EXPECT_EQ(cuts[1].component, "ribbon");
  sheet::Sheet sheet = sheet::Sheet::create(config).value();
  contact::IntersectionSearch search;
  std::int64_t touching = 0;  // ticks in which the sheet touched itself
  while (sheet.tick() < kEnd) {
    const sheet::TickReport report = sheet.step({});
    for (const sheet::ScheduledReply& done : report.scheduled) {
      ASSERT_TRUE(done.reply.ok()) << done.reply.error().message;
      for (const scene::CutReply& cut : done.reply->batch) EXPECT_EQ(cut.status, cut::CutStatus::kApplied);
    }
    EXPECT_EQ(report.stats.flags & fem::kIntersects, 0U) << "tick " << report.tick;
    ASSERT_EQ(search.count(test::solid_triangles(sheet.mesh()), sheet.state().x), 0) << "tick " << report.tick;
    if (report.stats.self_contact.contacts > 0) ++touching;
    if (sheet.tick() + 1 == config.commands[0].tick) {
      ASSERT_EQ(sheet.pieces().size(), 2U);
      EXPECT_GT(sheet.pieces()[1].world_centroid.z(), 0.3) << "the ribbon lies on the cloth";
    }
  }
  EXPECT_GT(touching, 300);
  ASSERT_EQ(sheet.pieces().size(), 3U) << "the ribbon in two, the cloth in one with a slit";
  EXPECT_NEAR(sheet.pieces()[0].area, 1.0, 1e-9);
  EXPECT_NEAR(sheet.pieces()[1].area + sheet.pieces()[2].area, 0.16, 1e-9);
  EXPECT_LT(std::min(sheet.pieces()[1].world_centroid.z(), sheet.pieces()[2].world_centroid.z()), 0.3)
      << "one half at least has slipped through the slit";
}

}  // namespace
}  // namespace kerf::wire
