#pragma once

#include <cstdint>
#include <string>

#include "server/service/store/files.h"
#include "server/service/store/sql.h"

namespace kerf::store {

inline constexpr std::int64_t kApplicationId = 0x4b455246;  // "KERF", in the header of the database
inline constexpr std::int64_t kSchemaVersion = 1;

// Paths below the folder of a store.
inline std::string database_path(const std::string& folder) {
  return folder + "/kerf.db";
}
inline std::string lock_path(const std::string& folder) {
  return folder + "/lock";
}
inline std::string reserve_path(const std::string& folder) {
  return folder + "/reserve";
}
inline std::string states_path(const std::string& folder) {
  return folder + "/states";
}
inline std::string damaged_path(const std::string& folder) {
  return folder + "/damaged";
}

// Opens the database of a store for reading and writing, and makes it if there is none. Every page is looked at.
// Errors: kFailedPrecondition STORE_FOREIGN or STORE_NEWER, kDataLoss STORE_DAMAGED; the file is then as it was.
Result<Database> open_database(Files& files, const std::string& folder, const std::string& vfs);

// Opens the database of a store that nothing uses, for reading alone. A log stays, which closing the last connection
// would move into the database. Errors: kNotFound STORE_NOT_FOUND; kDataLoss STORE_DAMAGED if it was never wholly made;
// those of check_schema().
Result<Database> open_to_read(Files& files, const std::string& folder, const std::string& vfs);

// Checks that the tables are those of this version. Errors as above; kNotFound STORE_EMPTY if there are no tables.
Status check_schema(Database& database);

}  // namespace kerf::store
