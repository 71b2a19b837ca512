#include "server/service/local/kerf_local.h"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "google/rpc/status.pb.h"
#include "server/base/catch_exceptions.h"
#include "server/service/local/local_server.h"
#include "server/service/wire/error_codec.h"

struct kerf_local {
  std::unique_ptr<kerf::local::LocalServer> server;
};

namespace kerf::local {
namespace {

constexpr std::int32_t kDeadlineExceeded = 4;  // https://grpc.io/docs/guides/status-codes/
constexpr double kLongestLimit = 1e9;          // seconds; beyond it nanoseconds of 64 bits are soon too few

kerf_local_bytes copy_of(std::string_view text) {
  void* const data = std::malloc(text.size() + 1);  // NOLINT(*-no-malloc): kerf_local_free() frees it
  if (data == nullptr) return {nullptr, 0};
  std::memcpy(data, text.data(), text.size());
  return {data, text.size()};
}

std::int32_t refuse(const Error& error, kerf_local_bytes* answer) {
  *answer = copy_of(wire::encode_status(error));
  return wire::status_code(error.code);
}

std::int32_t give(const Result<std::string>& result, kerf_local_bytes* answer) {
  if (!result.ok()) return refuse(result.error(), answer);
  *answer = copy_of(*result);
  return 0;
}

std::int32_t refuse_for_time(double time_limit_s, kerf_local_bytes* answer) {
  google::rpc::Status status;
  status.set_code(kDeadlineExceeded);
  status.set_message("the call took longer than its " + std::to_string(time_limit_s) + " s");
  *answer = copy_of(status.SerializeAsString());
  return kDeadlineExceeded;
}

std::string_view view_of(const void* data, std::size_t size) {
  return {static_cast<const char*>(data), size};
}

std::optional<std::chrono::nanoseconds> limit_of(double seconds) {
  if (!(seconds >= 0.0) || seconds > kLongestLimit) return std::nullopt;
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

}  // namespace
}  // namespace kerf::local

#define KERF_EXPORTED __attribute__((visibility("default")))

extern "C" {

KERF_EXPORTED kerf_local* kerf_local_start(std::int32_t workers, std::int32_t render, kerf_local_bytes* failure) {
  auto started = kerf::catch_exceptions([&] { return kerf::local::LocalServer::start({workers, render != 0}); });
  if (started.ok()) return new kerf_local{std::move(started).value()};
  kerf::local::refuse(started.error(), failure);
  return nullptr;
}

KERF_EXPORTED void kerf_local_stop(kerf_local* server) {
  delete server;
}

KERF_EXPORTED std::int32_t kerf_local_call(kerf_local* server, const char* path, const void* request,
                                           std::size_t request_size, double time_limit_s, kerf_local_bytes* answer) {
  std::optional<kerf::Result<std::string>> result;
  const kerf::Status done = kerf::catch_exceptions([&] {
    result =
        server->server->call(path, kerf::local::view_of(request, request_size), kerf::local::limit_of(time_limit_s));
    return kerf::Status(kerf::Nothing{});
  });
  if (!done.ok()) return kerf::local::refuse(done.error(), answer);
  return result ? kerf::local::give(*result, answer) : kerf::local::refuse_for_time(time_limit_s, answer);
}

KERF_EXPORTED std::int32_t kerf_local_upload_sheet(kerf_local* server, const void* start, std::size_t start_size,
                                                   const void* file, std::size_t file_size, kerf_local_bytes* answer) {
  return kerf::local::give(kerf::catch_exceptions([&] {
                             return server->server->upload_sheet(kerf::local::view_of(start, start_size),
                                                                 std::string(kerf::local::view_of(file, file_size)));
                           }),
                           answer);
}

KERF_EXPORTED void kerf_local_free(kerf_local_bytes bytes) {
  std::free(bytes.data);  // NOLINT(*-no-malloc): as copy_of() made it
}

}  // extern "C"
