#include "server/service/host/scene_changes.h"

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

sheet::CommandReply reply_to_reset_undone() {
  sheet::CommandReply reply;
  reply.undone.emplace();
  reply.undone->reset = true;
  return reply;
}

TEST(SceneChanges, AClientChangesTheSceneUntilItResetsIt) {
  SceneChanges changes;
  EXPECT_FALSE(changes.is_changed());
  changes.command_done(sheet::SetGravity{}, {});
  EXPECT_TRUE(changes.is_changed());
  changes.command_done(sheet::Reset{}, {});
  EXPECT_FALSE(changes.is_changed());
  EXPECT_EQ(changes.resets(), 1);
}

TEST(SceneChanges, CountsResetsThatAreUndoneAndRedone) {
  SceneChanges changes;
  changes.command_done(sheet::Reset{}, {});
  changes.command_done(sheet::UndoCut{}, reply_to_reset_undone());
  EXPECT_EQ(changes.resets_undone(), 1);
  EXPECT_TRUE(changes.is_changed());
  changes.command_done(sheet::RedoCut{}, reply_to_reset_undone());
  EXPECT_EQ(changes.resets(), 2);
  EXPECT_EQ(changes.resets_undone(), 1);
}

TEST(SceneChanges, UndoingACutIsNoReset) {
  SceneChanges changes;
  sheet::CommandReply reply;
  reply.undone.emplace();
  changes.command_done(sheet::UndoCut{}, reply);
  EXPECT_EQ(changes.resets_undone(), 0);
}

}  // namespace
}  // namespace kerf::host
