#include "server/app/access_control.h"

#include <utility>

#include "server/app/certificates.h"

namespace kerf::app {

Status AccessControl::start(const std::filesystem::path& token_file, const std::filesystem::path& audit_log) {
  if (!token_file.empty()) {
    token_file_ = token_file;
    authenticator_ = std::make_unique<auth::Authenticator>([this] { return clock_.unix_us() / 1'000'000; });
    KERF_TRY(read_tokens());
  }
  if (audit_log.empty()) return Nothing{};
  KERF_TRY_ASSIGN(file_, AuditFile::open(audit_log.string()));
  audit_ = std::make_unique<api::AuditLog>([this](std::string_view line) { return file_->append(line); }, clock_);
  return Nothing{};
}

Status AccessControl::read_tokens() {
  KERF_TRY_ASSIGN(auth::TokenFile read, read_token_file(token_file_, disk_));
  tenants_.set(read.tenants);
  authenticator_->set_tokens(std::move(read.tokens));
  return Nothing{};
}

bool AccessControl::reload(const std::function<void(std::string_view)>& note) {
  if (file_) {
    const Status opened = file_->reopen();
    note(opened.ok() ? "the audit log was opened again" : opened.error().message + "; lines go where they went before");
  }
  if (!authenticator_) return false;
  const Status read = read_tokens();
  note(read.ok() ? "the token file was read again" : read.error().message + "; the tokens stay as they were");
  return read.ok();
}

}  // namespace kerf::app
