#include "server/core/sheet/scene_clock.h"

#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

SceneClock with_commands_at(const std::vector<std::int64_t>& ticks) {
  auto config = std::make_shared<scene::SheetConfig>(scenes::hanging(3));
  for (const std::int64_t tick : ticks) config->commands.push_back({tick, scene::SetGravity{}});
  return SceneClock(std::move(config));
}

std::vector<std::size_t> pop_all(SceneClock& clock) {
  std::vector<std::size_t> due;
  while (const std::optional<std::size_t> index = clock.pop_due()) due.push_back(*index);
  return due;
}

TEST(SceneClock, YieldsCommandsByTickAndEqualTicksInTheirOrder) {
  SceneClock clock = with_commands_at({2, 1, 2, 1, 4});
  EXPECT_THAT(pop_all(clock), ElementsAre(1, 3));
  clock.advance();
  EXPECT_THAT(pop_all(clock), ElementsAre(0, 2));
  clock.advance();
  EXPECT_THAT(pop_all(clock), IsEmpty());
  EXPECT_FALSE(clock.is_exhausted());
  clock.advance();
  EXPECT_THAT(pop_all(clock), ElementsAre(4));
  EXPECT_TRUE(clock.is_exhausted());
}

TEST(SceneClock, BeginsTheSceneAgainAtAnyTick) {
  SceneClock clock = with_commands_at({1, 2});
  for (int i = 0; i < 10; ++i) clock.advance();
  pop_all(clock);
  clock.restore({});
  EXPECT_EQ(clock.tick(), 10);
  EXPECT_EQ(clock.scene_tick(), 0);
  EXPECT_DOUBLE_EQ(clock.end_of_next_tick(), clock.dt());
  EXPECT_THAT(pop_all(clock), ElementsAre(0));
  clock.advance();
  EXPECT_THAT(pop_all(clock), ElementsAre(1));
}

TEST(SceneClock, RestoresASavedPlaceAtALaterTick) {
  SceneClock clock = with_commands_at({1, 3});
  pop_all(clock);
  clock.advance();
  const ScenePlace saved = clock.save();
  for (int i = 0; i < 5; ++i) clock.advance();
  pop_all(clock);
  clock.restore(saved);
  EXPECT_EQ(clock.tick(), 6);
  EXPECT_EQ(clock.scene_tick(), 1);
  EXPECT_THAT(pop_all(clock), IsEmpty());
  clock.advance();
  EXPECT_THAT(pop_all(clock), ElementsAre(1)) << "at the third tick of the scene";
}

}  // namespace
}  // namespace kerf::sheet
