#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "server/base/disk.h"
#include "server/base/result.h"

namespace kerf::test {

// Keeps files in memory, for tests and simulation. A limited capacity makes the disk run full.
class MemoryDisk : public Disk {
 public:
  explicit MemoryDisk(std::size_t capacity_bytes = std::size_t{1} << 30U);
  // Sets the capacity. If it is below the bytes in use, all writes fail.
  void set_capacity(std::size_t bytes);
  Result<std::string> read_file(const std::string& path, std::size_t max_bytes) override;
  Status write_file(const std::string& path, std::string_view content) override;
  Result<std::unique_ptr<AppendFile>> create_file(const std::string& path) override;

 private:
  // Shared with the open files, which may outlive the disk.
  struct Content {
    std::mutex mutex;
    std::size_t capacity_bytes = 0;
    std::size_t used_bytes = 0;
    std::map<std::string, std::string> files;
  };
  class MemoryFile;

  std::shared_ptr<Content> content_;
};

}  // namespace kerf::test
