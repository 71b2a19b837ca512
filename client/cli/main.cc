#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/commands.h"

namespace {

int run(int argc, char** argv) {
  kerf::cli::Session session;
  if (const char* server = std::getenv("KERF_SERVER")) session.server = server;  // NOLINT(concurrency-mt-unsafe)

  CLI::App app{"kerf: cut, watch and run elastic sheets. Start a server with kerfd (or deploy/run)."};
  app.set_version_flag("--version", std::string("kerf ") + KERF_VERSION);
  app.add_option("--server", session.server, "Server's gRPC address, HOST:PORT (or environment KERF_SERVER)")
      ->capture_default_str();
  app.add_flag("--json", session.json, "Print replies as JSON");
  app.fallthrough();  // --server and --json may stand after the subcommand too
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done (a cut that misses included), 1 refused with the reason on stderr, 2 wrong usage.\n"
      "Help on a command: kerf COMMAND --help");

  kerf::cli::add_sheet_commands(app, session);
  kerf::cli::add_cut_command(app, session);
  kerf::cli::add_cuts_commands(app, session);
  kerf::cli::add_view_commands(app, session);
  kerf::cli::add_offline_commands(app, session);
  kerf::cli::add_analyze_command(app, session);
  kerf::cli::add_load_command(app, session);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kerf::cli::kDone : kerf::cli::kWrongUsage;
  }
  return session.action();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kerf: %s\n", error.what());
    return kerf::cli::kRefused;
  }
}
