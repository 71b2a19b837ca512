#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "server/app/certificates.h"
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
  std::vector<std::filesystem::path> scenes;  // Scene files, each one sheet.
  int workers = 0;                            // Threads that step sheets, 1..256; 0: one per processor.
  int max_sheets = 64;                        // 1..100,000
  double max_load = 1.0;                      // See host::HostOptions.
  std::int64_t max_total_vertices = 0;        // See host::HostOptions; 0..kMostTotalVertices.
  std::filesystem::path web;                  // Folder of the built viewer; empty: none is served.
  std::filesystem::path docs;                 // Folder of the built documentation; empty: none is served.
  bool render = true;                         // Draws pictures if EGL works.
  std::string render_device = "auto";         // As render::RendererOptions::device; only "auto" may find no device.
  CertificateFiles tls;                       // Both ports speak TLS if it names files.
  bool behind_proxy = false;                  // All clients come through a proxy on this machine.
  std::vector<std::string> allowed_origins;   // Origins of foreign web pages that may use this server.
  std::filesystem::path tokens;               // Token file; empty: everybody may do everything.
  std::filesystem::path audit_log;            // File that gets a line for each change; empty: none.
  std::filesystem::path record_dir;           // Folder of recordings; empty: none.
  std::filesystem::path data_dir;             // Folder in which sheets are kept; empty: they end with the server.
  std::filesystem::path backups_dir;          // Folder of the backups of `data_dir`; empty: "backups" in that.
  bool keeps_nothing = false;                 // As asked by `--data none`.
  double max_replay_s = 2.0;                  // See host::HostOptions::max_unsaved_cpu; 0.01..3600.
  bool fresh = false;                         // Replaces kept sheets of `scenes` even if clients changed them.
  int max_connections_per_address = 128;      // 1..10,000, for gRPC and for HTTP; 0: no limit.
  api::Limits limits;                         // For requests and streams.
  ws::HttpOptions http_options;  // For HTTP; allowed_origins and limits on connections come from elsewhere.
};

inline constexpr std::int64_t kMostTotalVertices = 1'000'000'000'000;

// Memory per vertex in bytes, with the implicit integrator; the explicit one takes little more than half.
inline constexpr std::int64_t kBytesPerVertex = 8'000;

// Returns the default of --max-total-vertices for a process that may use `memory` bytes. Sheets get half of that; the
// other half is for streams, pictures and the rest of the machine. If `memory` is 0 (unknown), it is the number of
// vertices of one sheet of the largest size.
std::int64_t default_total_vertices(std::int64_t memory);

// Holds the text printed by --help and --version.
struct Notice {
  std::string text;
  int status = 0;  // with which the program ends
};

// Returns the options of kerfd, for its manual.
std::shared_ptr<const CLI::App> command_line();

// Parses the command line of kerfd. Errors are INVALID_ARGUMENT with a one-line message. Listening on an address that
// other machines can reach is refused without TLS and tokens, and for gRPC without certificates of clients.
Result<std::variant<Config, Notice>> parse_command_line(int argc, const char* const* argv);

// Returns what --check-store prints of a folder of kept sheets. Errors: kInvalidArgument, with the reason of
// store::check_store().
Result<std::variant<Config, Notice>> check_kept_sheets(const std::string& folder);
// Makes a folder of kept sheets from a backup, and returns what --restore-store prints. `folder` must be missing or
// empty. Errors: kInvalidArgument, with the reason of store::restore_store(), RESTORE_INTO_ITSELF or BAD_DATA_DIR;
// nothing is made then.
Result<std::variant<Config, Notice>> restore_kept_sheets(const std::string& backup, const std::string& folder);
// Checks the folder of --backups: it can be made or written, and is not one of the store in `data`, nor around that.
// Error: kInvalidArgument BAD_BACKUPS_DIR.
Status check_backups_directory(const std::filesystem::path& backups, const std::filesystem::path& data);
// Returns a path that does not depend on the folder in which kerfd was started, where that is known.
std::filesystem::path made_absolute(std::filesystem::path path);
// Returns the user's folder for kept sheets: $XDG_DATA_HOME/kerf, else $HOME/.local/share/kerf. Empty if neither is
// set.
std::filesystem::path default_data_directory();

}  // namespace kerf::app
