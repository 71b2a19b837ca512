#include "server/base/disk.h"

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/memory_disk.h"
#include "tests/support/temporary_folder.h"

namespace kerf::host {
namespace {

// Both disks keep the same promises.
void check_disk(Disk& disk, const std::string& folder) {
  const std::string path = folder + "file";
  EXPECT_EQ(disk.read_file(path, 10).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(disk.write_file(path, "first").ok());
  ASSERT_TRUE(disk.write_file(path, "second").ok());
  EXPECT_EQ(disk.read_file(path, 6).value(), "second");
  EXPECT_EQ(disk.read_file(path, 5).error().reason, "FILE_TOO_LARGE");
  Result<std::unique_ptr<AppendFile>> file = disk.create_file(path);
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->append("a").ok());
  ASSERT_TRUE((*file)->append(std::string("\0b", 2)).ok());
  ASSERT_TRUE((*file)->sync().ok());
  EXPECT_EQ(disk.read_file(path, 10).value(), std::string("a\0b", 3));
}

TEST(Disk, MemoryDisk) {
  test::MemoryDisk disk;
  check_disk(disk, "");
}

TEST(Disk, RealDisk) {
  const test::TemporaryFolder empty;
  const std::string folder = empty.path().string() + "/";
  RealDisk disk;
  check_disk(disk, folder);
  EXPECT_EQ(disk.write_file(folder + "no/such/folder", "x").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(disk.create_file(folder).ok());
  EXPECT_FALSE(std::filesystem::exists(folder + "file.new"));

  std::filesystem::create_symlink(folder + "file", folder + "link");
  ASSERT_TRUE(disk.write_file(folder + "link", "through the link").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder + "link"));
  EXPECT_EQ(disk.read_file(folder + "file", 100).value(), "through the link");
  std::filesystem::create_symlink("/dev/full", folder + "device");
  EXPECT_EQ(disk.write_file(folder + "device", "x").error().reason, "DISK_FULL");
  EXPECT_TRUE(std::filesystem::is_symlink(folder + "device"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(Disk, AMemoryDiskRunsFullWithoutLosingWhatWasThere) {
  test::MemoryDisk disk(10);
  ASSERT_TRUE(disk.write_file("a", "12345").ok());
  EXPECT_EQ(disk.write_file("b", "123456").error().reason, "DISK_FULL");
  EXPECT_FALSE(disk.read_file("b", 10).ok());
  EXPECT_EQ(disk.write_file("a", "123456").error().reason, "DISK_FULL");
  EXPECT_EQ(disk.read_file("a", 10).value(), "12345");
  Result<std::unique_ptr<AppendFile>> file = disk.create_file("c");
  ASSERT_TRUE(file.ok());
  EXPECT_TRUE((*file)->append("12345").ok());
  EXPECT_EQ((*file)->append("1").error().reason, "DISK_FULL");
  disk.set_capacity(11);
  EXPECT_TRUE((*file)->append("6").ok());
  EXPECT_EQ(disk.read_file("c", 10).value(), "123456");
}

// Limits how long files may become, in this process, for as long as it lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    EXPECT_EQ(::getrlimit(RLIMIT_FSIZE, &before_), 0);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    before_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    EXPECT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, before_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*before_handler_)(int) = nullptr;
};

TEST(Disk, AFailedAppendLeavesNoPart) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "file";
  RealDisk disk;
  Result<std::unique_ptr<AppendFile>> file = disk.create_file(path);
  ASSERT_TRUE(file.ok());
  ASSERT_TRUE((*file)->append("12345678").ok());
  {
    const FileSizeLimit limit(10);
    EXPECT_EQ((*file)->append("abcd").error().reason, "FILE_TOO_LARGE");
    EXPECT_EQ(disk.read_file(path, 100).value(), "12345678");
    EXPECT_TRUE((*file)->append("9").ok());
  }
  EXPECT_TRUE((*file)->append("abcd").ok());
  EXPECT_EQ(disk.read_file(path, 100).value(), "123456789abcd");
}

}  // namespace
}  // namespace kerf::host
