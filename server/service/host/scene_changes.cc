#include "server/service/host/scene_changes.h"

#include <variant>

namespace kerf::host {

void SceneChanges::command_done(const scene::Command& command, const scene::CommandReply& reply) {
  const bool is_reset = std::holds_alternative<scene::Reset>(command);
  is_changed_ = !is_reset;
  if (is_reset) ++resets_;
  if (!reply.undone || !reply.undone->reset) return;
  ++(std::holds_alternative<scene::RedoCut>(command) ? resets_ : resets_undone_);
}

}  // namespace kerf::host
