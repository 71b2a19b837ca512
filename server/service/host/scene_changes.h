#pragma once

#include <cstdint>

#include "server/core/scene/command.h"

namespace kerf::host {

// Tracks changes of a sheet by its clients, and counts their resets. A plain value.
class SceneChanges {
 public:
  SceneChanges() = default;
  SceneChanges(bool is_changed, std::int32_t resets, std::int32_t resets_undone)
      : is_changed_(is_changed), resets_(resets), resets_undone_(resets_undone) {}

  // Records a client's command that was done.
  void command_done(const scene::Command& command, const scene::CommandReply& reply);

  // True if a client has changed the sheet since the last Reset by a client, or since its creation if there was none.
  [[nodiscard]] bool is_changed() const { return is_changed_; }
  [[nodiscard]] std::int32_t resets() const { return resets_; }  // Resets by clients, redone ones included.
  [[nodiscard]] std::int32_t resets_undone() const { return resets_undone_; }

 private:
  bool is_changed_ = false;
  std::int32_t resets_ = 0;
  std::int32_t resets_undone_ = 0;
};

}  // namespace kerf::host
