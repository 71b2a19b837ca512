#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf {

// A file that only grows.
class AppendFile {
 public:
  virtual ~AppendFile() = default;
  // Appends all of `bytes` or none. If a part remains after an error, the next append removes it before it writes.
  virtual Status append(std::string_view bytes) = 0;
  // Makes everything appended so far survive a loss of power.
  virtual Status sync() = 0;
};

// Reads and writes files, for the whole server. Paths are paths of the operating system. Errors: kNotFound
// FILE_NOT_FOUND, kResourceExhausted FILE_TOO_LARGE or DISK_FULL, kUnavailable FILE_IO, with the path in the message.
// Thread-safe.
class Disk {
 public:
  virtual ~Disk() = default;
  // Returns the content of the whole file. Error FILE_TOO_LARGE if the file has more than `max_bytes`.
  virtual Result<std::string> read_file(const std::string& path, std::size_t max_bytes) = 0;
  // Replaces the whole file at once: after a crash it has the old content or the new one, never a mixture. The new
  // content is written to a second file, synced and renamed. Devices and pipes are written in place.
  virtual Status write_file(const std::string& path, std::string_view content) = 0;
  // Creates a file for appending, or empties an existing one.
  virtual Result<std::unique_ptr<AppendFile>> create_file(const std::string& path) = 0;
};

// The machine's file system.
class RealDisk : public Disk {
 public:
  Result<std::string> read_file(const std::string& path, std::size_t max_bytes) override;
  Status write_file(const std::string& path, std::string_view content) override;
  Result<std::unique_ptr<AppendFile>> create_file(const std::string& path) override;
};

}  // namespace kerf
