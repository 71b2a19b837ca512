#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/host/saved_run.h"

namespace kerf::host {

// Describes a saved state of a sheet.
struct SavedStateStatus {
  std::string id;
  std::int64_t tick = 0;        // Tick of the sheet when it was saved.
  std::int64_t scene_tick = 0;  // See sheet::Sheet::scene_tick().
  std::int32_t num_vertices = 0;
  std::int64_t num_bytes = 0;  // See SavedRun::num_bytes().
  std::uint64_t state_hash = 0;
  std::uint64_t continuation_hash = 0;
  std::int64_t saved_unix_us = 0;  // us since 1970
};

struct SavedState {
  SavedStateStatus status;
  std::shared_ptr<const scene::SheetConfig> config;  // The scene of its sheet.
  SavedRun run;
};

// Saves and loads what the owner of a host keeps of each sheet, such as its list of cuts. Called on the sheet's strand.
struct Attachments {
  std::function<std::string(const std::string& id)> save;  // Returns it as bytes.
  // Replaces it; no bytes: the sheet is new.
  std::function<void(const std::string& id, const std::string& bytes)> load;
};

// Keeps the saved states of all sheets of a host in memory, by sheet and by name. Thread-safe.
class SavedStates {
 public:
  // `max_per_sheet`: >= 1. `max_bytes`: limit on the bytes of all states together.
  SavedStates(std::int32_t max_per_sheet, std::int64_t max_bytes)
      : max_per_sheet_(max_per_sheet), max_bytes_(max_bytes) {}

  // Checks whether a state of this name may be added. kAlreadyExists STATE_EXISTS unless `overwrite`;
  // kResourceExhausted TOO_MANY_STATES.
  [[nodiscard]] Status check(const std::string& sheet, const std::string& id, bool overwrite) const;
  // Adds a state, or replaces the one of its name. Errors of check(); kResourceExhausted STATES_TOO_LARGE if the states
  // of the server would exceed `max_bytes`; errors of `check_sum`. A refusal changes nothing.
  // `tenant`: one whose states `check_sum` limits, by the bytes that they would take then; empty: none.
  using CheckSum = std::function<Status(std::int64_t bytes)>;
  Status add(const std::string& sheet, std::shared_ptr<const SavedState> state, bool overwrite,
             const std::string& tenant = {}, const CheckSum& check_sum = nullptr);
  // Returns the bytes of the states of all sheets of a tenant, see tenant_of().
  [[nodiscard]] std::int64_t bytes_of(const std::string& tenant) const;
  // kNotFound STATE_NOT_FOUND
  [[nodiscard]] Result<std::shared_ptr<const SavedState>> find(const std::string& sheet, const std::string& id) const;
  // Returns the states of a sheet, those saved first at first.
  [[nodiscard]] std::vector<SavedStateStatus> list(const std::string& sheet) const;
  // kNotFound STATE_NOT_FOUND
  Status remove(const std::string& sheet, const std::string& id);
  // Removes all states of a sheet.
  void forget(const std::string& sheet);

 private:
  using OfSheet = std::vector<std::shared_ptr<const SavedState>>;

  // These need mutex_ held.
  [[nodiscard]] Status check_locked(const OfSheet& states, const std::string& id, bool overwrite) const;
  [[nodiscard]] const OfSheet& of(const std::string& sheet) const;
  [[nodiscard]] std::int64_t bytes_locked(const std::string& tenant) const;

  const std::int32_t max_per_sheet_;
  const std::int64_t max_bytes_;
  mutable std::mutex mutex_;
  std::map<std::string, OfSheet> states_;  // In the order of saving. Guarded by mutex_.
  std::int64_t bytes_ = 0;                 // Sum of all states. Guarded by mutex_.
};

}  // namespace kerf::host
