#include "server/app/config.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "render/renderer.h"
#include "server/app/version.h"
#include "server/base/memory_limit.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::app {
namespace {

// Refuses an empty name, as an unset variable of a script gives it.
std::string check_named(const std::string& name) {
  return name.empty() ? "is empty; name a folder" : "";
}

std::string check_file_named(const std::string& name) {
  return name.empty() ? "is empty; name a file" : "";
}

constexpr const char* kDescription =
    "Kerf: steps finite-element sheets in real time, takes cuts over gRPC and streams them to viewers.\n"
    "When ready it prints one line on standard output: "
    "{\"grpc\":\"HOST:PORT\",\"http\":\"http://HOST:PORT\",\"data\":\"DIR\"}, with https:// over TLS\n"
    "SIGTERM or SIGINT (Ctrl-C) stops it cleanly.";

constexpr int kMostSheets = 100'000;
constexpr int kMostConnections = 10'000;

// Holds the arguments as typed. They are checked after parsing, so that every error is one line in our own words.
struct Arguments {
  std::string listen = "127.0.0.1:50051";
  std::string http = "127.0.0.1:8080";
  std::vector<std::string> scenes;
  int workers = 0;
  int max_sheets = Config().max_sheets;
  double max_load = Config().max_load;
  std::optional<std::int64_t> max_total_vertices;  // The default depends on the machine.
  std::string web;
  std::string docs;
  bool no_render = false;
  std::string render_device = render::kAnyDevice;
  bool list_render_devices = false;
  CertificateFiles tls;
  std::vector<std::string> allowed_origins;
  std::string tokens;
  std::string audit_log;
  bool behind_proxy = false;
  std::string record_dir;
  std::string data_dir;
  std::string backups_dir;
  std::string check_store;
  std::string restore_store;
  double max_replay_s = Config().max_replay_s;
  bool fresh = false;
  std::optional<int> max_connections_per_address;
};

void declare_limits(CLI::App& parser, Arguments& arguments) {
  parser.add_option("--workers", arguments.workers, "Threads that step sheets, 1..256; 0: one for each processor")
      ->type_name("N")
      ->capture_default_str();
  parser.add_option("--max-sheets", arguments.max_sheets, "Sheets at a time, 1..100000")
      ->type_name("N")
      ->capture_default_str();
  parser
      .add_option("--max-load", arguments.max_load,
                  "Refuse new sheets while running ones need at least this share of the workers, 0.01..1000; 0: never")
      ->type_name("SHARE")
      ->capture_default_str();
  parser
      .add_option("--max-total-vertices", arguments.max_total_vertices,
                  "Refuse new sheets if all together would have more vertices than this; 0: never (default: as many as "
                  "fit in half the memory of the machine or container at 8 kB each, as the implicit integrator needs)")
      ->type_name("N");
  parser
      .add_option("--max-connections-per-address", arguments.max_connections_per_address,
                  "Connections that one address (one /64 of IPv6) may have open, for gRPC and for HTTP each, 1..10000; "
                  "0: no limit per address (default: 128; with --behind-proxy 0)")
      ->type_name("N");
}

void declare_tls(CLI::App& parser, CertificateFiles& files) {
  parser
      .add_option(
          "--tls-cert", files.certificate,
          "Certificate of this server in PEM form, with those that lead to its authority; both ports then speak "
          "TLS. SIGHUP reads it again, for HTTP")
      ->check(check_file_named)
      ->type_name("FILE");
  parser.add_option("--tls-key", files.key, "Private key of --tls-cert in PEM form, without a password")
      ->check(check_file_named)
      ->type_name("FILE");
  parser
      .add_option("--tls-client-ca", files.client_authorities,
                  "Certificates of authorities in PEM form: gRPC then serves only clients with a certificate of these")
      ->check(check_file_named)
      ->type_name("FILE");
}

void declare(CLI::App& parser, Arguments& arguments) {
  parser.get_help_ptr()->description("Print this help and exit");
  parser.set_version_flag("--version", std::string("kerfd ") + kVersion, "Print the version and exit");
  parser.add_option("--listen", arguments.listen, "Address of the gRPC services; port 0 picks a free one")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  parser
      .add_option("--http", arguments.http,
                  "Address of the viewer, the WebSocket and JSON calls; port 0 picks a free one")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  parser
      .add_option("--scene", arguments.scenes, "Scene file (JSON of kerf.v1.Scene) to start a sheet from; repeatable")
      ->type_name("FILE")
      ->take_all();
  declare_limits(parser, arguments);
  parser.add_option("--web", arguments.web, "Folder of the built viewer (default: found beside the program)")
      ->type_name("DIR");
  parser
      .add_option("--docs", arguments.docs,
                  "Folder of the built documentation, served at /docs (default: found beside the program)")
      ->type_name("DIR");
  CLI::Option* no_render =
      parser.add_flag("--no-render", arguments.no_render, "Draw no pictures, even where EGL works");
  parser
      .add_option("--render-device", arguments.render_device,
                  "What draws pictures: auto (hardware if there is any, else software), software, none, or the number "
                  "or part of the name of a device")
      ->type_name("DEVICE")
      ->capture_default_str()
      ->excludes(no_render);
  parser.add_flag("--list-render-devices", arguments.list_render_devices,
                  "Print the devices that can draw pictures and exit");
  declare_tls(parser, arguments.tls);
  parser
      .add_option("--tokens", arguments.tokens,
                  "Asks every caller for a token; this file has the known ones, a line each, made by `kerf token new`. "
                  "SIGHUP reads it again")
      ->check(check_file_named)
      ->type_name("FILE");
  parser
      .add_option("--audit-log", arguments.audit_log,
                  "Appends a line of JSON to this file for each change, login and refused token: who, from where, what "
                  "and its outcome. SIGHUP opens it again")
      ->check(check_file_named)
      ->type_name("FILE");
  parser.add_flag(
      "--behind-proxy", arguments.behind_proxy,
      "All clients come through a proxy on this machine, such as deploy/haproxy.cfg: believe the addresses that "
      "it gives as x-forwarded-for, and leave limits per connection to it");
  parser
      .add_option("--allow-origin", arguments.allowed_origins,
                  "Web origin, such as https://viewer.example.org, whose pages may use this server; repeatable")
      ->check(ws::fault_of_origin)
      ->type_name("ORIGIN")
      ->take_all();
  parser
      .add_option("--data", arguments.data_dir,
                  "Folder in which sheets are kept, so that they go on after a restart; 'none': they end with kerfd")
      ->check(check_named)
      ->type_name("DIR")
      ->default_str("$XDG_DATA_HOME/kerf, or ~/.local/share/kerf");
  parser
      .add_option("--max-replay-s", arguments.max_replay_s,
                  "Seconds of computation that a restart may have to repeat on each worker, 0.01..3600; less makes "
                  "restarts faster and saves sheets more often")
      ->type_name("S")
      ->capture_default_str();
  parser
      .add_option(
          "--check-store", arguments.check_store,
          "Check everything that is kept in this folder, change nothing, print what is wrong, and exit with 1 if "
          "anything is")
      ->check(check_named)
      ->type_name("DIR");
  parser
      .add_option("--backups", arguments.backups_dir,
                  "Folder for backups that clients ask for; one folder for each server (default: backups in the folder "
                  "of --data)")
      ->check(check_named)
      ->type_name("DIR");
  parser
      .add_option(
          "--restore-store", arguments.restore_store,
          "Make the folder of --data, which must be missing or empty, from this backup, print what it has, and exit")
      ->check(check_named)
      ->type_name("BACKUP");
  parser.add_flag("--fresh", arguments.fresh, "Replace kept sheets by those of --scene, even if clients changed them");
  parser
      .add_option(
          "--record", arguments.record_dir,
          "Folder for a recording of every sheet, for `kerf replay`; while its disk is full, recordings wait in memory")
      ->type_name("DIR");
}

// Parses an address. One that other machines reach is refused unless strangers are kept out; `needs`: the options that
// keep them out, `has_them` if they are given.
Result<ws::Endpoint> listening_address(const std::string& text, const std::string& option, const std::string& needs,
                                       bool has_them) {
  Result<ws::Endpoint> endpoint = ws::parse_endpoint(text);
  if (!endpoint.ok()) return invalid_argument("BAD_ADDRESS", option + ": " + endpoint.error().message, option);
  if (!has_them && !ws::is_loopback(endpoint->host)) {
    return invalid_argument("REMOTE_NOT_ALLOWED",
                            option + ": other machines could reach " + text + "; give " + needs +
                                ", so that no stranger gets in, or listen on 127.0.0.1 (deploy/run --remote NAME does "
                                "all of it)",
                            option);
  }
  return endpoint;
}

// Refuses options that would be ignored: kerfd does one thing and ends, with its own options alone.
Status check_alone(const CLI::App& parser, const std::string& task, const std::string& companion = {}) {
  const std::vector<const CLI::Option*> given =
      parser.get_options([](const CLI::Option* option) { return option->count() > 0; });
  for (const CLI::Option* option : given) {
    const std::string name = option->get_name();
    if (name == task || name == companion) continue;
    return invalid_argument("CONTRADICTING_OPTIONS",
                            task + " starts no server; leave " + name + " out, or start the server without " + task,
                            name);
  }
  return Nothing{};
}

// Refuses options that have no effect without a folder of kept sheets.
Status check_keeping(const CLI::App& parser, const Arguments& arguments) {
  if (arguments.data_dir == "none") {
    for (const std::string option : {"--backups", "--fresh", "--max-replay-s"}) {
      if (parser.count(option) == 0) continue;
      return invalid_argument("OPTION_WITHOUT_DATA",
                              option + ": with --data none nothing is kept; give --data DIR, or leave it out", option);
    }
  }
  if (arguments.fresh && arguments.scenes.empty()) {
    return invalid_argument("FRESH_WITHOUT_SCENE",
                            "--fresh: replaces the kept sheets of scene files; give --scene FILE as well", "--fresh");
  }
  return Nothing{};
}

Status check_tls(const CertificateFiles& files) {
  if (files.certificate.empty() != files.key.empty()) {
    return invalid_argument("TLS_NEEDS_CERT_AND_KEY",
                            "--tls-cert and --tls-key: give both, the certificate and its key, or none",
                            files.key.empty() ? "--tls-key" : "--tls-cert");
  }
  if (files.certificate.empty() && !files.client_authorities.empty()) {
    return invalid_argument("CLIENT_CA_WITHOUT_TLS", "--tls-client-ca: give --tls-cert and --tls-key as well",
                            "--tls-client-ca");
  }
  return Nothing{};
}

Status check_proxy(const Config& config) {
  if (!config.behind_proxy || (ws::is_loopback(config.grpc.host) && ws::is_loopback(config.http.host)))
    return Nothing{};
  return invalid_argument("REACHED_WITHOUT_PROXY",
                          "--behind-proxy: others could come without the proxy and give any address; let --listen and "
                          "--http be 127.0.0.1",
                          "--behind-proxy");
}

Result<std::variant<Config, Notice>> to_config(const Arguments& arguments) {
  KERF_TRY(check_tls(arguments.tls));
  Config config;
  const bool is_guarded = arguments.tls.used() && !arguments.tokens.empty();
  KERF_TRY_ASSIGN(config.grpc,
                  listening_address(arguments.listen, "--listen", "--tls-cert, --tls-key, --tls-client-ca and --tokens",
                                    is_guarded && !arguments.tls.client_authorities.empty()));
  KERF_TRY_ASSIGN(config.http,
                  listening_address(arguments.http, "--http", "--tls-cert, --tls-key and --tokens", is_guarded));
  if (arguments.workers < 0 || arguments.workers > 256) {
    return invalid_argument("WORKERS_OUT_OF_RANGE",
                            "--workers: " + std::to_string(arguments.workers) + " is not in 0..256", "--workers");
  }
  config.workers = arguments.workers;
  if (arguments.max_sheets < 1 || arguments.max_sheets > kMostSheets) {
    return invalid_argument(
        "MAX_SHEETS_OUT_OF_RANGE",
        "--max-sheets: " + std::to_string(arguments.max_sheets) + " is not in 1.." + std::to_string(kMostSheets),
        "--max-sheets");
  }
  config.max_sheets = arguments.max_sheets;
  if (arguments.max_load != 0.0 && !(arguments.max_load >= 0.01 && arguments.max_load <= 1000.0)) {
    return invalid_argument("MAX_LOAD_OUT_OF_RANGE",
                            "--max-load: " + std::to_string(arguments.max_load) + " is neither 0 nor in 0.01..1000",
                            "--max-load");
  }
  config.max_load = arguments.max_load;
  config.max_total_vertices = arguments.max_total_vertices.value_or(default_total_vertices(memory_limit()));
  if (config.max_total_vertices < 0 || config.max_total_vertices > kMostTotalVertices) {
    return invalid_argument("MAX_TOTAL_VERTICES_OUT_OF_RANGE",
                            "--max-total-vertices: " + std::to_string(config.max_total_vertices) + " is not in 0.." +
                                std::to_string(kMostTotalVertices),
                            "--max-total-vertices");
  }
  const int per_address =
      arguments.max_connections_per_address.value_or(arguments.behind_proxy ? 0 : config.max_connections_per_address);
  if (per_address < 0 || per_address > kMostConnections) {
    return invalid_argument("MAX_CONNECTIONS_PER_ADDRESS_OUT_OF_RANGE",
                            "--max-connections-per-address: " + std::to_string(per_address) + " is not in 0.." +
                                std::to_string(kMostConnections),
                            "--max-connections-per-address");
  }
  config.max_connections_per_address = per_address;
  config.scenes.assign(arguments.scenes.begin(), arguments.scenes.end());
  config.web = arguments.web;
  config.docs = arguments.docs;
  config.render = !arguments.no_render && arguments.render_device != render::kNoDevice;
  config.render_device = arguments.render_device;
  config.tls = arguments.tls;
  config.allowed_origins = arguments.allowed_origins;
  config.tokens = arguments.tokens;
  config.audit_log = arguments.audit_log;
  config.behind_proxy = arguments.behind_proxy;
  KERF_TRY(check_proxy(config));
  config.record_dir = arguments.record_dir;
  config.keeps_nothing = arguments.data_dir == "none";
  if (!config.keeps_nothing) config.data_dir = arguments.data_dir;
  config.backups_dir = arguments.backups_dir;
  config.fresh = arguments.fresh;
  if (!(arguments.max_replay_s >= 0.01 && arguments.max_replay_s <= 3600.0)) {
    return invalid_argument("MAX_REPLAY_OUT_OF_RANGE",
                            "--max-replay-s: " + std::to_string(arguments.max_replay_s) + " is not in 0.01..3600",
                            "--max-replay-s");
  }
  config.max_replay_s = arguments.max_replay_s;
  return std::variant<Config, Notice>(std::move(config));
}

// Returns a line per device: its number, its name and whether it draws.
std::string render_device_table() {
  const std::vector<render::DeviceOutcome> outcomes = render::probe_devices();
  if (outcomes.empty()) return render::make_renderer()->description() + "\n";
  std::string table;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const auto& [device, state, words] = outcomes[i];
    table += std::to_string(i) + (state == render::DeviceState::kChosen ? " * " : "   ") + device.name;
    if (!device.details.empty()) table += ", " + device.details;
    table += (state == render::DeviceState::kRejected ? ": does not draw: " : ": ") + words + "\n";
  }
  return table + "* marks the choice of --render-device auto\n";
}

}  // namespace

std::int64_t default_total_vertices(std::int64_t memory) {
  return memory > 0 ? std::max<std::int64_t>(memory / 2 / kBytesPerVertex, 1) : scene::kMaxVertices;
}

std::shared_ptr<const CLI::App> command_line() {
  struct Declared {
    CLI::App parser{kDescription, "kerfd"};
    Arguments arguments;  // The parser refers to them.
  };
  const auto declared = std::make_shared<Declared>();
  declare(declared->parser, declared->arguments);
  return {declared, &declared->parser};
}

Result<std::variant<Config, Notice>> parse_command_line(int argc, const char* const* argv) {
  CLI::App parser(kDescription, "kerfd");
  Arguments arguments;
  declare(parser, arguments);
  try {
    parser.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return std::variant<Config, Notice>(Notice{parser.help()});
  } catch (const CLI::CallForVersion& version) {
    return std::variant<Config, Notice>(Notice{std::string(version.what()) + "\n"});
  } catch (const CLI::ParseError& error) {
    return invalid_argument("BAD_COMMAND_LINE", std::string(error.what()) + " (kerfd --help lists the options)");
  }
  if (!arguments.check_store.empty()) {
    KERF_TRY(check_alone(parser, "--check-store"));
    return check_kept_sheets(arguments.check_store);
  }
  if (!arguments.restore_store.empty()) {
    KERF_TRY(check_alone(parser, "--restore-store", "--data"));
    if (arguments.data_dir.empty() || arguments.data_dir == "none") {
      return invalid_argument("RESTORE_NEEDS_DATA",
                              "--restore-store: give --data DIR as well, a folder that is missing or empty", "--data");
    }
    return restore_kept_sheets(arguments.restore_store, arguments.data_dir);
  }
  if (arguments.list_render_devices) return std::variant<Config, Notice>(Notice{render_device_table()});
  KERF_TRY(check_keeping(parser, arguments));
  return to_config(arguments);
}

}  // namespace kerf::app
