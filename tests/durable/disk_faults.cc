// Preloaded into kerfd, makes the disk below a folder hang or fail while a control file says so. KERF_FAULT_FOLDER and
// KERF_FAULT_CONTROL are absolute paths. The file has one word: "hang", "full" (files cannot grow), "no-write" or
// "no-sync" (both EIO). Without the file, everything works.

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace {

enum class Fault { kNone, kHang, kFull, kNoWrite, kNoSync };

template <typename Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

const char* setting(const char* name) {
  static const char* const folder = std::getenv("KERF_FAULT_FOLDER");
  static const char* const control = std::getenv("KERF_FAULT_CONTROL");
  return std::strcmp(name, "folder") == 0 ? folder : control;
}

Fault read_fault() {
  const int file = open(setting("control"), O_RDONLY | O_CLOEXEC);
  if (file < 0) return Fault::kNone;
  char word[16] = {};
  const ssize_t count = read(file, word, sizeof word);
  close(file);
  const std::string_view read(word, count < 0 ? 0 : static_cast<std::size_t>(count));
  if (read == "hang") return Fault::kHang;
  if (read == "full") return Fault::kFull;
  if (read == "no-write") return Fault::kNoWrite;
  return read == "no-sync" ? Fault::kNoSync : Fault::kNone;
}

bool is_below_folder(int file) {
  const std::string_view folder = setting("folder");
  char link[32] = "/proc/self/fd/";
  char digits[12] = {};
  char* end = digits + sizeof digits - 1;
  for (int rest = file; end == digits + sizeof digits - 1 || rest > 0; rest /= 10) {
    *--end = static_cast<char>('0' + rest % 10);
  }
  std::strcat(link, end);
  char path[4096];
  const ssize_t count = readlink(link, path, sizeof path);
  return count > 0 && std::string_view(path, static_cast<std::size_t>(count)).substr(0, folder.size()) == folder;
}

// Waits while the disk hangs. Returns what is wrong with it after that.
Fault fault_of(int file) {
  const int code = errno;
  Fault fault = read_fault();
  if (fault != Fault::kNone && !is_below_folder(file)) fault = Fault::kNone;
  while (fault == Fault::kHang) {
    usleep(2000);
    fault = read_fault();
  }
  errno = code;
  return fault;
}

// Returns the error of a write that ends at this place, or 0.
int write_error(int file, off_t end) {
  const Fault fault = fault_of(file);
  if (fault == Fault::kNoWrite) return EIO;
  struct stat about {};
  return fault == Fault::kFull && fstat(file, &about) == 0 && end > about.st_size ? ENOSPC : 0;
}

template <typename Result, typename Work>
Result unless(int error, const Work& work) {
  if (error == 0) return work();
  errno = error;
  return static_cast<Result>(-1);
}

int synced(int file, const char* name) {
  return unless<int>(fault_of(file) == Fault::kNoSync ? EIO : 0, [&] { return real<int(int)>(name)(file); });
}

ssize_t written_at(int file, const void* bytes, std::size_t count, off_t at) {
  return unless<ssize_t>(write_error(file, at + static_cast<off_t>(count)), [&] {
    return real<ssize_t(int, const void*, std::size_t, off_t)>("pwrite64")(file, bytes, count, at);
  });
}

}  // namespace

extern "C" {

ssize_t write(int file, const void* bytes, std::size_t count) {
  const auto end = [&] { return lseek(file, 0, SEEK_CUR) + static_cast<off_t>(count); };
  const int code = errno;
  const off_t place = end();  // fails for sockets, which are not below the folder
  errno = code;
  return unless<ssize_t>(write_error(file, place),
                         [&] { return real<ssize_t(int, const void*, std::size_t)>("write")(file, bytes, count); });
}

ssize_t pwrite(int file, const void* bytes, std::size_t count, off_t at) {
  return written_at(file, bytes, count, at);
}

ssize_t pwrite64(int file, const void* bytes, std::size_t count, off_t at) {
  return written_at(file, bytes, count, at);
}

int posix_fallocate(int file, off_t at, off_t count) {
  const int error = write_error(file, at + count);
  return error != 0 ? error : real<int(int, off_t, off_t)>("posix_fallocate")(file, at, count);
}

int fsync(int file) {
  return synced(file, "fsync");
}

int fdatasync(int file) {
  return synced(file, "fdatasync");
}
}
