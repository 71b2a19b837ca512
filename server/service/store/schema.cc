#include "server/service/store/schema.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kerf::store {
namespace {

// Short columns come before long ones, so that looking for them does not read these.
constexpr std::array kTables = {
    "CREATE TABLE journal(sheet INTEGER NOT NULL, seq INTEGER NOT NULL, tick INTEGER NOT NULL, hash INTEGER NOT NULL, "
    "crc INTEGER NOT NULL, content BLOB NOT NULL, PRIMARY KEY(sheet, seq)) WITHOUT ROWID",
    "CREATE TABLE marks(id INTEGER PRIMARY KEY, crc INTEGER NOT NULL, packed BLOB NOT NULL)",
    // In the order of their writing, which touches fewest pages. Nothing looks for a key: the host knows those it
    // keeps.
    "CREATE TABLE requests(number INTEGER PRIMARY KEY, body_hash INTEGER NOT NULL, sheet INTEGER NOT NULL, "
    "seq INTEGER NOT NULL, at INTEGER NOT NULL, crc INTEGER NOT NULL, key TEXT NOT NULL, reply BLOB NOT NULL)",
    "CREATE TABLE sheets(sheet INTEGER PRIMARY KEY, state INTEGER NOT NULL, created INTEGER NOT NULL, "
    "crc INTEGER NOT NULL, id TEXT NOT NULL, reason TEXT NOT NULL, scene BLOB NOT NULL)",
    "CREATE TABLE states(sheet INTEGER NOT NULL, seq INTEGER NOT NULL, name TEXT NOT NULL, number INTEGER NOT NULL, "
    "tick INTEGER NOT NULL, engine INTEGER NOT NULL, state_hash INTEGER NOT NULL, continuation_hash INTEGER NOT NULL, "
    "bytes INTEGER NOT NULL, content_sum INTEGER NOT NULL, crc INTEGER NOT NULL, PRIMARY KEY(sheet, seq, name)) "
    "WITHOUT ROWID",
};

constexpr const char* kRestoreABackup = "restore a backup into a new folder (kerfd --restore-store BACKUP --data DIR)";

Error foreign(const std::string& path) {
  return failed_precondition("STORE_FOREIGN", "\"" + path +
                                                  "\" is no store of Kerf, or its first page is damaged; it was not "
                                                  "changed. Take another folder, or " +
                                                  kRestoreABackup);
}

Error damaged(const std::string& path, const std::string& how) {
  return data_loss("STORE_DAMAGED", "\"" + path + "\" is damaged: " + how + ". It was not changed; " + kRestoreABackup);
}

std::string path_of(const Database& database) {
  return sqlite3_db_filename(database.handle(), "main");
}

// Finds remains of a store whose database is gone: SQLite would make a new one and delete its log.
Status check_remains(Files& files, const std::string& folder) {
  const std::string path = database_path(folder);
  const Result<std::int64_t> bytes = files.size(path);
  if (bytes.ok() && *bytes > 0) return Nothing{};
  if (!bytes.ok() && bytes.error().code != ErrorCode::kNotFound) return bytes.error();
  const Result<std::int64_t> log = files.size(path + "-wal");
  KERF_TRY_ASSIGN(const std::vector<std::string> states, files.list(states_path(folder)));
  if ((log.ok() && *log > 0) || !states.empty())
    return damaged(path, "it is empty or gone, while its log or states are there");
  return Nothing{};
}

Status make_tables(Database& database) {
  std::string sql = "BEGIN IMMEDIATE;";
  for (const char* const table : kTables) sql += std::string(table) + ";";
  sql += "PRAGMA application_id = " + std::to_string(kApplicationId) + ";";
  sql += "PRAGMA user_version = " + std::to_string(kSchemaVersion) + ";COMMIT;";
  return database.execute(sql);
}

Status prepare(Database& database) {
  // A refused file stays as it is: closing it does not move its log into it.
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  KERF_TRY(
      database.execute("PRAGMA locking_mode = EXCLUSIVE; PRAGMA trusted_schema = OFF; "
                       "PRAGMA cell_size_check = ON; PRAGMA temp_store = MEMORY"));
  Status schema = check_schema(database);
  const bool is_new = !schema.ok() && schema.error().reason == "STORE_EMPTY";
  if (!schema.ok() && !is_new) return schema;
  if (!is_new) {
    KERF_TRY_ASSIGN(const std::string found, database.text("PRAGMA quick_check(1)"));
    if (found != "ok") return damaged(path_of(database), found);
  }
  KERF_TRY_ASSIGN(const std::string mode, database.text("PRAGMA journal_mode = WAL"));
  if (mode != "wal") return unavailable("STORE_IO", "\"" + path_of(database) + "\" takes no write-ahead log");
  KERF_TRY(database.execute("PRAGMA synchronous = FULL; PRAGMA wal_autocheckpoint = 0"));
  if (is_new) KERF_TRY(make_tables(database));
  // After a sync that failed, the log of the last process may be readable and yet not on the disk. Later entries must
  // not depend on it.
  KERF_TRY(database.execute("PRAGMA wal_checkpoint(TRUNCATE)"));
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, nullptr);
  return Nothing{};
}

}  // namespace

Status check_schema(Database& database) {
  const std::string path = path_of(database);
  const Result<std::int64_t> application = database.number("PRAGMA application_id");
  if (!application.ok()) return application.error().code == ErrorCode::kDataLoss ? foreign(path) : application.error();
  std::vector<std::string> found;
  KERF_TRY_ASSIGN(Statement tables,
                  Statement::prepare(database, "SELECT sql FROM sqlite_schema WHERE sql IS NOT NULL"));
  while (true) {
    KERF_TRY_ASSIGN(const bool is_row, tables.step());
    if (!is_row) break;
    found.emplace_back(tables.bytes(0));
  }
  if (*application == 0 && found.empty())
    return not_found("STORE_EMPTY", "\"" + path + "\" is empty: no sheet was ever kept there");
  if (*application != kApplicationId) return foreign(path);
  KERF_TRY_ASSIGN(const std::int64_t version, database.number("PRAGMA user_version"));
  if (version > kSchemaVersion) {
    return failed_precondition("STORE_NEWER", "\"" + path + "\" has format " + std::to_string(version) +
                                                  ", made by a newer Kerf; this one reads up to " +
                                                  std::to_string(kSchemaVersion));
  }
  if (version < 1 || !std::is_permutation(found.begin(), found.end(), kTables.begin(), kTables.end())) {
    return damaged(path, "its tables are not those of format " + std::to_string(version));
  }
  return Nothing{};
}

Result<Database> open_to_read(Files& files, const std::string& folder, const std::string& vfs) {
  const std::string path = database_path(folder);
  const Result<std::int64_t> bytes = files.size(path);
  const Status remains = check_remains(files, folder);
  if (!remains.ok() && remains.error().code == ErrorCode::kDataLoss) return remains.error();
  if (!bytes.ok()) {
    return not_found("STORE_NOT_FOUND", "there is no store in \"" + folder + "\" (" + bytes.error().message +
                                            "); name the folder of --data, or a backup, such as DATA/backups/ID");
  }
  const Result<std::int64_t> journal = files.size(path + "-journal");
  if (journal.ok() && *journal > 0) {
    return data_loss("STORE_DAMAGED", "\"" + folder + "\" was never wholly made: its creation was interrupted");
  }
  const Result<std::int64_t> log = files.size(path + "-wal");
  const bool has_log = log.ok();
  const bool is_writable = files.is_writable(path);
  if (!is_writable && has_log && *log > 0) {
    return failed_precondition("STORE_UNWRITABLE", "\"" + folder +
                                                       "\" cannot be written, and its log has to be moved into its "
                                                       "database: copy the folder to where it can be");
  }
  KERF_TRY_ASSIGN(Database database, is_writable ? Database::open(path, vfs) : Database::open_unwritable(path));
  if (has_log) sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  KERF_TRY(
      database.execute("PRAGMA locking_mode = EXCLUSIVE; PRAGMA query_only = ON; PRAGMA cell_size_check = ON; "
                       "PRAGMA temp_store = MEMORY"));
  KERF_TRY(check_schema(database));
  return database;
}

Result<Database> open_database(Files& files, const std::string& folder, const std::string& vfs) {
  KERF_TRY(check_remains(files, folder));
  KERF_TRY_ASSIGN(Database database, Database::open(database_path(folder), vfs));
  KERF_TRY(prepare(database));
  // Turning the log on removes a journal, which an unsynced folder may bring back after a loss of power: the store
  // would then be empty.
  KERF_TRY(files.sync_folder(folder));
  return database;
}

}  // namespace kerf::store
