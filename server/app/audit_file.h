#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "server/base/result.h"

namespace kerf::app {

// A file that lines are appended to, by a thread of its own: a slow disk delays no caller. Lines that a full disk has
// no room for wait, and are tried again after `retry`. A process that is killed loses lines that wait. Thread-safe.
class AuditFile {
 public:
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{4} << 20;

  // Opens a file, or makes one that only its owner may read. Error kInvalidArgument BAD_AUDIT_LOG.
  static Result<std::unique_ptr<AuditFile>> open(const std::string& path,
                                                 std::chrono::milliseconds retry = std::chrono::seconds(1));
  // Writes what waits, once more.
  ~AuditFile();
  AuditFile(const AuditFile&) = delete;
  AuditFile& operator=(const AuditFile&) = delete;

  // Appends a line, which ends with "\n". Returns false if kMaxWaitingBytes wait already; the line is then left out.
  bool append(std::string_view line);
  // Opens the file of that path once more, as the one before may have been renamed. Lines that wait go there. If it
  // cannot be opened, the one before stays.
  Status reopen();
  // Waits until nothing waits to be written.
  void flush();

 private:
  AuditFile(std::string path, int number, std::chrono::milliseconds retry);
  void run();

  const std::string path_;
  const std::chrono::milliseconds retry_;
  std::mutex mutex_;  // Guards the members below, except the thread.
  std::condition_variable changed_;
  std::string waiting_;  // Lines, the first one perhaps without its beginning.
  int number_;           // Used by the thread; others replace it through `next_number_`.
  std::optional<int> next_number_;
  bool is_writing_ = false;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace kerf::app
