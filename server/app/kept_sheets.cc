#include "server/app/kept_sheets.h"

#include <utility>
#include <vector>

#include "server/app/wait_for.h"
#include "server/service/durable/stored_runs.h"
#include "server/service/host/host.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::app {

Result<std::set<std::string>> recover_sheets(store::SqliteStore& store, host::Host& host,
                                             const std::function<void(std::string_view line)>& note) {
  std::set<std::string> changed;
  KERF_TRY_ASSIGN(const std::vector<store::StoredSheet> sheets, store.sheets());
  for (const store::StoredSheet& stored : sheets) {
    const std::string name = "the kept sheet \"" + stored.id + "\"";
    if (stored.is_quarantined) {
      note(name + " is set aside: " + stored.reason);
      continue;
    }
    Result<host::StoredRun> run = durable::read_run(store, stored);
    if (!run.ok() && run.error().code == ErrorCode::kDataLoss) {
      KERF_TRY(store.quarantine(stored.sheet, run.error().message));
      note(name + " is damaged and set aside: " + run.error().message);
      continue;
    }
    KERF_TRY(run);
    const Result<host::RecoveredSheet> recovered = wait_for<host::RecoveredSheet>(
        [&](host::Callback<host::RecoveredSheet> done) { host.recover(std::move(*run), std::move(done)); });
    if (!recovered.ok()) {
      note(name + " is not started, and stays kept: " + recovered.error().message);
      continue;
    }
    if (recovered->differs_at) {
      note(name + " differs from what it was, from tick " + std::to_string(*recovered->differs_at) +
           " on: it was computed again, by another build or processor");
    }
    if (recovered->is_changed) changed.insert(stored.id);
  }
  return changed;
}

}  // namespace kerf::app
