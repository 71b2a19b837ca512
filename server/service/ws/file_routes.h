#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "server/base/result.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::ws {

struct HttpRequest;
struct HttpResponse;

// Files larger than a message, which are no JSON: GET /sheets/ID.rec; POST /sheets?format=obj|ply&request=JSON and
// POST /recordings?sheet=ID&paused=true, with the file as the body. No path of theirs names a file of this machine.
class FileRoutes {
 public:
  // `api` must outlive this.
  explicit FileRoutes(api::Api& api) : api_(api) {}

  [[nodiscard]] static bool is_download(std::string_view path);
  // Largest body in bytes of a POST there; 0: that is no place for uploads.
  [[nodiscard]] std::int64_t upload_limit(std::string_view path) const;

  // `done` as in Router::respond.
  void download(std::string_view path, std::function<void(HttpResponse)> done) const;
  void upload(HttpRequest request, std::function<void(HttpResponse)> done, const std::stop_token& stop) const;

 private:
  api::Api& api_;
};

// The value of a parameter of `target` ("/path?name=value&..."), decoded; empty if it is not there. kInvalidArgument
// MALFORMED_QUERY with `name` as the field.
Result<std::string> query_parameter(std::string_view target, std::string_view name);

}  // namespace kerf::ws
