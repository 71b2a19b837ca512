#pragma once

#include <string>

#include "server/base/result.h"
#include "server/service/store/check_store.h"
#include "server/service/store/files.h"

namespace kerf::store {

// Checks a store that nothing uses, such as a backup, and copies it into a folder that is missing or empty. The folder
// has its name only once the copy is whole and synced. Returns what was copied. Errors: those of check_store(), also
// kDataLoss STORE_DAMAGED with the first fault, and those of BackupJob. Faults of quarantined sheets do not count: they
// are copied as they are, and are not recovered.
Result<StoreInfo> restore_store(const std::string& from, const std::string& to, Files& files = real_files(),
                                const std::string& vfs = {});

}  // namespace kerf::store
