#include "server/core/sheet/moving_sheet.h"

#include <gtest/gtest.h>

#include "tests/sheet/moving_parts.h"

namespace kerf::sheet {
namespace {

void advance(MovingSheet& sheet, int ticks) {
  for (int i = 1; i <= ticks; ++i) {
    sheet.set_loads(i / sheet.config().tick_rate_hz);
    sheet.step({}, {});
  }
}

TEST(MovingSheet, ContinuesBitForBitFromASavedState) {
  MovingSheet sheet = moving_sheet_of(scenes::hanging(9));
  advance(sheet, 5);
  const MovingState saved = sheet.save();
  advance(sheet, 5);
  const std::uint64_t later = hash_of(sheet);
  sheet.restore(saved);
  advance(sheet, 5);
  EXPECT_EQ(hash_of(sheet), later);
}

TEST(MovingSheet, RestoresItsInitialStateWithoutGrabs) {
  MovingSheet sheet = moving_sheet_of(scenes::hanging(9));
  const std::uint64_t first = hash_of(sheet);
  ASSERT_TRUE(sheet.grab({"hand", mesh::VertexId{4}, {}, 0.0}).ok());
  sheet.set_gravity({0.0, 0.0, -1.0});
  ASSERT_TRUE(sheet.set_pins({}).ok());
  advance(sheet, 3);
  sheet.restore(sheet.initial_state());
  sheet.refresh_conditions();
  EXPECT_EQ(hash_of(sheet), first);
}

TEST(MovingSheet, RefusedMaterialChangesNothing) {
  MovingSheet sheet = moving_sheet_of(scenes::hanging(9));
  const std::uint64_t before = hash_of(sheet);
  scene::SetMaterial change{scenes::demo_material(), 3};
  EXPECT_EQ(sheet.set_material(change).error().reason, "UNKNOWN_PART");
  EXPECT_EQ(hash_of(sheet), before);
}

}  // namespace
}  // namespace kerf::sheet
