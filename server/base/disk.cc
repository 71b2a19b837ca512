#include "server/base/disk.h"

#include <cerrno>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kerf {

namespace {

Error io_error(const std::string& action, const std::string& path, int code) {
  const std::string message = "cannot " + action + " \"" + path + "\": " + std::generic_category().message(code);
  if (code == ENOENT) return not_found("FILE_NOT_FOUND", message);
  if (code == ENOSPC || code == EDQUOT) return resource_exhausted("DISK_FULL", message);
  if (code == EFBIG) return resource_exhausted("FILE_TOO_LARGE", message);  // for example because of ulimit -f
  return unavailable("FILE_IO", message);
}

// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }

 private:
  int number_;
};

Status write_all(int file, std::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return io_error("write", path, errno);
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return Nothing{};
}

// Syncs the directory of `path`, so that a new name in it survives a loss of power.
Status sync_directory_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string directory = slash == std::string::npos ? "." : path.substr(0, slash == 0 ? 1 : slash);
  const Descriptor file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!file.is_open() || ::fsync(file.number()) != 0) return io_error("sync", directory, errno);
  return Nothing{};
}

class RealFile : public AppendFile {
 public:
  RealFile(int number, std::string path) : file_(number), path_(std::move(path)) {}
  Status append(std::string_view bytes) override {
    KERF_TRY(drop_partial());
    const Status written = write_all(file_.number(), bytes, path_);
    is_partial_ = !written.ok();
    if (written.ok()) {
      size_ += static_cast<off_t>(bytes.size());
    } else {
      (void)drop_partial();  // if this fails too, the next append tries again
    }
    return written;
  }
  Status sync() override {
    if (::fdatasync(file_.number()) != 0) return io_error("sync", path_, errno);
    return Nothing{};
  }

 private:
  // Removes the part that a failed append has written.
  Status drop_partial() {
    if (is_partial_ && ::ftruncate(file_.number(), size_) != 0) return io_error("shorten", path_, errno);
    is_partial_ = false;
    return Nothing{};
  }

  Descriptor file_;
  std::string path_;
  off_t size_ = 0;  // bytes of all appends that succeeded
  bool is_partial_ = false;
};

}  // namespace

Result<std::string> RealDisk::read_file(const std::string& path, std::size_t max_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return io_error("open", path, errno);
  std::string content;
  char buffer[1 << 16];
  while (true) {
    const ssize_t count = ::read(file.number(), buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return io_error("read", path, errno);
    if (count == 0) return content;
    if (content.size() + static_cast<std::size_t>(count) > max_bytes) {
      return resource_exhausted("FILE_TOO_LARGE",
                                "\"" + path + "\" has more than " + std::to_string(max_bytes) + " bytes, the limit");
    }
    content.append(buffer, static_cast<std::size_t>(count));
  }
}

Status RealDisk::write_file(const std::string& named, std::string_view content) {
  // Writes to the target of a symbolic link, so that the link stays one.
  std::error_code broken;
  const std::filesystem::path meant =
      std::filesystem::is_symlink(named) ? std::filesystem::canonical(named, broken) : std::filesystem::path(named);
  if (broken) return io_error("follow", named, broken.value());
  const std::string path = meant.string();
  struct stat about {};
  if (::stat(path.c_str(), &about) == 0 && !S_ISREG(about.st_mode)) {  // rename() would put a file in place of a device
                                                                       // or pipe
    Descriptor device(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (!device.is_open()) return io_error("open", path, errno);
    return write_all(device.number(), content, path);
  }
  const std::string beside = path + ".new";
  Descriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file.is_open()) return io_error("create", beside, errno);
  Status written = write_all(file.number(), content, beside);
  if (written.ok() && ::fsync(file.number()) != 0) written = io_error("sync", beside, errno);
  file.close();
  if (written.ok() && ::rename(beside.c_str(), path.c_str()) != 0) written = io_error("rename", beside, errno);
  if (!written.ok()) {
    ::unlink(beside.c_str());
    return written;
  }
  return sync_directory_of(path);
}

Result<std::unique_ptr<AppendFile>> RealDisk::create_file(const std::string& path) {
  const int number = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (number < 0) return io_error("create", path, errno);
  return std::unique_ptr<AppendFile>(std::make_unique<RealFile>(number, path));
}

}  // namespace kerf
