#include "server/app/audit_file.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace kerf::app {
namespace {

Result<int> open_appending(const std::string& path) {
  // A pipe without a reader is an error at once, and a full one is tried again later.
  const int number = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NONBLOCK | O_CLOEXEC, 0600);
  if (number >= 0) return number;
  return invalid_argument("BAD_AUDIT_LOG",
                          "--audit-log: cannot append to \"" + path + "\": " + std::generic_category().message(errno),
                          "--audit-log");
}

// Returns true if the last line of a file has no end, as the process that wrote it was killed.
bool is_torn(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  std::ifstream file(path, std::ios::ate | std::ios::binary);
  if (!file || file.tellg() <= 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

}  // namespace

Result<std::unique_ptr<AuditFile>> AuditFile::open(const std::string& path, std::chrono::milliseconds retry) {
  KERF_TRY_ASSIGN(const int number, open_appending(path));
  auto file = std::unique_ptr<AuditFile>(new AuditFile(path, number, retry));
  if (is_torn(path)) file->append("\n");
  return file;
}

AuditFile::AuditFile(std::string path, int number, std::chrono::milliseconds retry)
    : path_(std::move(path)), retry_(retry), number_(number), thread_([this] { run(); }) {}

AuditFile::~AuditFile() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  changed_.notify_all();
  thread_.join();
  ::close(number_);
  if (next_number_) ::close(*next_number_);
}

bool AuditFile::append(std::string_view line) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() + line.size() > kMaxWaitingBytes) return false;
    waiting_ += line;
  }
  changed_.notify_all();
  return true;
}

Status AuditFile::reopen() {
  KERF_TRY_ASSIGN(const int number, open_appending(path_));
  const std::lock_guard lock(mutex_);
  if (next_number_) ::close(*next_number_);
  next_number_ = number;
  return Nothing{};
}

void AuditFile::flush() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.empty() && !is_writing_; });
}

void AuditFile::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_over_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    if (next_number_) ::close(std::exchange(number_, *std::exchange(next_number_, std::nullopt)));
    std::string lines = std::exchange(waiting_, {});
    is_writing_ = true;
    lock.unlock();
    const ssize_t written = ::write(number_, lines.data(), lines.size());
    lock.lock();
    is_writing_ = false;
    lines.erase(0, written > 0 ? static_cast<std::size_t>(written) : 0);
    waiting_.insert(0, lines);
    changed_.notify_all();
    if (lines.empty()) continue;
    if (is_over_) return;
    changed_.wait_for(lock, retry_, [this] { return is_over_; });
  }
}

}  // namespace kerf::app
