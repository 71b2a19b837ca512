#include "server/service/ws/login_routes.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <google/protobuf/empty.pb.h>

#include "kerf/v1/access_service.pb.h"
#include "server/service/api/api.h"
#include "server/service/auth/authenticator.h"
#include "server/service/wire/json.h"
#include "server/service/ws/router.h"

namespace kerf::ws {
namespace {

constexpr std::string_view kLogin = "/login";
constexpr std::string_view kLogout = "/logout";
constexpr int kMostFailuresAMinute = 10;
constexpr std::size_t kMostAddresses = 10'000;

// A cookie with this prefix is refused by browsers unless it came over TLS, for this host alone. Both names are looked
// for, as a proxy may add TLS.
constexpr std::string_view kSecureCookie = "__Host-kerf";
constexpr std::string_view kPlainCookie = "kerf";

// Returns the value of a cookie; empty if there is none.
std::string_view cookie_in(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    cookies.remove_prefix(std::min(cookies.find_first_not_of(' '), cookies.size()));
    const std::string_view pair = cookies.substr(0, cookies.find(';'));
    cookies.remove_prefix(std::min(pair.size() + 1, cookies.size()));
    if (pair.substr(0, pair.find('=')) == name && pair.size() > name.size()) return pair.substr(name.size() + 1);
  }
  return {};
}

std::string_view login_in(const HttpRequest& request) {
  const std::string_view secure = cookie_in(request.cookie, kSecureCookie);
  return secure.empty() ? cookie_in(request.cookie, kPlainCookie) : secure;
}

std::string set_cookie(const AccessPolicy& policy, std::string_view value, std::int64_t seconds) {
  const std::string name(policy.is_secure ? kSecureCookie : kPlainCookie);
  return name + "=" + std::string(value) + "; Path=/; Max-Age=" + std::to_string(seconds) +
         (policy.is_secure ? "; Secure" : "") + "; HttpOnly; SameSite=Strict";
}

HttpResponse json_answer(const google::protobuf::Message& message) {
  return {200,
          "application/json",
          std::make_shared<const std::string>(wire::to_json(message)),
          {{"Cache-Control", "no-store"}}};
}

Result<std::string> begin_login(auth::Authenticator& authenticator, const v1::LoginRequest& credential) {
  if (credential.has_code()) return authenticator.logins().open_link(credential.code());
  KERF_TRY_ASSIGN(const auth::Caller caller, authenticator.find(credential.token()));
  return authenticator.logins().begin(caller);
}

}  // namespace

Result<auth::Caller> LoginRoutes::caller_of(const HttpRequest& request, Kind kind) const {
  auth::Authenticator* const authenticator = api_.authenticator();
  const std::string_view login = login_in(request);
  if (authenticator == nullptr || !request.authorization.empty() || login.empty()) {
    return api_.caller_of(request.authorization, request.peer);
  }
  if (kind == Kind::kPost && request.csrf != "1") {
    return permission_denied("CSRF_HEADER_MISSING",
                             "a page that uses its login sends the header `x-kerf-csrf: 1` with each call",
                             "x-kerf-csrf");
  }
  if (kind == Kind::kWebSocket && request.origin.empty()) {
    return permission_denied("ORIGIN_MISSING", "a login is for browsers, which send an Origin; send a token instead",
                             "Origin");
  }
  KERF_TRY_ASSIGN(auth::Caller caller, authenticator->logins().find(login));
  caller.address = request.peer;
  return caller;
}

bool LoginRoutes::is_route(std::string_view path) {
  return path == kLogin || path == kLogout;
}

HttpResponse LoginRoutes::respond(const HttpRequest& request, std::string_view path, const AccessPolicy& policy) {
  return path == kLogin ? log_in(request, policy) : log_out(request, policy);
}

HttpResponse LoginRoutes::log_in(const HttpRequest& request, const AccessPolicy& policy) {
  auth::Authenticator* const authenticator = api_.authenticator();
  if (authenticator == nullptr) {
    return refusal(failed_precondition("NO_TOKENS", "this server asks for no tokens, so there is no login"));
  }
  v1::LoginRequest credential;
  if (const Status parsed = wire::from_json(request.body, credential); !parsed.ok()) return refusal(parsed.error());
  if (credential.credential_case() == v1::LoginRequest::CREDENTIAL_NOT_SET) {
    return refusal(invalid_argument("CHOICE_MISSING", R"(send {"token": "..."} or {"code": "..."})", "credential"));
  }
  if (has_failed_often(request.peer)) {
    HttpResponse response = refusal(resource_exhausted(
        "TOO_MANY_LOGINS", "ten wrong tokens came from this address within a minute; wait a minute"));
    response.headers.emplace_back("Retry-After", "60");
    return response;
  }
  const Result<std::string> login = begin_login(*authenticator, credential);
  if (!login.ok()) {
    if (login.error().code == ErrorCode::kUnauthenticated) count_failure(request.peer);
    api_.record({auth::everybody().grant, request.peer}, "Login", login.error());
    return refusal(login.error());
  }
  const Result<auth::Caller> caller = authenticator->logins().find(*login);
  if (!caller.ok()) return refusal(caller.error());
  api_.record({caller->grant, request.peer}, "Login", Nothing{});
  const std::int64_t seconds = std::max<std::int64_t>((*caller)->ends_at() - authenticator->now(), 0);
  HttpResponse response = json_answer(api_.describe(*caller));
  response.headers.emplace_back("Set-Cookie", set_cookie(policy, *login, seconds));
  return response;
}

HttpResponse LoginRoutes::log_out(const HttpRequest& request, const AccessPolicy& policy) {
  if (auth::Authenticator* const authenticator = api_.authenticator(); authenticator != nullptr) {
    const Result<auth::Caller> caller = authenticator->logins().find(login_in(request));
    if (caller.ok()) api_.record({caller->grant, request.peer}, "Logout", Nothing{});
    authenticator->logins().end(login_in(request));
    api_.check_callers();
  }
  HttpResponse response = json_answer(google::protobuf::Empty());
  response.headers.emplace_back("Set-Cookie", set_cookie(policy, "", 0));
  return response;
}

void LoginRoutes::count_failure(const std::string& peer) {
  const std::int64_t minute = api_.authenticator()->now() / 60;
  const std::lock_guard lock(mutex_);
  if (failures_.size() >= kMostAddresses) {
    std::erase_if(failures_, [minute](const auto& one) { return one.second.minute != minute; });
    if (failures_.size() >= kMostAddresses) failures_.clear();
  }
  Failures& failures = failures_[peer];
  if (failures.minute != minute) failures = {minute, 0};
  ++failures.count;
}

bool LoginRoutes::has_failed_often(const std::string& peer) {
  const std::int64_t minute = api_.authenticator()->now() / 60;
  const std::lock_guard lock(mutex_);
  const auto found = failures_.find(peer);
  return found != failures_.end() && found->second.minute == minute && found->second.count >= kMostFailuresAMinute;
}

}  // namespace kerf::ws
