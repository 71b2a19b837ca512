#include "server/service/store/files.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kerf::store {
namespace {

Error file_error(const std::string& action, const std::string& path, int code) {
  const std::string message = "cannot " + action + " \"" + path + "\": " + std::generic_category().message(code);
  if (code == ENOENT) return not_found("FILE_NOT_FOUND", message);
  if (code == ENOSPC || code == EDQUOT) return resource_exhausted("DISK_FULL", message);
  return unavailable("FILE_IO", message);
}

// Owns a descriptor, which may be that of no file.
class OpenFile : public FileLock {
 public:
  OpenFile(const std::string& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~OpenFile() override {
    if (number_ >= 0) ::close(number_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

std::string process_of(int lock) {
  char digits[24] = {};
  const ssize_t count = ::pread(lock, digits, sizeof digits - 1, 0);
  const std::string text(digits, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  return text.substr(0, text.find_first_not_of("0123456789"));
}

Status sync_path(const std::string& path, int flags) {
  const OpenFile file(path, O_RDONLY | flags);
  if (!file.is_open() || ::fsync(file.number()) != 0) return file_error("sync", path, errno);
  return Nothing{};
}

std::string folder_around(const std::string& path) {
  const std::string parent = std::filesystem::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

int make_one_folder(const std::string& path) {
  return ::mkdir(path.c_str(), 0700) == 0 ? 0 : errno;
}

class RealFiles : public Files {
 public:
  Status make_folder(const std::string& path) override {
    int failure = make_one_folder(path);
    if (failure == ENOENT) {
      KERF_TRY(make_folder(folder_around(path)));
      failure = make_one_folder(path);
    }
    if (failure == EEXIST) {
      std::error_code broken;
      if (std::filesystem::is_directory(path, broken)) return Nothing{};
      failure = ENOTDIR;
    }
    if (failure != 0) return file_error("make the folder", path, failure);
    return sync_folder(folder_around(path));
  }
  Result<std::unique_ptr<FileLock>> lock(const std::string& path) override {
    auto file = std::make_unique<OpenFile>(path, O_RDWR | O_CREAT);
    if (!file->is_open()) return file_error("open", path, errno);
    if (::flock(file->number(), LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return file_error("lock", path, errno);
      const std::string folder = std::filesystem::path(path).parent_path().string();
      return failed_precondition("STORE_IN_USE", "the store in \"" + folder + "\" is used by process " +
                                                     process_of(file->number()) + "; end that, or take another folder");
    }
    const std::string text = std::to_string(::getpid()) + "\n";
    if (::ftruncate(file->number(), 0) != 0 || ::pwrite(file->number(), text.data(), text.size(), 0) < 0) {
      // The lock holds without the number, which a full disk may have no room for.
      if (errno != ENOSPC && errno != EDQUOT) return file_error("write", path, errno);
    }
    return std::unique_ptr<FileLock>(std::move(file));
  }
  Result<std::int64_t> size(const std::string& path) override {
    struct stat about {};
    if (::stat(path.c_str(), &about) != 0) return file_error("look at", path, errno);
    return static_cast<std::int64_t>(about.st_size);
  }
  bool is_writable(const std::string& path) override { return ::access(path.c_str(), W_OK) == 0; }
  Result<std::vector<std::string>> list(const std::string& folder) override {
    std::vector<std::string> names;
    std::error_code broken;
    std::filesystem::directory_iterator at(folder, broken);
    if (broken == std::errc::no_such_file_or_directory) return names;
    for (; !broken && at != std::filesystem::directory_iterator(); at.increment(broken)) {
      names.push_back(at->path().filename().string());
    }
    if (broken) return file_error("list", folder, broken.value());
    std::sort(names.begin(), names.end());
    return names;
  }
  Result<std::string> read(const std::string& path, std::size_t max_bytes) override {
    return disk_.read_file(path, max_bytes);
  }
  Result<std::unique_ptr<AppendFile>> create(const std::string& path) override { return disk_.create_file(path); }
  Status rename(const std::string& from, const std::string& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0) return file_error("rename", from, errno);
    return Nothing{};
  }
  Status rename_folder(const std::string& from, const std::string& to) override {
    KERF_TRY(rename(from, to));
    return sync_folder(folder_around(to));
  }
  Status remove_folder(const std::string& path) override {
    std::error_code broken;
    std::filesystem::remove_all(path, broken);
    if (broken) return file_error("remove", path, broken.value());
    return Nothing{};
  }
  Status remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) return file_error("remove", path, errno);
    return Nothing{};
  }
  Status reserve(const std::string& path, std::int64_t bytes) override {
    const OpenFile file(path, O_RDWR | O_CREAT);
    if (!file.is_open()) return file_error("create", path, errno);
    if (const int code = ::posix_fallocate(file.number(), 0, bytes); code != 0) {
      ::unlink(path.c_str());  // what it has taken so far is of use to others
      return file_error("reserve", path, code);
    }
    if (::fsync(file.number()) != 0) return file_error("sync", path, errno);
    return Nothing{};
  }
  Status sync_file(const std::string& path) override { return sync_path(path, 0); }
  Status sync_folder(const std::string& path) override { return sync_path(path, O_DIRECTORY); }

 private:
  RealDisk disk_;
};

}  // namespace

Files& real_files() {
  static RealFiles files;
  return files;
}

}  // namespace kerf::store
