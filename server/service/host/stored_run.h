#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/scene/sheet_config.h"
#include "server/service/host/saved_states.h"
#include "server/service/host/sheet_event.h"
#include "server/service/host/sheet_status.h"

namespace kerf::host {

// All that a journal has of a sheet, from which the sheet is made again.
struct StoredRun {
  struct Change {
    std::int64_t tick = 0;  // Sheet::tick() after it.
    std::uint64_t state_hash = 0;
    SheetEvent event;
  };

  std::int64_t sheet = 0;  // Number of the sheet in the store.
  std::string id;
  std::int64_t created_unix_us = 0;  // us since 1970
  scene::SheetConfig config;
  std::optional<SavedState> state;  // The sheet is loaded from it; else it is made from its scene.
  std::vector<SavedState> named;    // States that users have saved.
  std::vector<Change> changes;      // After `state`.
  std::int64_t last_seq = 0;        // Number of the last change; 0: there is none.
  std::int64_t mark_tick = 0;       // The sheet is stepped up to this tick.
};

// A sheet that was made again.
struct RecoveredSheet {
  SheetStatus status;
  // A client has changed it since it was made or reset, has saved states of it or scheduled commands, or lets it run
  // otherwise: paused, or at another speed.
  bool is_changed = false;
  // Tick of the first change after which the sheet differs from the stored hash.
  std::optional<std::int64_t> differs_at;
};

}  // namespace kerf::host
