#include "server/service/local/kerf_local.h"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
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

constexpr std::int32_t kDeadlineExceeded = 4;   // https://grpc.io/docs/guides/status-codes/
constexpr std::int32_t kResourceExhausted = 8;  // the same
constexpr double kLongestLimit = 1e9;           // seconds; beyond it nanoseconds of 64 bits are soon too few

// Returns `code` and a copy of the text, or kResourceExhausted and nothing.
std::int32_t answer_with(std::int32_t code, std::string_view text, kerf_local_bytes* answer) {
  void* const data = std::malloc(text.size() + 1);  // NOLINT(*-no-malloc): kerf_local_free() frees it
  if (data == nullptr) return kResourceExhausted;
  std::memcpy(data, text.data(), text.size());
  *answer = {data, text.size()};
  return code;
}

std::int32_t refuse(const Error& error, kerf_local_bytes* answer) {
  return answer_with(wire::status_code(error.code), wire::encode_status(error), answer);
}

std::int32_t give(const std::optional<Result<std::string>>& result, double time_limit_s, kerf_local_bytes* answer) {
  if (result) return result->ok() ? answer_with(0, **result, answer) : refuse(result->error(), answer);
  google::rpc::Status status;
  status.set_code(kDeadlineExceeded);
  status.set_message("the call took longer than its " + std::to_string(time_limit_s) + " s");
  return answer_with(kDeadlineExceeded, status.SerializeAsString(), answer);
}

// Runs `work`, which returns a status code and sets `answer`. No exception may leave a function of C.
template <typename Work>
std::int32_t guarded(kerf_local_bytes* answer, Work work) noexcept {
  *answer = {nullptr, 0};
  try {
    const Result<std::int32_t> code = catch_exceptions([&] { return Result<std::int32_t>(work()); });
    return code.ok() ? *code : refuse(code.error(), answer);
  } catch (const std::exception&) {  // there is no memory even for the refusal
    return kResourceExhausted;
  }
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

KERF_EXPORTED kerf_local* kerf_local_start(int32_t workers, int32_t render, kerf_local_bytes* failure) {
  kerf_local* server = nullptr;
  kerf::local::guarded(failure, [&] {
    auto started = kerf::local::LocalServer::start({workers, render != 0});
    if (!started.ok()) return kerf::local::refuse(started.error(), failure);
    server = new kerf_local{std::move(started).value()};
    return 0;
  });
  return server;
}

KERF_EXPORTED void kerf_local_stop(kerf_local* server) {
  delete server;
}

KERF_EXPORTED int32_t kerf_local_call(kerf_local* server, const char* path, const void* request, size_t request_size,
                                      double time_limit_s, kerf_local_bytes* answer) {
  return kerf::local::guarded(answer, [&] {
    return kerf::local::give(
        server->server->call(path, kerf::local::view_of(request, request_size), kerf::local::limit_of(time_limit_s)),
        time_limit_s, answer);
  });
}

KERF_EXPORTED int32_t kerf_local_upload_sheet(kerf_local* server, const void* start, size_t start_size,
                                              const void* file, size_t file_size, double time_limit_s,
                                              kerf_local_bytes* answer) {
  return kerf::local::guarded(answer, [&] {
    return kerf::local::give(server->server->upload_sheet(kerf::local::view_of(start, start_size),
                                                          std::string(kerf::local::view_of(file, file_size)),
                                                          kerf::local::limit_of(time_limit_s)),
                             time_limit_s, answer);
  });
}

KERF_EXPORTED void kerf_local_free(kerf_local_bytes bytes) {
  std::free(bytes.data);  // NOLINT(*-no-malloc): as answer_with() made it
}

}  // extern "C"
