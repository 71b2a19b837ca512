#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "server/base/result.h"
#include "server/service/auth/grant.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::ws {

struct HttpRequest;
struct HttpResponse;

// Transfers files larger than a message, without JSON: GET /sheets/ID.rec; POST /sheets?format=obj|ply&request=JSON,
// POST /meshes?format=obj|ply&request=JSON (FileService.InspectMesh) and POST /recordings?sheet=ID&paused=true, with
// the file as the body. No path here names a file of this machine.
class FileRoutes {
 public:
  // `api` must outlive this.
  explicit FileRoutes(api::Api& api) : api_(api) {}

  [[nodiscard]] static bool is_download(std::string_view path);
  // Returns the size of the largest body of a POST to `path`, in bytes; 0 if the path takes no uploads.
  [[nodiscard]] std::int64_t upload_limit(std::string_view path) const;

  // `caller`: who asks, or why that is not known. `done` is as in Router::respond.
  void download(const Result<auth::Caller>& caller, std::string_view path,
                std::function<void(HttpResponse)> done) const;
  void upload(const Result<auth::Caller>& caller, HttpRequest request, std::function<void(HttpResponse)> done,
              const std::stop_token& stop) const;

 private:
  void inspect(const Result<auth::Caller>& caller, HttpRequest request, std::function<void(HttpResponse)> done,
               const std::stop_token& stop) const;

  api::Api& api_;
};

// Returns the decoded value of a parameter of `target` ("/path?name=value&..."); empty if it is missing.
// kInvalidArgument MALFORMED_QUERY with `name` as the field.
Result<std::string> query_parameter(std::string_view target, std::string_view name);

}  // namespace kerf::ws
