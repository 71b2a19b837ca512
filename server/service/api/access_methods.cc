#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "kerf/v1/access_service.pb.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/api/core.h"
#include "server/service/auth/authenticator.h"

// Implements the methods of AccessService, and finds out who calls.
namespace kerf::api {
namespace {

constexpr std::int64_t kLeastLifetime = 60;
constexpr std::int64_t kMostLifetime = std::int64_t{7} * 86'400;
constexpr std::int64_t kUsualLifetime = std::int64_t{8} * 3600;

v1::Scope encode_scope(auth::Scope scope) {
  return static_cast<v1::Scope>(scope);  // They have the same numbers.
}

Result<auth::Rights> decode_rights(const v1::CreateLinkRequest& request, const auth::Caller& caller, std::int64_t now) {
  auth::Rights rights = caller->rights();
  if (!v1::Scope_IsValid(request.scope())) {
    return invalid_argument("OUT_OF_RANGE", "scope must be SCOPE_VIEW, SCOPE_CUT or SCOPE_ADMIN", "scope");
  }
  rights.scope =
      request.scope() == v1::SCOPE_UNSPECIFIED ? auth::Scope::kView : static_cast<auth::Scope>(request.scope());
  if (rights.scope > caller->rights().scope) {
    return permission_denied(
        "SCOPE_TOO_LOW",
        "a link gives no more than its maker has: " + std::string(auth::name_of(caller->rights().scope)), "scope");
  }
  if (!request.sheet_id().empty()) {
    if (!scene::is_valid_sheet_id(request.sheet_id()) || !rights.reaches(request.sheet_id())) {
      return invalid_argument("LINK_SHEET", "sheet_id must be the id of a sheet that you reach", "sheet_id");
    }
    rights.sheets = request.sheet_id();
  }
  const std::int64_t lifetime = request.lifetime_s() == 0 ? kUsualLifetime : request.lifetime_s();
  if (lifetime < kLeastLifetime || lifetime > kMostLifetime) {
    return invalid_argument("LINK_LIFETIME",
                            "lifetime_s is " + std::to_string(lifetime) + "; must be 60 to 604800, or 0 for 28800",
                            "lifetime_s");
  }
  rights.until_unix_s = now + lifetime;
  if (const std::int64_t end = caller->ends_at(); end != 0) rights.until_unix_s = std::min(rights.until_unix_s, end);
  return rights;
}

}  // namespace

Result<auth::Caller> Api::caller_of(std::string_view authorization) const {
  auth::Authenticator* const authenticator = core_->options.authenticator;
  return authenticator == nullptr ? auth::everybody() : authenticator->find_bearer(authorization);
}

auth::Authenticator* Api::authenticator() const {
  return core_->options.authenticator;
}

void Api::check_callers() {
  core_->streams.check_callers();
}

v1::Access Api::describe(const auth::Caller& caller) const {
  v1::Access access;
  access.set_asks_for_tokens(core_->options.authenticator != nullptr);
  access.set_token_id(caller->token_id());
  access.set_scope(encode_scope(caller->rights().scope));
  access.set_sheets(caller->rights().sheets);
  access.set_expires_unix_s(caller->ends_at());
  return access;
}

void Api::get_access(const v1::GetAccessRequest& /*request*/, const auth::Caller& caller, Reply<v1::Access> reply) {
  if (core_->stopping) return reply(server_stopping());
  reply(describe(caller));
}

void Api::create_link(const v1::CreateLinkRequest& request, const auth::Caller& caller, Reply<v1::AccessLink> reply) {
  if (core_->stopping) return reply(server_stopping());
  auth::Authenticator* const authenticator = core_->options.authenticator;
  if (authenticator == nullptr) {
    return reply(
        failed_precondition("NO_TOKENS", "this server asks for no tokens, so the viewer's plain address is enough"));
  }
  const Result<auth::Rights> rights = decode_rights(request, caller, authenticator->now());
  if (!rights.ok()) return reply(rights.error());
  const Result<std::string> code = authenticator->logins().make_link(caller, {*rights, request.once()});
  if (!code.ok()) return reply(code.error());
  v1::AccessLink link;
  link.set_code(*code);
  link.set_path("/" + (request.sheet_id().empty() ? "" : "?sheet=" + request.sheet_id()) + "#code=" + *code);
  link.set_expires_unix_s(rights->until_unix_s);
  reply(std::move(link));
}

}  // namespace kerf::api
