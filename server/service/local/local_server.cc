#include "server/service/local/local_server.h"

#include <algorithm>
#include <functional>
#include <future>
#include <map>
#include <stop_token>
#include <thread>
#include <utility>

#include "kerf/v1/sheets.pb.h"
#include "render/renderer.h"
#include "server/service/api/api.h"
#include "server/service/api/upload.h"
#include "server/service/auth/grant.h"
#include "server/service/host/clock.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host.h"
#include "server/service/wire/reply_codec.h"

namespace kerf::local {
namespace {

constexpr std::int32_t kMaxWorkers = 256;
constexpr std::int32_t kMaxSheets = 4096;

host::HostOptions host_options(std::int32_t workers) {
  host::HostOptions options;
  const auto processors = static_cast<std::int32_t>(std::thread::hardware_concurrency());
  options.workers = workers > 0 ? workers : std::clamp(processors, 1, kMaxWorkers);
  options.max_sheets = kMaxSheets;
  options.max_load = 0.0;
  return options;
}

api::ApiOptions api_options(host::Entropy& entropy) {
  api::ApiOptions options;
  options.version = KERF_VERSION;
  options.instance_id = wire::encode_hash(entropy.next());
  return options;
}

// Waits for an answer, or stops the work once `time_limit` is over, and then returns nothing.
std::optional<Result<std::string>> wait(std::future<Result<std::string>> answered,
                                        std::optional<std::chrono::nanoseconds> time_limit, std::stop_source& stop) {
  if (time_limit && answered.wait_for(*time_limit) != std::future_status::ready) {
    stop.request_stop();
    return std::nullopt;
  }
  return answered.get();
}

}  // namespace

// Members in the order of construction; destroyed in reverse.
struct LocalServer::Impl {
  explicit Impl(const LocalOptions& options)
      : renderer(options.render ? render::make_renderer({}) : nullptr),
        host(host_options(options.workers), clock, entropy),
        api(host, renderer.get(), api_options(entropy), clock) {
    for (const api::Method& method : api.methods()) methods.emplace(method.path, &method);
  }
  ~Impl() {
    api.stop();
    host.stop();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  host::SystemEntropy entropy;
  host::RealClock clock;
  std::unique_ptr<render::Renderer> renderer;
  host::Host host;
  api::Api api;
  std::map<std::string, const api::Method*, std::less<>> methods;  // By path.
};

LocalServer::LocalServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LocalServer::~LocalServer() = default;

Result<std::unique_ptr<LocalServer>> LocalServer::start(const LocalOptions& options) {
  if (options.workers < 0 || options.workers > kMaxWorkers) {
    return invalid_argument(
        "BAD_WORKERS",
        "there can be 1 to 256 workers, not " + std::to_string(options.workers) + "; 0 starts one for each processor",
        "workers");
  }
  return std::unique_ptr<LocalServer>(new LocalServer(std::make_unique<Impl>(options)));
}

std::optional<Result<std::string>> LocalServer::call(std::string_view path, std::string_view request,
                                                     std::optional<std::chrono::nanoseconds> time_limit) {
  const auto method = impl_->methods.find(path);
  if (method == impl_->methods.end()) {
    return not_found("NO_SUCH_CALL", "a server in the same process has no call " + std::string(path));
  }
  // Shared, because a call whose time is over is still answered.
  const auto answer = std::make_shared<std::promise<Result<std::string>>>();
  std::stop_source stop;
  method->second->call(
      request, api::Encoding::kBinary, auth::everybody(),
      [answer](Result<std::string> result) { answer->set_value(std::move(result)); }, stop.get_token());
  return wait(answer->get_future(), time_limit, stop);
}

std::optional<Result<std::string>> LocalServer::upload_sheet(std::string_view start, std::string file,
                                                             std::optional<std::chrono::nanoseconds> time_limit) {
  v1::SheetUpload begin;
  if (!begin.ParseFromArray(start.data(), static_cast<int>(start.size()))) {
    return invalid_argument("MALFORMED_MESSAGE", "this is not a serialised kerf.v1.SheetUpload");
  }
  Result<std::unique_ptr<api::Upload>> upload = impl_->api.upload_sheet(begin);
  if (!upload.ok()) return upload.error();
  if (const Status taken = (*upload)->append(std::move(file)); !taken.ok()) return taken.error();
  const auto answer = std::make_shared<std::promise<Result<std::string>>>();
  std::stop_source stop;
  (*upload)->finish(
      [answer](Result<v1::Sheet> sheet) {
        answer->set_value(sheet.ok() ? Result<std::string>(sheet->SerializeAsString()) : sheet.error());
      },
      stop.get_token());
  return wait(answer->get_future(), time_limit, stop);
}

}  // namespace kerf::local
