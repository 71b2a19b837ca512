#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <sqlite3.h>

#include "server/base/result.h"

namespace kerf::store {

// Owns a connection to a database of SQLite. Errors of this file: kResourceExhausted STORAGE_FULL, kDataLoss
// STORE_DAMAGED, kUnavailable STORE_IO.
class Database {
 public:
  // Opens or makes a database. `vfs` is the name of a virtual file system of SQLite; empty: the machine's.
  static Result<Database> open(const std::string& path, const std::string& vfs);
  // Opens one that nothing changes, on a disk that can only be read. Its log must be empty.
  static Result<Database> open_unwritable(const std::string& path);
  Database(Database&& other) noexcept;
  Database& operator=(Database&&) = delete;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  // Runs statements that give no rows.
  Status execute(const std::string& sql);
  // Returns the first column of the first row.
  Result<std::int64_t> number(const char* sql);
  Result<std::string> text(const char* sql);
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  // Describes the last error of the connection.
  [[nodiscard]] Error error(int code, std::string_view action) const;

 private:
  explicit Database(sqlite3* handle) : handle_(handle) {}

  sqlite3* handle_;
};

// Bytes that are no text.
struct Blob {
  std::string_view bytes;
};

// A statement that was compiled once. Columns and parameters are taken in order.
class Statement {
 public:
  static Result<Statement> prepare(Database& database, std::string_view sql);
  Statement(Statement&& other) noexcept;
  Statement& operator=(Statement&&) = delete;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  // Begins once more, with these parameters. Texts and blobs must stay until the last row was read.
  template <typename... Values>
  void begin(const Values&... values) {
    sqlite3_reset(handle_);
    int index = 0;
    (bind(++index, values), ...);
  }
  // Runs the statement to its end.
  template <typename... Values>
  Status run(const Values&... values) {
    begin(values...);
    const Result<bool> row = step();
    sqlite3_reset(handle_);
    if (!row.ok()) return row.error();
    return Nothing{};
  }
  // Goes to the next row. Returns false after the last.
  Result<bool> step();
  [[nodiscard]] std::int64_t integer(int column) const { return sqlite3_column_int64(handle_, column); }
  // Returns a text or a blob, which is valid until the next step.
  [[nodiscard]] std::string_view bytes(int column) const;

 private:
  Statement(Database& database, sqlite3_stmt* handle) : database_(database.handle()), handle_(handle) {}
  void bind(int index, std::int64_t value) { sqlite3_bind_int64(handle_, index, value); }
  void bind(int index, std::string_view text);
  void bind(int index, Blob blob);

  sqlite3* database_;
  sqlite3_stmt* handle_;
};

}  // namespace kerf::store
