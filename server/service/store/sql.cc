#include "server/service/store/sql.h"

#include <cerrno>
#include <utility>

namespace kerf::store {
namespace {

Error sql_error(sqlite3* database, int code, std::string_view action) {
  std::string message = "cannot " + std::string(action) + " the store";
  const char* const path = sqlite3_db_filename(database, "main");
  if (path != nullptr) message += " \"" + std::string(path) + "\"";
  message += ": " + std::string(sqlite3_errmsg(database)) + " (SQLite " +
             std::to_string(sqlite3_extended_errcode(database)) + ")";
  const bool over_quota = code == SQLITE_IOERR_WRITE && sqlite3_system_errno(database) == EDQUOT;
  switch (code & 0xff) {
    case SQLITE_FULL:
      return resource_exhausted("STORAGE_FULL", message);
    case SQLITE_BUSY:
      return failed_precondition("STORE_IN_USE", message +
                                                     "; another process uses it, although it does not hold the "
                                                     "file `lock`; end that, or take another folder");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return data_loss("STORE_DAMAGED", message);
    default:
      return over_quota ? resource_exhausted("STORAGE_FULL", message) : unavailable("STORE_IO", message);
  }
}

}  // namespace

Result<Database> Database::open(const std::string& path, const std::string& vfs) {
  sqlite3* handle = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  const int code = sqlite3_open_v2(path.c_str(), &handle, flags, vfs.empty() ? nullptr : vfs.c_str());
  if (handle == nullptr) return unavailable("OUT_OF_MEMORY", "too little memory to open the store");
  Database database(handle);
  if (code != SQLITE_OK) return database.error(code, "open");
  return database;
}

Result<Database> Database::open_unwritable(const std::string& path) {
  // A path in a URI: these letters mean something else there.
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      uri += c == '%' ? "%25" : c == '?' ? "%3f" : "%23";
    } else {
      uri += c;
    }
  }
  sqlite3* handle = nullptr;
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  const int code = sqlite3_open_v2((uri + "?immutable=1").c_str(), &handle, flags, nullptr);
  if (handle == nullptr) return unavailable("OUT_OF_MEMORY", "too little memory to open the store");
  Database database(handle);
  if (code != SQLITE_OK) return database.error(code, "open");
  return database;
}

Database::Database(Database&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}

Database::~Database() {
  sqlite3_close_v2(handle_);
}

Error Database::error(int code, std::string_view action) const {
  return sql_error(handle_, code, action);
}

Status Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return error(code, "change");
  return Nothing{};
}

Result<std::int64_t> Database::number(const char* sql) {
  KERF_TRY_ASSIGN(Statement statement, Statement::prepare(*this, sql));
  KERF_TRY_ASSIGN(const bool is_row, statement.step());
  return is_row ? statement.integer(0) : 0;
}

Result<std::string> Database::text(const char* sql) {
  KERF_TRY_ASSIGN(Statement statement, Statement::prepare(*this, sql));
  KERF_TRY_ASSIGN(const bool is_row, statement.step());
  return is_row ? std::string(statement.bytes(0)) : std::string();
}

Result<Statement> Statement::prepare(Database& database, std::string_view sql) {
  sqlite3_stmt* handle = nullptr;
  const int code = sqlite3_prepare_v3(database.handle(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &handle, nullptr);
  // A statement that does not fit the tables means that these are not as they were made.
  if (code == SQLITE_ERROR) return data_loss("STORE_DAMAGED", database.error(code, "read").message);
  if (code != SQLITE_OK) return database.error(code, "read");
  return Statement(database, handle);
}

Statement::Statement(Statement&& other) noexcept
    : database_(other.database_), handle_(std::exchange(other.handle_, nullptr)) {}

Statement::~Statement() {
  sqlite3_finalize(handle_);
}

Result<bool> Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return sql_error(database_, code, sqlite3_stmt_readonly(handle_) != 0 ? "read" : "write");
}

std::string_view Statement::bytes(int column) const {
  const void* const first = sqlite3_column_blob(handle_, column);
  if (first == nullptr) return {};
  return {static_cast<const char*>(first), static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))};
}

// Empty values are no NULL, which a pointer of none would be.
void Statement::bind(int index, std::string_view text) {
  sqlite3_bind_text64(handle_, index, text.empty() ? "" : text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
}

void Statement::bind(int index, Blob blob) {
  sqlite3_bind_blob64(handle_, index, blob.bytes.empty() ? "" : blob.bytes.data(), blob.bytes.size(), SQLITE_STATIC);
}

}  // namespace kerf::store
