#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "server/app/audit_file.h"
#include "server/base/disk.h"
#include "server/base/result.h"
#include "server/service/api/audit_log.h"
#include "server/service/api/tenants.h"
#include "server/service/auth/authenticator.h"
#include "server/service/host/clock.h"

namespace kerf::app {

// Holds who may do what on a server, and the record of what was done.
class AccessControl {
 public:
  // `disk` and `clock` must outlive this.
  AccessControl(Disk& disk, host::Clock& clock) : disk_(disk), clock_(clock), tenants_(clock) {}

  // Reads the token file and opens the audit log; an empty path: there is none. Errors: those of read_token_file() and
  // AuditFile::open().
  Status start(const std::filesystem::path& token_file, const std::filesystem::path& audit_log);
  // Reads the token file again, and opens the audit log again. `note`: for the operator. Returns true if the rights of
  // callers may be others now.
  bool reload(const std::function<void(std::string_view)>& note);

  [[nodiscard]] auth::Authenticator* authenticator() const { return authenticator_.get(); }  // Null without tokens.
  [[nodiscard]] api::Tenants& tenants() { return tenants_; }
  [[nodiscard]] api::AuditLog* audit() const { return audit_.get(); }  // Null without an audit log.

 private:
  Status read_tokens();

  Disk& disk_;
  host::Clock& clock_;
  std::filesystem::path token_file_;
  std::unique_ptr<auth::Authenticator> authenticator_;
  api::Tenants tenants_;
  std::unique_ptr<AuditFile> file_;
  std::unique_ptr<api::AuditLog> audit_;
};

}  // namespace kerf::app
