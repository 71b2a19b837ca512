#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/store/files.h"
#include "server/service/store/tables.h"

namespace kerf::store {

// A state that cannot be read any more, as its file is gone or changed, or its row.
struct DamagedState {
  std::string reason;
  std::string kept_file;  // Path of the file now; empty: it is gone, or stays where it is.
};

// Compares the states of a sheet with their sums, and removes the rows of those that are damaged. Their files are moved
// to the folder `damaged` of the store. A state whose file cannot be read at present stays. Errors: those of Tables and
// Files.
Result<std::vector<DamagedState>> set_damaged_states_aside(Tables& tables, Files& files, const std::string& folder,
                                                           std::int64_t sheet);

}  // namespace kerf::store
