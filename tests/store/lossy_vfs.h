#pragma once

#include <string>

#include <sqlite3.h>

#include "tests/store/lossy_disk.h"

namespace kerf::test {

// Lets SQLite use a LossyDisk, as it uses a disk on Unix: a new log or journal syncs its folder with its first sync.
class LossyVfs {
 public:
  explicit LossyVfs(LossyDisk& disk);
  ~LossyVfs();
  LossyVfs(const LossyVfs&) = delete;
  LossyVfs& operator=(const LossyVfs&) = delete;

  // For StoreOptions::vfs.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
  sqlite3_vfs vfs_{};
};

}  // namespace kerf::test
