#pragma once

#include <string>

#include "server/base/result.h"
#include "server/service/store/check_store.h"
#include "server/service/store/files.h"

namespace kerf::store {

// Checks a store that nothing uses, such as a backup, and copies it into a folder that is missing or empty. The folder
// has its name only once the copy is whole and synced. What is damaged in single sheets is copied as it is, without
// states that cannot be read. Returns what was copied, with the faults. Errors: those of check_store(), also kDataLoss
// STORE_DAMAGED with the first fault if no server could open the copy, and those of BackupJob.
Result<StoreReport> restore_store(const std::string& from, const std::string& to, Files& files = real_files(),
                                  const std::string& vfs = {});

}  // namespace kerf::store
