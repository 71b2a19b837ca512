#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "server/base/result.h"
#include "server/service/api/api.h"
#include "server/service/ws/access.h"
#include "server/service/ws/http_server.h"

namespace CLI {
class App;
}

namespace kerf::app {

struct Config {
  ws::Endpoint grpc{"127.0.0.1", 50051};
  ws::Endpoint http{"127.0.0.1", 8080};
  std::vector<std::filesystem::path> scenes;  // scene files, each one sheet
  int workers = 0;                            // threads that step sheets, 1..256; 0: one for each processor
  int max_sheets = 64;                        // 1..100,000
  double max_load = 1.0;                      // see host::HostOptions
  std::int64_t max_total_vertices = 0;        // likewise, 0..kMostTotalVertices
  std::filesystem::path web;                  // the built viewer; empty: none is served
  bool render = true;                         // pictures, where EGL works
  std::string render_device = "auto";         // as render::RendererOptions::device; nothing else than "auto" may fail
  bool allow_remote = false;                  // may listen on other than loopback addresses
  std::vector<std::string> allowed_origins;   // web pages of other origins that may use this server
  std::filesystem::path record_dir;           // where recordings go; empty: none
  int max_connections_per_address = 128;      // 1..10,000, each of gRPC and HTTP; 0: no limit
  api::Limits limits;                         // of requests and streams
  ws::HttpOptions http_options;               // of HTTP connections; its access is replaced by allowed_origins
};

inline constexpr std::int64_t kMostTotalVertices = 1'000'000'000'000;

// What a vertex takes, in bytes, with the implicit integrator; with the explicit one it is little more than half.
inline constexpr std::int64_t kBytesPerVertex = 8'000;

// How many vertices all sheets together may have where the process may have so much memory, in bytes, unless
// --max-total-vertices says otherwise: as many as fit in half of it, the other half being for streams, pictures and the
// rest of the machine. One sheet of the largest size where nothing says how much: 0.
std::int64_t default_total_vertices(std::int64_t memory);

// What --help and --version print.
struct Notice {
  std::string text;
};

// The options of kerfd, for its manual.
std::shared_ptr<const CLI::App> command_line();

// The command line of kerfd. Refusals are INVALID_ARGUMENT with a one-line message; listening on an address that other
// machines can reach is refused unless --allow-remote is given.
Result<std::variant<Config, Notice>> parse_command_line(int argc, const char* const* argv);

// Where the built viewer is unless --web says otherwise: share/kerf/web beside the executable's folder, where `cmake
// --install` puts it, else web/dist of a source tree above the executable; empty if neither has an index.html.
std::filesystem::path default_web_directory(const std::filesystem::path& executable);

}  // namespace kerf::app
