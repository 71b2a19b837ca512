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
#include "server/service/ws/cross_origin.h"
#include "server/service/ws/file_routes.h"
#include "server/service/ws/login_routes.h"
#include "server/service/ws/picture_query.h"

namespace kerf::api {
class Api;
class ImageSession;
class StreamSession;
struct Method;
}  // namespace kerf::api

namespace kerf::ws {

// Holds the relevant parts of a request. An absent header is empty.
struct HttpRequest {
  std::string method;           // "GET"
  std::string target;           // "/path?query", as sent.
  std::string host;             // Host
  std::string origin;           // Origin
  std::string if_none_match;    // If-None-Match
  std::string accept_encoding;  // Accept-Encoding
  std::string authorization;    // Authorization
  std::string cookie;           // Cookie
  std::string csrf;             // x-kerf-csrf
  std::string forwarded_for;    // x-forwarded-for
  std::string private_network;  // Access-Control-Request-Private-Network
  std::string body;
  std::string peer;  // Address of the client.
};

struct HttpResponse {
  int status = 200;
  std::string media_type;
  std::shared_ptr<const std::string> body;  // Null: none.
  HeaderLines headers{};                    // Besides Content-Type and Content-Length.
};

// Returns the HTTP status of a refusal.
int http_status(ErrorCode code);
// Returns {"code", "message", "details"} as JSON.
HttpResponse refusal(const Error& error);

// Maps requests to responses, without a socket. Callable from any thread.
class Router {
 public:
  // `metrics` returns the page of /metrics. `api` must outlive this.
  Router(api::Api& api, AssetTable assets, std::function<std::string()> metrics);

  // Sets the access policy; to be called before listening.
  void set_access(AccessPolicy access) { access_ = std::move(access); }
  // Makes /readyz answer 503 from now on.
  void drain() { draining_ = true; }

  // Answers a request. `done` is called exactly once: on this thread, or on one of the Api's. `stop`: see
  // api::Method::call.
  void respond(HttpRequest request, std::function<void(HttpResponse)> done, std::stop_token stop = {}) const;

  // See share_with_origin().
  void share_with_origin(std::string_view origin, HeaderLines& headers) const {
    ws::share_with_origin(access_, origin, headers);
  }

  // Returns the MJPEG stream of GET /sheets/ID.mjpeg, or the error; nothing if `request` is not for such a stream.
  [[nodiscard]] std::optional<Result<std::shared_ptr<api::ImageSession>>> play(const HttpRequest& request) const;

  // Decides on a WebSocket requested by `request`. `open` makes the session of /watch or /images. `subprotocols` is the
  // value of Sec-WebSocket-Protocol.
  using OpenSession = std::function<std::shared_ptr<api::StreamSession>()>;
  struct Upgrade {
    OpenSession open;  // Empty if refused.
    std::optional<HttpResponse> refused;
  };
  [[nodiscard]] Upgrade upgrade(const HttpRequest& request, std::string_view subprotocols) const;

  // Returns the largest body for a request with this head: large for a file, else one message. A file from a foreign
  // origin is refused before a byte of it is read.
  struct BodyLimit {
    std::int64_t max_bytes = 0;
    std::optional<HttpResponse> refused;
  };
  [[nodiscard]] BodyLimit body_limit(const HttpRequest& head) const;
  // See api::Api::address_of().
  [[nodiscard]] std::string address_of(std::string peer, std::string_view forwarded_for) const;

 private:
  // Answers /healthz and /readyz, which load balancers request without a valid Host.
  [[nodiscard]] std::optional<HttpResponse> probe(std::string_view path) const;
  // Answers a GET of a file that everybody may read: the viewer, its documentation.
  [[nodiscard]] HttpResponse get(const HttpRequest& request, std::string_view path) const;
  [[nodiscard]] HttpResponse metrics(const HttpRequest& request) const;
  // Answers OPTIONS: a browser's question whether a page of another origin may send a request, or a plain one.
  [[nodiscard]] HttpResponse options(const HttpRequest& request) const;
  void draw(const HttpRequest& request, const PicturePath& picture, std::string_view query,
            std::function<void(HttpResponse)> done) const;
  // `path`: the path part of request.target.
  void call(HttpRequest request, std::string_view path, std::function<void(HttpResponse)> done,
            std::stop_token stop) const;

  api::Api& api_;
  AssetTable assets_;
  std::function<std::string()> metrics_;
  AccessPolicy access_;
  std::map<std::string, const api::Method*, std::less<>> methods_;  // By path.
  FileRoutes files_;
  mutable LoginRoutes logins_;
  std::int64_t max_message_bytes_;
  std::atomic<bool> draining_ = false;
};

}  // namespace kerf::ws
