#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/base/disk.h"
#include "server/base/result.h"

namespace kerf::store {

// Holds a lock on a file until it is destroyed.
class FileLock {
 public:
  virtual ~FileLock() = default;
};

// Does what a store does with files other than its database. Errors are those of Disk, with the path in the message.
// Nothing that changes a folder survives a loss of power before sync_folder().
class Files {
 public:
  virtual ~Files() = default;
  // Makes a folder that only its owner may enter, and those around it, if they are missing, and syncs the folder around
  // each.
  virtual Status make_folder(const std::string& path) = 0;
  // Locks a file and writes the id of this process into it. Error kFailedPrecondition STORE_IN_USE, with the id of the
  // process that has the lock.
  virtual Result<std::unique_ptr<FileLock>> lock(const std::string& path) = 0;
  // Returns the bytes of a file, or kNotFound FILE_NOT_FOUND.
  virtual Result<std::int64_t> size(const std::string& path) = 0;
  // Returns false for a file that this process may not write, as on a disk that can only be read.
  virtual bool is_writable(const std::string& path) = 0;
  // Returns the names of a folder's files in order. A folder that is missing has none.
  virtual Result<std::vector<std::string>> list(const std::string& folder) = 0;
  // Returns the content of the whole file. Error FILE_TOO_LARGE if the file has more than `max_bytes`.
  virtual Result<std::string> read(const std::string& path, std::size_t max_bytes) = 0;
  // Creates a file for appending, or empties an existing one.
  virtual Result<std::unique_ptr<AppendFile>> create(const std::string& path) = 0;
  // Gives a file another name, in place of any file that has it.
  virtual Status rename(const std::string& from, const std::string& to) = 0;
  // Gives a folder with all it has another name, which no folder has or one that is empty, and syncs the folder around
  // it.
  virtual Status rename_folder(const std::string& from, const std::string& to) = 0;
  // Removes a folder with all it has, or does nothing if there is none.
  virtual Status remove_folder(const std::string& path) = 0;
  // Removes a file, or does nothing if there is none.
  virtual Status remove(const std::string& path) = 0;
  // Makes a file whose `bytes` are taken from the disk, and syncs it.
  virtual Status reserve(const std::string& path, std::int64_t bytes) = 0;
  virtual Status sync_file(const std::string& path) = 0;
  virtual Status sync_folder(const std::string& path) = 0;
};

// Returns the machine's file system. Thread-safe.
Files& real_files();

}  // namespace kerf::store
