#pragma once

#include "server/base/result.h"
#include "server/service/host/stored_run.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::durable {

// Reads all that the host needs to make a stored sheet again. Errors: kDataLoss if the scene or a change is damaged or
// of a kind that this version does not know, and those of SqliteStore::entries().
Result<host::StoredRun> read_run(store::SqliteStore& store, const store::StoredSheet& sheet);

}  // namespace kerf::durable
