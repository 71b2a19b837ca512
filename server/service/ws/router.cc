#include "server/service/ws/router.h"

#include <algorithm>

#include "server/service/api/access.h"
#include "server/service/api/api.h"
#include "server/service/api/image_session.h"
#include "server/service/api/watch_session.h"
#include "server/service/wire/error_codec.h"
#include "server/service/ws/header_list.h"

namespace kerf::ws {
namespace {

constexpr std::string_view kDocs = "/docs";
constexpr std::string_view kMethods = "GET, HEAD, OPTIONS, POST";
constexpr std::string_view kSubprotocol = "kerf.v1";
// Restricts the viewer and the documentation to this server: a page loads and contacts nothing else, and no other site
// may frame it.
constexpr std::string_view kContentSecurityPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'";

HttpResponse text(int status, std::string body) {
  return {status, "text/plain; charset=utf-8", std::make_shared<const std::string>(std::move(body))};
}

HttpResponse refusal_with_status(int status, const Error& error) {
  HttpResponse response = refusal(error);
  response.status = status;
  return response;
}

// Leads from /docs to /docs/, because links of its pages are relative. This redirection is relative, too, because a
// proxy may serve the pages elsewhere.
HttpResponse to_docs() {
  HttpResponse response = text(302, "see docs/\n");
  response.headers.emplace_back("Location", "docs/");
  response.headers.emplace_back("Cache-Control", "no-cache");
  return response;
}

Error no_such_path(std::string_view path) {
  return not_found("PATH_NOT_FOUND", "there is nothing at '" + std::string(path.substr(0, 200)) +
                                         "'; POST /kerf.v1.SERVICE/METHOD with a JSON body calls a method");
}

HttpResponse method_not_allowed(std::string_view allowed) {
  HttpResponse response =
      refusal_with_status(405, invalid_argument("METHOD_NOT_ALLOWED", "use " + std::string(allowed) + " here"));
  response.headers.emplace_back("Allow", allowed);
  return response;
}

HttpResponse refused_host(const Error& error) {
  return refusal_with_status(error.code == ErrorCode::kInvalidArgument ? 400 : 403, error);
}

struct Target {
  std::string_view path;
  std::string_view query;  // Without the question mark.
};

Target split_target(std::string_view target) {
  const std::size_t mark = std::min(target.find('?'), target.size());
  return {target.substr(0, mark), target.substr(std::min(mark + 1, target.size()))};
}

// Compares entity tags; browsers revalidate with the tag they received. Weak tags compare equal too (RFC 9110, 13.1.2).
bool matches_etag(std::string_view if_none_match, std::string_view etag) {
  return if_none_match == "*" || if_none_match.find(etag) != std::string_view::npos;
}

// Always serves the whole file: a server may ignore a Range header (RFC 9110, 14.2).
HttpResponse serve(const Asset& asset, const HttpRequest& request) {
  const AssetContent& content = asset.best_for(request.accept_encoding);
  HttpResponse response;
  response.media_type = asset.media_type;
  response.headers.emplace_back("ETag", content.etag);
  response.headers.emplace_back("Cache-Control", asset.immutable ? "public, max-age=31536000, immutable" : "no-cache");
  response.headers.emplace_back("Accept-Ranges", "none");
  if (!asset.encoded.empty()) response.headers.emplace_back("Vary", "Accept-Encoding");
  if (asset.media_type.starts_with("text/html")) {
    response.headers.emplace_back("Content-Security-Policy", kContentSecurityPolicy);
  }
  if (matches_etag(request.if_none_match, content.etag)) {
    response.status = 304;
    return response;
  }
  if (!content.coding.empty()) response.headers.emplace_back("Content-Encoding", content.coding);
  response.body = content.bytes;
  return response;
}

}  // namespace

int http_status(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
    case ErrorCode::kFailedPrecondition:
      return 400;
    case ErrorCode::kNotFound:
      return 404;
    case ErrorCode::kAlreadyExists:
    case ErrorCode::kAborted:
      return 409;
    case ErrorCode::kUnauthenticated:
      return 401;
    case ErrorCode::kPermissionDenied:
      return 403;
    case ErrorCode::kResourceExhausted:
      return 429;
    case ErrorCode::kUnavailable:
      return 503;
    case ErrorCode::kDataLoss:
    case ErrorCode::kInternal:
      return 500;
  }
  return 500;
}

HttpResponse refusal(const Error& error) {
  HttpResponse response{http_status(error.code), "application/json",
                        std::make_shared<const std::string>(wire::error_to_json(error))};
  if (wire::passes_by_itself(error) || error.reason == "SERVER_STOPPING") {
    response.headers.emplace_back("Retry-After", "1");
  }
  if (error.code == ErrorCode::kUnauthenticated) response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

Router::Router(api::Api& api, AssetTable assets, std::function<std::string()> metrics)
    : api_(api),
      assets_(std::move(assets)),
      metrics_(std::move(metrics)),
      files_(api),
      logins_(api),
      max_message_bytes_(api.limits().max_request_bytes) {
  for (const api::Method& method : api.methods()) methods_.emplace(method.path, &method);
}

std::optional<HttpResponse> Router::probe(std::string_view path) const {
  if (path == "/healthz") return text(200, "ok\n");
  if (path == "/readyz") return draining_ ? text(503, "draining\n") : text(200, "ready\n");
  return std::nullopt;
}

HttpResponse Router::metrics(const HttpRequest& request) const {
  const Result<auth::Caller> caller = logins_.caller_of(request, LoginRoutes::Kind::kRead);
  if (!caller.ok()) return refusal(caller.error());
  // The page is about all sheets.
  if (!(*caller)->rights().reaches_all()) {
    return refusal(permission_denied("SHEET_NOT_ALLOWED", "metrics are for tokens that reach all sheets"));
  }
  return {200, "text/plain; version=0.0.4; charset=utf-8", std::make_shared<const std::string>(metrics_())};
}

HttpResponse Router::get(const HttpRequest& request, std::string_view path) const {
  if (path == "/metrics") return metrics(request);
  if (const Asset* asset = assets_.find(path)) return serve(*asset, request);
  if (path == "/") return text(404, "kerfd runs, but no viewer was found; build web/ or give --web DIR\n");
  if (path == kDocs && assets_.find("/docs/") != nullptr) return to_docs();
  if (path == kDocs || path == "/docs/") {
    return text(
        404,
        "kerfd runs, but its documentation was not found; build it with deploy/docs, or give --docs DIR, and start "
        "kerfd again\n");
  }
  if (methods_.contains(path)) return method_not_allowed("POST");
  return refusal(no_such_path(path));
}

void Router::respond(HttpRequest request, std::function<void(HttpResponse)> done, std::stop_token stop) const {
  const std::string whole_target = request.target;  // Outlives the request, which is moved.
  const Target target = split_target(whole_target);
  const bool reads = request.method == "GET" || request.method == "HEAD";
  if (std::optional<HttpResponse> state = reads ? probe(target.path) : std::nullopt) return done(*std::move(state));
  if (const Status host = check_host(access_, request.host); !host.ok()) return done(refused_host(host.error()));
  const std::optional<PicturePath> picture = reads ? parse_picture_path(target.path) : std::nullopt;
  if (picture) return draw(request, *picture, target.query, std::move(done));
  if (reads && FileRoutes::is_download(target.path)) {
    return files_.download(logins_.caller_of(request, LoginRoutes::Kind::kRead), target.path, std::move(done));
  }
  if (reads) return done(get(request, target.path));
  if (request.method == "OPTIONS") return done(options(request));
  if (request.method != "POST") return done(method_not_allowed(kMethods));
  call(std::move(request), target.path, std::move(done), std::move(stop));
}

HttpResponse Router::options(const HttpRequest& request) const {
  if (const Status origin = check_origin(access_, request.origin, request.host); !origin.ok()) {
    return refusal_with_status(403, origin.error());
  }
  HttpResponse response{204, {}, nullptr};
  if (lists_origin(access_, request.origin)) response.headers = preflight_headers(request.private_network);
  response.headers.emplace_back("Allow", kMethods);
  return response;
}

void Router::draw(const HttpRequest& from, const PicturePath& picture, std::string_view query,
                  std::function<void(HttpResponse)> done) const {
  if (picture.kind == PictureKind::kMjpeg) return done(method_not_allowed("GET"));  // play() handles GET.
  const Result<auth::Caller> caller = logins_.caller_of(from, LoginRoutes::Kind::kRead);
  if (!caller.ok()) return done(refusal(caller.error()));
  const Result<v1::RenderImageRequest> request = decode_still_query(picture, query);
  if (!request.ok()) return done(refusal(request.error()));
  if (const Status allowed = api_.allow(*caller, *request); !allowed.ok()) {
    return done(refusal(in_words_of_query(allowed.error())));
  }
  api_.render_image(*request, [done = std::move(done)](Result<v1::RenderImageResponse> reply) {
    if (!reply.ok()) return done(refusal(in_words_of_query(reply.error())));
    done({200,
          reply->media_type(),
          std::make_shared<const std::string>(std::move(*reply->mutable_image())),
          {{"Cache-Control", "no-store"}}});
  });
}

void Router::call(HttpRequest request, std::string_view path, std::function<void(HttpResponse)> done,
                  std::stop_token stop) const {
  const bool is_upload = files_.upload_limit(path) > 0;
  const auto method = methods_.find(path);
  if (method == methods_.end() && !is_upload && !LoginRoutes::is_route(path)) return done(refusal(no_such_path(path)));
  if (const Status origin = check_origin(access_, request.origin, request.host); !origin.ok()) {
    return done(refusal_with_status(403, origin.error()));
  }
  if (LoginRoutes::is_route(path)) return done(logins_.respond(request, path, access_));
  const Result<auth::Caller> caller = logins_.caller_of(request, LoginRoutes::Kind::kPost);
  if (is_upload) return files_.upload(caller, std::move(request), std::move(done), stop);
  if (!caller.ok()) return done(refusal(caller.error()));
  // Treats an empty body as the empty message, so that `curl -X POST` works for List and Get*Info.
  method->second->call(
      request.body.empty() ? std::string_view("{}") : std::string_view(request.body), api::Encoding::kJson, *caller,
      [done = std::move(done)](Result<std::string> reply) {
        if (!reply.ok()) return done(refusal(reply.error()));
        done({200,
              "application/json",
              std::make_shared<const std::string>(std::move(*reply)),
              {{"Cache-Control", "no-store"}}});
      },
      std::move(stop));
}

std::string Router::address_of(std::string peer, std::string_view forwarded_for) const {
  return api_.address_of(std::move(peer), forwarded_for);
}

Router::BodyLimit Router::body_limit(const HttpRequest& head) const {
  const std::string_view path = split_target(head.target).path;
  const std::int64_t limit = head.method == "POST" ? files_.upload_limit(path) : 0;
  if (limit == 0) return {max_message_bytes_, std::nullopt};
  if (const Status host = check_host(access_, head.host); !host.ok()) return {0, refused_host(host.error())};
  if (const Status origin = check_origin(access_, head.origin, head.host); !origin.ok()) {
    return {0, refusal_with_status(403, origin.error())};
  }
  const Result<auth::Caller> caller = logins_.caller_of(head, LoginRoutes::Kind::kPost);
  if (!caller.ok()) return {0, refusal(caller.error())};
  return {limit, std::nullopt};
}

std::optional<Result<std::shared_ptr<api::ImageSession>>> Router::play(const HttpRequest& request) const {
  const Target target = split_target(request.target);
  const std::optional<PicturePath> picture = parse_picture_path(target.path);
  if (request.method != "GET" || !picture || picture->kind != PictureKind::kMjpeg) return std::nullopt;
  // Leaves the refusal to respond(), which is called next.
  if (!check_host(access_, request.host).ok()) return std::nullopt;
  KERF_TRY_ASSIGN(const auth::Caller caller, logins_.caller_of(request, LoginRoutes::Kind::kRead));
  KERF_TRY_ASSIGN(const v1::WatchImagesStart start, decode_stream_query(*picture, target.query));
  return api_.play_images(start, caller);
}

Router::Upgrade Router::upgrade(const HttpRequest& request, std::string_view subprotocols) const {
  const std::string_view path = split_target(request.target).path;
  if (const Status host = check_host(access_, request.host); !host.ok()) return {{}, refused_host(host.error())};
  if (path != "/watch" && path != "/images") return {{}, refusal(no_such_path(request.target))};
  if (const Status origin = check_origin(access_, request.origin, request.host); !origin.ok()) {
    return {{}, refusal_with_status(403, origin.error())};
  }
  if (!lists_token(subprotocols, kSubprotocol)) {
    return {{},
            refusal(invalid_argument("SUBPROTOCOL_MISSING", "ask for the WebSocket subprotocol 'kerf.v1'",
                                     "Sec-WebSocket-Protocol"))};
  }
  const Result<auth::Caller> caller = logins_.caller_of(request, LoginRoutes::Kind::kWebSocket);
  if (!caller.ok()) return {{}, refusal(caller.error())};
  if (path == "/watch") return {[this, who = *caller] { return api_.watch(who); }, std::nullopt};
  return {[this, who = *caller] { return api_.watch_images(who); }, std::nullopt};
}

}  // namespace kerf::ws
