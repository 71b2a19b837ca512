#include "server/service/host/scene_changes.h"

#include <variant>

namespace kerf::host {

void SceneChanges::command_done(const sheet::Command& command, const sheet::CommandReply& reply) {
  const bool is_reset = std::holds_alternative<sheet::Reset>(command);
  is_changed_ = !is_reset;
  if (is_reset) ++resets_;
  if (!reply.undone || !reply.undone->reset) return;
  ++(std::holds_alternative<sheet::RedoCut>(command) ? resets_ : resets_undone_);
}

}  // namespace kerf::host
