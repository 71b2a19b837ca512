#include "server/app/audit_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace kerf::app {
namespace {

Result<int> open_appending(const std::string& path) {
  const int number = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
  if (number >= 0) return number;
  return invalid_argument("BAD_AUDIT_LOG",
                          "--audit-log: cannot append to \"" + path + "\": " + std::generic_category().message(errno),
                          "--audit-log");
}

}  // namespace

Result<std::unique_ptr<AuditFile>> AuditFile::open(const std::string& path) {
  KERF_TRY_ASSIGN(const int number, open_appending(path));
  return std::unique_ptr<AuditFile>(new AuditFile(path, number));
}

AuditFile::~AuditFile() {
  ::close(number_);
}

bool AuditFile::append(std::string_view line) {
  const std::lock_guard lock(mutex_);
  const std::string text = (is_torn_ ? "\n" : "") + std::string(line);
  const ssize_t written = ::write(number_, text.data(), text.size());
  if (written == static_cast<ssize_t>(text.size())) {
    is_torn_ = false;
    return true;
  }
  if (written > 0) is_torn_ = true;
  return false;
}

Status AuditFile::reopen() {
  KERF_TRY_ASSIGN(const int number, open_appending(path_));
  const std::lock_guard lock(mutex_);
  ::close(std::exchange(number_, number));
  is_torn_ = false;
  return Nothing{};
}

}  // namespace kerf::app
