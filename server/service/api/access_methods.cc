#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "kerf/v1/access_service.pb.h"
#include "kerf/v1/cuts.pb.h"
#include "server/core/scene/sheet_config.h"
#include "server/service/api/access.h"
#include "server/service/api/audit_log.h"
#include "server/service/api/core.h"
#include "server/service/api/tenants.h"
#include "server/service/auth/authenticator.h"
#include "server/service/auth/token_file.h"

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

// Returns a grant with the id of a token that was good once; of any other, nothing is known.
std::shared_ptr<const auth::Grant> known_part(std::string_view authorization, const Error& error) {
  if (error.reason != "TOKEN_EXPIRED") return auth::everybody().grant;
  const std::string_view token = authorization.substr(authorization.find(' ') + 1);
  return std::make_shared<const auth::Grant>(std::string(auth::id_in(token)), auth::Rights(), nullptr);
}

std::string request_id_of(const google::protobuf::Message& request) {
  const auto* const field = request.GetDescriptor()->FindFieldByName("request_id");
  return field == nullptr ? std::string() : request.GetReflection()->GetString(request, field);
}

// Counts a call that cuts, and checks whether the tenant has vertices left for it.
Status count_for_tenant(const ApiCore& core, const auth::Caller& caller, const google::protobuf::Message& request) {
  const std::string& tenant = caller->rights().tenant;
  if (core.options.tenants == nullptr || tenant.empty()) return Nothing{};
  const std::string call = call_of(request);
  const bool cuts = call == "CreateCut" || call == "CreateCuts" || call == "RedoCut" || call == "UndoCut";
  if (cuts) KERF_TRY(core.options.tenants->take_cut(tenant));
  if (!cuts && call != "RestoreState") return Nothing{};
  if (call == "UndoCut") return Nothing{};  // It may give vertices back.
  const std::optional<host::TenantLimits> limits = core.options.tenants->sheet_limits(tenant);
  return limits ? host::check_vertices(tenant, *limits, core.host.tenant_use(tenant).vertices + 1) : Status(Nothing{});
}

void add_quotas(const ApiCore& core, v1::Access& access) {
  if (core.options.tenants == nullptr) return;
  const std::optional<Tenants::Use> calls = core.options.tenants->use_of(access.tenant());
  if (!calls) return;
  const host::TenantUse sheets = core.host.tenant_use(access.tenant());
  const auth::TenantLimits& limits = calls->limits;
  const auto add = [&access](const char* name, double used, double limit) {
    v1::Quota& quota = *access.add_quotas();
    quota.set_name(name);
    quota.set_used(used);
    quota.set_limit(limit);
  };
  constexpr double kMiB = 1 << 20;
  add("sheets", sheets.sheets, limits.max_sheets);
  add("vertices", static_cast<double>(sheets.vertices), static_cast<double>(limits.max_vertices));
  add("state-mib", static_cast<double>(sheets.state_bytes) / kMiB, static_cast<double>(limits.max_state_bytes) / kMiB);
  add("workers", sheets.workers, limits.max_workers);
  add("streams", calls->streams, limits.max_streams);
  add("image-streams", calls->image_streams, limits.max_image_streams);
  add("cuts-per-s", 0.0, limits.max_cuts_per_s);
}

}  // namespace

void record(const ApiCore& core, const auth::Caller& caller, const std::string& call, const std::string& sheet,
            const std::string& request_id, const Status& outcome) {
  if (core.options.audit != nullptr) core.options.audit->add({caller, call, sheet, request_id}, outcome);
  // Leaves out sheets that are gone, or never were: what is kept of them would stay. A link changes no sheet.
  const bool is_shown = outcome.ok() && !sheet.empty() && call != "CreateLink" && core.host.has_sheet(sheet);
  if (is_shown) core.audience->add(sheet, caller, call);
}

Result<std::shared_ptr<const void>> open_stream(const ApiCore& core, const auth::Caller& caller, bool pictures) {
  if (core.options.tenants == nullptr) return std::shared_ptr<const void>();
  return core.options.tenants->open_stream(caller->rights().tenant,
                                           pictures ? Tenants::Stream::kPictures : Tenants::Stream::kFrames);
}

Result<auth::Caller> Api::caller_of(std::string_view authorization, std::string address) const {
  auth::Authenticator* const authenticator = core_->options.authenticator;
  Result<auth::Caller> caller =
      authenticator == nullptr ? auth::everybody() : authenticator->find_bearer(authorization);
  if (caller.ok()) {
    caller->address = std::move(address);
  } else if (caller.error().reason != "TOKEN_MISSING") {
    record({known_part(authorization, caller.error()), std::move(address)}, "Authorize", caller.error());
  }
  return caller;
}

std::string Api::address_of(std::string peer, std::string_view forwarded_for) const {
  constexpr std::size_t kLongestAddress = 45;  // of IPv6 with an address of IPv4 in it
  const bool is_named = core_->options.is_behind_proxy && !forwarded_for.empty();
  return is_named && forwarded_for.size() <= kLongestAddress ? std::string(forwarded_for) : std::move(peer);
}

Status Api::allow(const auth::Caller& caller, const google::protobuf::Message& request) const {
  Status allowed = check_access(caller, request);
  if (allowed.ok()) allowed = count_for_tenant(*core_, caller, request);
  if (!allowed.ok() && is_recorded(request)) recorder(caller, request)(allowed, {});
  return allowed;
}

Recorder Api::recorder(const auth::Caller& caller, const google::protobuf::Message& request) const {
  if (!is_recorded(request)) return nullptr;
  return [core = core_, caller, call = call_of(request), named = sheets_of(request),
          request_id = request_id_of(request)](const Status& outcome, const std::string& sheet) {
    for (const std::string& id : named) {
      api::record(*core, caller, call, id.empty() ? sheet : id, request_id, outcome);
    }
  };
}

void Api::record(const auth::Caller& caller, const std::string& call, const Status& outcome) const {
  api::record(*core_, caller, call, {}, {}, outcome);
}

Status outcome_of(const v1::CutResult& result) {
  if (result.status() != v1::CutResult::NO_INTERSECTION) return Nothing{};
  return failed_precondition("NO_INTERSECTION", "the cut missed the sheet, or retraced an earlier one");
}
Status outcome_of(const v1::CreateCutsResponse& result) {
  if (result.status() != v1::CutResult::NO_INTERSECTION) return Nothing{};
  return failed_precondition("NO_INTERSECTION", "the cuts missed the sheet, or retraced earlier ones");
}

std::string id_of(const v1::Sheet& sheet) {
  const Result<std::string> id = parse_sheet_name(sheet.name(), "name");
  return id.ok() ? *id : std::string();
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
  access.set_by_link(caller->is_by_link());
  access.set_tenant(caller->rights().tenant);
  add_quotas(*core_, access);
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
