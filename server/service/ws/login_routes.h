#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::ws {

struct AccessPolicy;
struct HttpRequest;
struct HttpResponse;

// Finds out who sends a request, by its token or by the cookie of a login, and logs browsers in and out: POST /login
// and /logout. Thread-safe.
class LoginRoutes {
 public:
  // `api` must outlive this.
  explicit LoginRoutes(api::Api& api) : api_(api) {}

  // Returns who sends the request. A cookie alone counts only with the header `x-kerf-csrf: 1` if the request is a
  // POST, and with an Origin if it opens a WebSocket; the caller of this function checks that Origin. Errors:
  // kUnauthenticated; kPermissionDenied CSRF_HEADER_MISSING or ORIGIN_MISSING.
  enum class Kind { kRead, kPost, kWebSocket };
  [[nodiscard]] Result<auth::Caller> caller_of(const HttpRequest& request, Kind kind) const;

  [[nodiscard]] static bool is_route(std::string_view path);
  // Answers POST /login or /logout; the origin has been checked.
  [[nodiscard]] HttpResponse respond(const HttpRequest& request, std::string_view path, const AccessPolicy& policy);

 private:
  HttpResponse log_in(const HttpRequest& request, const AccessPolicy& policy);
  HttpResponse log_out(const HttpRequest& request, const AccessPolicy& policy);
  // Counts a wrong token or code of an address.
  void count_failure(const std::string& peer);
  [[nodiscard]] bool has_failed_often(const std::string& peer);

  struct Failures {
    std::int64_t minute = 0;  // since 1970
    int count = 0;
  };

  api::Api& api_;
  std::mutex mutex_;
  std::map<std::string, Failures> failures_;  // By address, of the present minute; guarded by mutex_.
};

}  // namespace kerf::ws
