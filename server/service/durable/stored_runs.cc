#include "server/service/durable/stored_runs.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/service/durable/change_codec.h"

namespace kerf::durable {

Result<host::StoredRun> read_run(store::SqliteStore& store, const store::StoredSheet& sheet) {
  if (sheet.is_damaged) return data_loss("STORED_SHEET_DAMAGED", "its row in the store is damaged");
  host::StoredRun run;
  run.sheet = sheet.sheet;
  run.id = sheet.id;
  run.created_unix_us = sheet.created_unix_us;
  KERF_TRY_ASSIGN(run.config, decode_stored_scene(sheet.scene));
  KERF_TRY_ASSIGN(const std::vector<host::JournalEntry> entries, store.entries(sheet.sheet, 0));
  for (const host::JournalEntry& entry : entries) {
    KERF_TRY_ASSIGN(host::SheetEvent event, decode_change(entry.content));
    run.changes.push_back({entry.tick, entry.state_hash, std::move(event)});
    run.last_seq = entry.seq;
    run.mark_tick = entry.tick;
  }
  run.mark_tick = std::max(run.mark_tick, sheet.mark.value_or(0));
  return run;
}

}  // namespace kerf::durable
