#include "tests/store/lossy_vfs.h"

#include <atomic>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>
#include <utility>

namespace kerf::test {
namespace {

// An open file: what SQLite knows, then ours.
struct VfsFile {
  sqlite3_file base;
  LossyDisk* disk;
  std::string path;
  std::shared_ptr<LossyDisk::Node> node;
  bool is_log;
  bool syncs_folder;  // with its next sync
  bool is_temporary;
};

VfsFile& file_of(sqlite3_file* file) {
  return *reinterpret_cast<VfsFile*>(file);
}
LossyDisk& disk_of(sqlite3_vfs* vfs) {
  return *static_cast<LossyDisk*>(vfs->pAppData);
}
std::string folder_path(const std::string& path) {
  return path.substr(0, path.rfind('/'));
}

int code_of(LossyDisk::Outcome outcome, int failure) {
  if (outcome == LossyDisk::Outcome::kDone) return SQLITE_OK;
  return outcome == LossyDisk::Outcome::kFull ? SQLITE_FULL : failure;
}

int close_file(sqlite3_file* base) {
  VfsFile& file = file_of(base);
  if (file.is_temporary && !file.path.empty()) (void)file.disk->remove(file.path);
  file.~VfsFile();
  return SQLITE_OK;
}

int read_file(sqlite3_file* base, void* bytes, int count, sqlite3_int64 at) {
  VfsFile& file = file_of(base);
  const auto wanted = static_cast<std::size_t>(count);
  const std::size_t found =
      file.disk->read_at(*file.node, static_cast<std::size_t>(at), static_cast<char*>(bytes), wanted);
  if (found == wanted) return SQLITE_OK;
  std::memset(static_cast<char*>(bytes) + found, 0, wanted - found);
  return SQLITE_IOERR_SHORT_READ;
}

int write_file(sqlite3_file* base, const void* bytes, int count, sqlite3_int64 at) {
  VfsFile& file = file_of(base);
  const std::string_view written(static_cast<const char*>(bytes), static_cast<std::size_t>(count));
  return code_of(file.disk->write_at(*file.node, static_cast<std::size_t>(at), written), SQLITE_IOERR_WRITE);
}

int truncate_file(sqlite3_file* base, sqlite3_int64 length) {
  VfsFile& file = file_of(base);
  return code_of(file.disk->set_length(*file.node, static_cast<std::size_t>(length)), SQLITE_IOERR_TRUNCATE);
}

int sync_file(sqlite3_file* base, int) {
  VfsFile& file = file_of(base);
  const int code = code_of(file.disk->sync(*file.node, file.is_log), SQLITE_IOERR_FSYNC);
  if (code != SQLITE_OK || !std::exchange(file.syncs_folder, false)) return code;
  (void)file.disk->sync_folder(folder_path(file.path));
  return SQLITE_OK;
}

int file_size(sqlite3_file* base, sqlite3_int64* bytes) {
  *bytes = static_cast<sqlite3_int64>(file_of(base).disk->length(*file_of(base).node));
  return SQLITE_OK;
}

int ignore_lock(sqlite3_file*, int) {
  return SQLITE_OK;
}
int no_lock(sqlite3_file*, int* is_locked) {
  *is_locked = 0;
  return SQLITE_OK;
}
int no_control(sqlite3_file*, int, void*) {
  return SQLITE_NOTFOUND;
}
int sector_size(sqlite3_file*) {
  return 4096;
}
int characteristics(sqlite3_file*) {
  return SQLITE_IOCAP_POWERSAFE_OVERWRITE;
}

constexpr sqlite3_io_methods kMethods = {1,          close_file,  read_file,       write_file,  truncate_file,
                                         sync_file,  file_size,   ignore_lock,     ignore_lock, no_lock,
                                         no_control, sector_size, characteristics, nullptr,     nullptr,
                                         nullptr,    nullptr,     nullptr,         nullptr};

int open_file(sqlite3_vfs* vfs, const char* path, sqlite3_file* base, int flags, int* out_flags) {
  base->pMethods = nullptr;
  bool was_made = false;
  const std::string name = path == nullptr ? "" : path;
  auto node = disk_of(vfs).open(name, (flags & SQLITE_OPEN_CREATE) != 0, &was_made);
  if (node == nullptr) return SQLITE_CANTOPEN;
  const bool is_journal = (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_SUPER_JOURNAL)) != 0;
  new (base) VfsFile{{&kMethods},
                     &disk_of(vfs),
                     name,
                     std::move(node),
                     (flags & SQLITE_OPEN_WAL) != 0,
                     was_made && is_journal,
                     (flags & SQLITE_OPEN_DELETEONCLOSE) != 0};
  if (out_flags != nullptr) *out_flags = flags;
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs* vfs, const char* path, int syncs_folder) {
  LossyDisk& disk = disk_of(vfs);
  if (!disk.size(path).ok()) return SQLITE_IOERR_DELETE_NOENT;
  if (!disk.remove(path).ok()) return SQLITE_IOERR_DELETE;
  return syncs_folder == 0 || disk.sync_folder(folder_path(path)).ok() ? SQLITE_OK : SQLITE_IOERR_DIR_FSYNC;
}

int access_file(sqlite3_vfs* vfs, const char* path, int flags, int* is_there) {
  const auto bytes = disk_of(vfs).size(path);
  *is_there = bytes.ok() && (flags != SQLITE_ACCESS_EXISTS || *bytes > 0) ? 1 : 0;
  return SQLITE_OK;
}

int full_path(sqlite3_vfs*, const char* path, int bytes, char* out) {
  sqlite3_snprintf(bytes, out, "%s", path);
  return SQLITE_OK;
}
// Gives the same bytes always, so that a run can be repeated.
int same_bytes(sqlite3_vfs*, int count, char* out) {
  std::memset(out, 7, static_cast<std::size_t>(count));
  return count;
}
int no_sleep(sqlite3_vfs*, int us) {
  return us;
}
int no_time(sqlite3_vfs*, double* days) {
  *days = 2460000.5;
  return SQLITE_OK;
}

}  // namespace

LossyVfs::LossyVfs(LossyDisk& disk) {
  static std::atomic<int> number = 0;
  name_ = "lossy-" + std::to_string(++number);
  vfs_.iVersion = 1;
  vfs_.szOsFile = sizeof(VfsFile);
  vfs_.mxPathname = 512;
  vfs_.zName = name_.c_str();
  vfs_.pAppData = &disk;
  vfs_.xOpen = open_file;
  vfs_.xDelete = delete_file;
  vfs_.xAccess = access_file;
  vfs_.xFullPathname = full_path;
  vfs_.xRandomness = same_bytes;
  vfs_.xSleep = no_sleep;
  vfs_.xCurrentTime = no_time;
  sqlite3_vfs_register(&vfs_, 0);
}

LossyVfs::~LossyVfs() {
  sqlite3_vfs_unregister(&vfs_);
}

}  // namespace kerf::test
