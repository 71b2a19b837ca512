#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/service/ws/access.h"
#include "server/service/ws/asset_table.h"
#include "server/service/ws/file_routes.h"
#include "server/service/ws/picture_query.h"

namespace kerf::api {
class Api;
class ImageSession;
class StreamSession;
struct Method;
}  // namespace kerf::api

namespace kerf::ws {

// What matters of a request. A header that is absent is empty.
struct HttpRequest {
  std::string method;           // "GET"
  std::string target;           // "/path?query", as sent
  std::string host;             // Host
  std::string origin;           // Origin
  std::string if_none_match;    // If-None-Match
  std::string accept_encoding;  // Accept-Encoding
  std::string body;
};

struct HttpResponse {
  int status = 200;
  std::string media_type;
  std::shared_ptr<const std::string> body;                     // null: none
  std::vector<std::pair<std::string, std::string>> headers{};  // beside Content-Type and Content-Length
};

// The HTTP status of a refusal.
int http_status(ErrorCode code);
// {"code", "message", "details"}, as JSON.
HttpResponse refusal(const Error& error);

// From requests to responses, without a socket. Safe to call from any thread.
class Router {
 public:
  // `metrics` gives the page of /metrics. `api` must outlive this.
  Router(api::Api& api, AssetTable assets, std::function<std::string()> metrics);

  // Before listening.
  void set_access(AccessPolicy access) { access_ = std::move(access); }
  // /readyz says 503 from now on.
  void drain() { draining_ = true; }

  // `done` is called exactly once: on this thread, or on one of the Api's. `stop`: see api::Method::call.
  void respond(HttpRequest request, std::function<void(HttpResponse)> done, std::stop_token stop = {}) const;

  // Nothing if `request` asks for no MJPEG stream (GET /sheets/ID.mjpeg), else that stream or why there is none.
  [[nodiscard]] std::optional<Result<std::shared_ptr<api::ImageSession>>> play(const HttpRequest& request) const;

  // What makes the session, /watch or /images, of a WebSocket that `request` may open and that speaks the subprotocols
  // listed in `subprotocols` (the value of Sec-WebSocket-Protocol).
  using OpenSession = std::function<std::shared_ptr<api::StreamSession>()>;
  struct Upgrade {
    OpenSession open;  // empty if refused
    std::optional<HttpResponse> refused;
  };
  [[nodiscard]] Upgrade upgrade(const HttpRequest& request, std::string_view subprotocols) const;

  // What body of a request with this head is taken: much for a file, from where files may come, else one message. A
  // file from elsewhere is refused before a byte of it is read.
  struct BodyLimit {
    std::int64_t max_bytes = 0;
    std::optional<HttpResponse> refused;
  };
  [[nodiscard]] BodyLimit body_limit(const HttpRequest& head) const;

 private:
  // /healthz and /readyz, which load balancers ask for without naming a host.
  [[nodiscard]] std::optional<HttpResponse> probe(std::string_view path) const;
  [[nodiscard]] HttpResponse get(const HttpRequest& request, std::string_view path) const;
  void draw(const PicturePath& picture, std::string_view query, std::function<void(HttpResponse)> done) const;
  // `path`: of request.target.
  void call(HttpRequest request, std::string_view path, std::function<void(HttpResponse)> done,
            std::stop_token stop) const;

  api::Api& api_;
  AssetTable assets_;
  std::function<std::string()> metrics_;
  AccessPolicy access_;
  std::map<std::string, const api::Method*, std::less<>> methods_;  // by path
  FileRoutes files_;
  std::int64_t max_message_bytes_;
  std::atomic<bool> draining_ = false;
};

}  // namespace kerf::ws
