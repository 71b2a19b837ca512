#pragma once

#include "server/base/result.h"
#include "server/service/host/stored_run.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::durable {

// The beginning of a stored sheet that is made again.
enum class Beginning {
  kNewestState,  // its newest state that is whole, or its scene if there is none
  kScene,        // its scene, if the store has all changes since
};

// Reads all that the host needs to make a stored sheet again. Errors: kDataLoss if the scene or a change is damaged,
// missing or of a kind that this version does not know, and those of SqliteStore::entries().
Result<host::StoredRun> read_run(store::SqliteStore& store, const store::StoredSheet& sheet,
                                 Beginning beginning = Beginning::kNewestState);

}  // namespace kerf::durable
