#include "server/app/server.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include <google/protobuf/struct.pb.h>

#include "render/renderer.h"
#include "server/app/access_control.h"
#include "server/app/certificate_watch.h"
#include "server/app/connection_limits.h"
#include "server/app/file_recording.h"
#include "server/app/kept_sheets.h"
#include "server/app/scene_loading.h"
#include "server/app/store_keeper.h"
#include "server/app/version.h"
#include "server/base/descriptors.h"
#include "server/base/disk.h"
#include "server/service/api/api.h"
#include "server/service/durable/change_codec.h"
#include "server/service/durable/state_codec.h"
#include "server/service/host/clock.h"
#include "server/service/host/entropy.h"
#include "server/service/host/host.h"
#include "server/service/rpc/rpc_server.h"
#include "server/service/store/sqlite_store.h"
#include "server/service/wire/json.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/reply_codec.h"
#include "server/service/ws/http_server.h"
#include "server/service/ws/metrics_page.h"
#include "server/service/ws/tls.h"

namespace kerf::app {
namespace {

constexpr std::chrono::seconds kStopGrace{3};  // For each transport.
constexpr int kExitStoreFailed = 70;           // EX_SOFTWARE of sysexits.h
constexpr std::int64_t kMicrosecondsOfSecond = 1'000'000;

std::string json_string(const std::string& text) {
  google::protobuf::Value value;
  value.set_string_value(text);
  return wire::to_json(value);
}

Result<ws::AssetTable> read_site(const std::filesystem::path& folder) {
  return folder.empty() ? ws::AssetTable() : ws::AssetTable::read(folder);
}

}  // namespace

// Members in the order of construction; destroyed in reverse.
struct Server::Impl {
  // Holds the certificates of both ports; empty without TLS.
  struct Security {
    std::shared_ptr<ws::TlsContext> http;
    std::optional<rpc::RpcTls> grpc;
    std::vector<std::string> notes;
  };

  Config config;
  std::function<void(std::string_view)> note;
  RealDisk disk;
  host::SystemEntropy entropy;
  host::RealClock clock;
  std::string instance_id = wire::encode_hash(entropy.next());
  std::atomic<int> num_recordings = 0;
  RecordingBoard recording_board;
  std::unique_ptr<render::Renderer> renderer;  // Null with --no-render.
  std::unique_ptr<store::SqliteStore> store;   // Null with --data none.
  std::unique_ptr<StoreKeeper> keeper;         // Null with --data none.
  AccessControl access{disk, clock};
  CertificateWatch certificate{clock, [this](std::string_view text) { note(text); }};
  std::unique_ptr<host::Host> host;
  std::unique_ptr<api::Api> api;
  std::unique_ptr<rpc::RpcServer> rpc;
  std::unique_ptr<ws::HttpServer> http;
  Security security;
  int grpc_port = 0;
  int http_port = 0;
  std::vector<std::string> made;       // ids of the sheets of scenes
  std::vector<std::int64_t> replaced;  // numbers of kept sheets that these replace

  host::HostOptions host_options();
  Status build_renderer();
  void tell_what_is_missing() const;
  ConnectionLimits limit_connections() const;
  Status check_record_dir();
  Result<Security> read_security();
  Status open_store();
  Status make_sheets(std::vector<SceneOfFile> scenes);
  Status begin(ws::AssetTable files);
  Status listen(ws::AssetTable files);
  Status start();
  bool reload();
  void stop();
};

host::HostOptions Server::Impl::host_options() {
  host::HostOptions options;
  const auto processors = static_cast<std::int32_t>(std::thread::hardware_concurrency());
  options.workers = config.workers > 0 ? config.workers : std::clamp(processors, 1, 256);
  options.max_sheets = config.max_sheets;
  options.max_load = config.max_load;
  options.max_total_vertices = config.max_total_vertices;
  options.find_tenant = [this](const std::string& tenant) { return access.tenants().sheet_limits(tenant); };
  options.encode_tick = wire::encode_recorded_tick;
  options.journal = store.get();
  options.encode_event = durable::encode_change;
  options.encode_scene = durable::encode_stored_scene;
  options.encode_state = durable::encode_state;
  options.max_unsaved_cpu = host::Nanoseconds(std::llround(1e9 * config.max_replay_s));
  if (!config.record_dir.empty()) {
    options.make_recording = [this](const std::string& id) -> std::shared_ptr<sheet::RecordingSink> {
      // Numbers the files, because two sheets may have the same id, one after the other.
      const std::string name = id + "-" + instance_id + "-" + std::to_string(++num_recordings) + ".kerf";
      return std::make_shared<FileRecording>(disk, clock, recording_board, (config.record_dir / name).string(), note);
    };
  }
  return options;
}

// Builds the renderer. A device requested by name must draw; "auto" may find none.
Status Server::Impl::build_renderer() {
  if (!config.render) return Nothing{};
  const std::string option = "--render-device";
  if (const render::Status known = render::check_device(config.render_device); !known.ok()) {
    return invalid_argument(known.reason, option + ": " + known.message, option);
  }
  renderer = render::make_renderer({.device = config.render_device});
  if (renderer->available() || config.render_device == render::kAnyDevice) return Nothing{};
  return invalid_argument("RENDER_DEVICE_FAILED",
                          option + ": " + config.render_device + " does not draw: " + renderer->description() +
                              " (kerfd --list-render-devices lists those that do)",
                          option);
}

// Notes a missing viewer or renderer, and certificates to be renewed. This is called once everything runs, because a
// failed start reports only its error.
void Server::Impl::tell_what_is_missing() const {
  for (const std::string& each : security.notes) note(each);
  if (config.web.empty()) note("no viewer was found to serve: build web/ or give --web DIR; everything else works");
  if (renderer && !renderer->available()) note("no pictures are drawn: " + renderer->description());
}

ConnectionLimits Server::Impl::limit_connections() const {
  const std::int64_t descriptors = raise_descriptor_limit();
  const std::int64_t recordings = config.record_dir.empty() ? 0 : config.max_sheets;
  const ConnectionLimits limits = connection_limits(descriptors, num_open_descriptors(), recordings);
  const ConnectionLimits usual = connection_limits(std::numeric_limits<std::int32_t>::max(), 0, 0);
  if (limits.grpc < usual.grpc) {
    note("this process may open " + std::to_string(descriptors) + " files and connections: it accepts " +
         std::to_string(limits.grpc) + " connections for gRPC and " + std::to_string(limits.http) +
         " for HTTP; raise the limit (ulimit -n) for more");
  }
  return limits;
}

Status Server::Impl::listen(ws::AssetTable files) {
  const ConnectionLimits connections = limit_connections();
  rpc::RpcOptions rpc_options;
  rpc_options.tls = std::move(security.grpc);
  rpc_options.max_connections = connections.grpc;
  rpc_options.max_connections_per_address = config.max_connections_per_address;
  rpc = std::make_unique<rpc::RpcServer>(*api, clock, rpc_options);
  KERF_TRY_ASSIGN(grpc_port, rpc->start(ws::format_endpoint(config.grpc.host, config.grpc.port)));
  ws::HttpOptions options = config.http_options;
  options.tls = std::move(security.http);
  options.access.allowed_origins = config.allowed_origins;
  options.max_connections = std::min(options.max_connections, connections.http);
  options.max_connections_per_address = config.max_connections_per_address;
  http = std::make_unique<ws::HttpServer>(
      *api, std::move(files),
      [this](const ws::HttpCounts& counts) {
        const rpc::GateCounts gate = rpc->connections();
        return ws::metrics_page(host->metrics(), counts,
                                {gate.accepted, gate.open, gate.refused, gate.refused_by_address}, api->num_watchers(),
                                api->frame_counts(), api->picture_counts(), recording_board.read(), certificate.end_s(),
                                kVersion);
      },
      options);
  KERF_TRY_ASSIGN(http_port, http->start(config.http));
  return Nothing{};
}

// Checks the folder before the first sheet, because a recording that fails later only causes a note. It makes a file:
// permissions do not bind root, nor reveal a read-only file system.
Status Server::Impl::check_record_dir() {
  if (config.record_dir.empty()) return Nothing{};
  const std::string option = "--record: ";
  std::error_code ignored;
  if (!std::filesystem::is_directory(config.record_dir, ignored)) {
    return invalid_argument("BAD_RECORD_DIR", option + "\"" + config.record_dir.string() + "\" is not a folder",
                            "--record");
  }
  const std::filesystem::path probe = config.record_dir / (".kerfd-" + instance_id);
  const auto file = disk.create_file(probe.string());
  if (!file.ok()) return invalid_argument("BAD_RECORD_DIR", option + file.error().message, "--record");
  std::filesystem::remove(probe, ignored);
  return Nothing{};
}

Result<Server::Impl::Security> Server::Impl::read_security() {
  if (!config.tls.used()) return Security();
  KERF_TRY_ASSIGN(Certificates read, read_certificates(config.tls, disk, clock.unix_us() / kMicrosecondsOfSecond));
  Security secured;
  Result<std::shared_ptr<ws::TlsContext>> context = ws::TlsContext::make(read.chain, read.key);
  if (!context.ok()) {
    const Error& error = context.error();
    return invalid_argument(error.reason, "--tls-cert: \"" + config.tls.certificate + "\": " + error.message,
                            "--tls-cert");
  }
  secured.http = std::move(*context);
  secured.grpc = rpc::RpcTls{std::move(read.chain), std::move(read.key), std::move(read.client_authorities)};
  secured.notes = std::move(read.notes);
  certificate.set(config.tls.certificate, read.end_s);
  return secured;
}

Status Server::Impl::open_store() {
  if (config.data_dir.empty()) return Nothing{};
  config.data_dir = made_absolute(std::move(config.data_dir));
  if (config.backups_dir.empty()) {
    config.backups_dir = config.data_dir / "backups";
  } else {
    config.backups_dir = made_absolute(std::move(config.backups_dir));
    KERF_TRY(check_backups_directory(config.backups_dir, config.data_dir));
  }
  store::StoreOptions options;
  options.folder = config.data_dir.string();
  options.now = [this] { return clock.now(); };
  options.unix_us = [this] { return clock.unix_us(); };
  options.failed = [this](const std::string& message) {
    note("the kept sheets cannot be written any more, and nothing may be answered that could be lost: " + message +
         "; start kerfd again once the disk works, and it continues from what is there");
    std::_Exit(kExitStoreFailed);
  };
  auto opened = store::SqliteStore::open(std::move(options));
  if (!opened.ok()) {
    Error error = opened.error();
    error.message = "--data: " + error.message;
    return error;
  }
  store = std::move(opened).value();
  keeper = std::make_unique<StoreKeeper>(*store, config.data_dir, config.backups_dir);
  return Nothing{};
}

// Makes the sheets of the store again, then those of the scenes, which are paused.
Status Server::Impl::make_sheets(std::vector<SceneOfFile> scenes) {
  KeptSheetsFound kept;
  if (store) {
    std::set<std::string> fresh;
    for (const SceneOfFile& scene : scenes) {
      if (config.fresh) fresh.insert(scene.id);
    }
    KERF_TRY_ASSIGN(kept, recover_sheets(*store, *host, fresh, note));
    replaced = kept.left_out;
    KERF_TRY_ASSIGN(store::KeptRequests known,
                    store->requests(config.limits.max_remembered_requests, config.limits.max_remembered_bytes));
    if (known.num_damaged > 0) {
      note(std::to_string(known.num_damaged) +
           " kept answers are damaged and left out: requests that are repeated with their request_id are done again");
    }
    std::vector<host::StoredRequest> requests;
    for (store::KeptRequest& each : known.requests) requests.push_back(std::move(each.request));
    api->remember(std::move(requests));
  }
  KERF_TRY_ASSIGN(made, make_scenes(std::move(scenes), *host, kept.changed));
  return Nothing{};
}

// Listens and starts the clocks. Only then are kept sheets removed that scenes replace: a start that fails loses
// nothing.
Status Server::Impl::begin(ws::AssetTable files) {
  KERF_TRY(listen(std::move(files)));
  KERF_TRY(resume_sheets(made, *host));
  for (const std::int64_t number : replaced) store->remove(number, {}, nullptr);
  host->start_recovered();
  return Nothing{};
}

Status Server::Impl::start() {
  KERF_TRY(check_record_dir());
  KERF_TRY_ASSIGN(security, read_security());
  KERF_TRY(access.start(config.tokens, config.audit_log));
  KERF_TRY_ASSIGN(ws::AssetTable files, read_site(config.web));
  KERF_TRY_ASSIGN(ws::AssetTable docs, read_site(config.docs));
  files.mount("/docs", std::move(docs));
  KERF_TRY_ASSIGN(std::vector<SceneOfFile> scenes, read_scenes(config.scenes, disk));
  KERF_TRY(open_store());
  host = std::make_unique<host::Host>(host_options(), clock, entropy);
  KERF_TRY(build_renderer());
  api::ApiOptions options;
  options.version = kVersion;
  options.instance_id = instance_id;
  options.limits = config.limits;
  options.store = keeper.get();
  options.authenticator = access.authenticator();
  options.tenants = &access.tenants();
  options.audit = access.audit();
  options.is_behind_proxy = config.behind_proxy;
  api = std::make_unique<api::Api>(*host, renderer.get(), options, clock);
  KERF_TRY(make_sheets(std::move(scenes)));
  if (const Status begun = begin(std::move(files)); !begun.ok()) {
    delete_sheets(made, *host);
    return begun;
  }
  tell_what_is_missing();
  return Nothing{};
}

void Server::Impl::stop() {
  if (rpc) rpc->drain();
  if (http) http->drain();
  if (api) api->stop();
  if (host) host->stop();
  if (rpc) rpc->stop(kStopGrace);
  if (http) http->stop(kStopGrace);
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  stop();
}

Result<std::unique_ptr<Server>> Server::start(const Config& config,
                                              const std::function<void(std::string_view line)>& note) {
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  impl->note = note;
  // Also stops the parts started so far if the rest fails.
  std::unique_ptr<Server> server(new Server(std::move(impl)));
  KERF_TRY(server->impl_->start());
  return server;
}

std::string Server::grpc_address() const {
  return ws::format_endpoint(impl_->config.grpc.host, impl_->grpc_port);
}

std::string Server::http_url() const {
  return (impl_->config.tls.used() ? "https://" : "http://") +
         ws::format_endpoint(impl_->config.http.host, impl_->http_port);
}

std::string Server::ready_line() const {
  const std::string data = impl_->store ? R"(,"data":)" + json_string(impl_->config.data_dir.string()) : "";
  return R"({"grpc":")" + grpc_address() + R"(","http":")" + http_url() + '"' + data + "}";
}

bool Server::reload() {
  return impl_->reload();
}

bool Server::Impl::reload() {
  if (access.reload(note)) api->check_callers();
  if (config.tls.used()) {
    if (Result<Security> read = read_security(); read.ok()) {
      http->set_tls(std::move(read->http));
      for (const std::string& each : read->notes) note(each);
      note("the certificate was read again, for new connections of HTTP; gRPC has the old one until kerfd restarts");
    } else {
      note(read.error().message + "; the certificate stays as it was");
    }
  }
  return access.authenticator() != nullptr || access.audit() != nullptr || config.tls.used();
}

void Server::stop() {
  impl_->stop();
}

bool Server::has_closed_sheets() const {
  return impl_->host && impl_->host->has_closed_sheets();
}

}  // namespace kerf::app
