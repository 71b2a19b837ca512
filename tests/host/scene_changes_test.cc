#include "server/service/host/scene_changes.h"

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

scene::CommandReply reply_to_reset_undone() {
  scene::CommandReply reply;
  reply.undone.emplace();
  reply.undone->reset = true;
  return reply;
}

TEST(SceneChanges, AClientChangesTheSceneUntilItResetsIt) {
  SceneChanges changes;
  EXPECT_FALSE(changes.is_changed());
  changes.command_done(scene::SetGravity{}, {});
  EXPECT_TRUE(changes.is_changed());
  changes.command_done(scene::Reset{}, {});
  EXPECT_FALSE(changes.is_changed());
  EXPECT_EQ(changes.resets(), 1);
}

TEST(SceneChanges, CountsResetsThatAreUndoneAndRedone) {
  SceneChanges changes;
  changes.command_done(scene::Reset{}, {});
  changes.command_done(scene::UndoCut{}, reply_to_reset_undone());
  EXPECT_EQ(changes.resets_undone(), 1);
  EXPECT_TRUE(changes.is_changed());
  changes.command_done(scene::RedoCut{}, reply_to_reset_undone());
  EXPECT_EQ(changes.resets(), 2);
  EXPECT_EQ(changes.resets_undone(), 1);
}

TEST(SceneChanges, UndoingACutIsNoReset) {
  SceneChanges changes;
  scene::CommandReply reply;
  reply.undone.emplace();
  changes.command_done(scene::UndoCut{}, reply);
  EXPECT_EQ(changes.resets_undone(), 0);
}

}  // namespace
}  // namespace kerf::host
