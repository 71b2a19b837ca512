#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::app {

// A file that lines are appended to. Thread-safe.
class AuditFile {
 public:
  // Opens a file, or makes one that only its owner may read. Error kInvalidArgument BAD_AUDIT_LOG.
  static Result<std::unique_ptr<AuditFile>> open(const std::string& path);
  ~AuditFile();
  AuditFile(const AuditFile&) = delete;
  AuditFile& operator=(const AuditFile&) = delete;

  // Appends a line, which ends with "\n". Returns false if it is not there as a whole.
  bool append(std::string_view line);
  // Opens the file of that path once more, as the one before may have been renamed. If that fails, the one before
  // stays.
  Status reopen();

 private:
  AuditFile(std::string path, int number) : path_(std::move(path)), number_(number) {}

  const std::string path_;
  std::mutex mutex_;
  int number_;            // guarded by mutex_
  bool is_torn_ = false;  // The last line has no end; guarded by mutex_.
};

}  // namespace kerf::app
