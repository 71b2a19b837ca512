#include "server/service/durable/stored_runs.h"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include "server/service/durable/change_codec.h"
#include "server/service/durable/state_codec.h"

namespace kerf::durable {

namespace {

Result<host::SavedState> read_state(store::SqliteStore& store, const store::StateInfo& info) {
  KERF_TRY_ASSIGN(const host::StoredState stored, store.read_state(info.sheet, info.seq, info.name));
  return decode_state(stored.content);
}

// Reads the newest state that is whole, and those that users have saved.
void read_states(store::SqliteStore& store, const store::StoredSheet& sheet, Beginning beginning,
                 host::StoredRun& run) {
  for (const store::StateInfo& info : sheet.states) {
    if (info.name.empty() && (run.state || beginning == Beginning::kScene)) continue;
    Result<host::SavedState> state = read_state(store, info);
    if (!state.ok()) continue;
    if (!info.name.empty()) {
      run.named.push_back(std::move(*state));
    } else {
      run.last_seq = info.seq;
      run.mark_tick = state->status.tick;
      run.state = std::move(*state);
    }
  }
}

// True if the state of a restore was stored, whole or not: the restore was then answered.
bool has_state_from(const store::StoredSheet& sheet, std::int64_t seq) {
  return sheet.num_damaged_states > 0 ||
         std::any_of(sheet.states.begin(), sheet.states.end(),
                     [seq](const store::StateInfo& info) { return info.name.empty() && info.seq >= seq; });
}

}  // namespace

Result<host::StoredRun> read_run(store::SqliteStore& store, const store::StoredSheet& sheet, Beginning beginning) {
  if (sheet.is_damaged) return data_loss("STORED_SHEET_DAMAGED", "its row in the store is damaged");
  host::StoredRun run;
  run.sheet = sheet.sheet;
  run.id = sheet.id;
  run.created_unix_us = sheet.created_unix_us;
  KERF_TRY_ASSIGN(run.config, decode_stored_scene(sheet.scene));
  read_states(store, sheet, beginning, run);
  KERF_TRY_ASSIGN(const std::vector<host::JournalEntry> entries, store.entries(sheet.sheet, run.last_seq));
  for (const host::JournalEntry& entry : entries) {
    KERF_TRY_ASSIGN(host::SheetEvent event, decode_change(entry.content));
    if (std::holds_alternative<host::RestoreEvent>(event)) {
      if (has_state_from(sheet, entry.seq)) {
        return data_loss("STATE_DAMAGED",
                         "the state that change " + std::to_string(entry.seq) + " restored is damaged");
      }
      // It and what follows was neither answered nor shown.
      KERF_TRY(store.remove_entries_after(sheet.sheet, entry.seq - 1));
      return run;
    }
    run.changes.push_back({entry.tick, entry.state_hash, std::move(event)});
    run.last_seq = entry.seq;
    run.mark_tick = entry.tick;
  }
  const auto is_later = [&run](const store::StateInfo& info) { return info.seq > run.last_seq; };
  if (std::any_of(sheet.states.begin(), sheet.states.end(), is_later)) {
    return data_loss("JOURNAL_DAMAGED", "changes before its newest state are gone");
  }
  run.mark_tick = std::max(run.mark_tick, sheet.mark.value_or(0));
  return run;
}

}  // namespace kerf::durable
