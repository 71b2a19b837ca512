#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/suggestions.h"
#include "client/cpp/result.h"

namespace {

// Takes the server from the environment; options of the command line come later and win.
void read_environment(kerf::cli::ServerTarget& server) {
  const std::pair<const char*, std::string&> variables[] = {{"KERF_SERVER", server.address},
                                                            {"KERF_TOKEN_FILE", server.credentials.token_file},
                                                            {"KERF_TLS_CA", server.credentials.tls_ca},
                                                            {"KERF_TLS_CERT", server.credentials.tls_cert},
                                                            {"KERF_TLS_KEY", server.credentials.tls_key}};
  for (const auto& [name, place] : variables) {
    if (const char* value = std::getenv(name)) place = value;  // NOLINT(concurrency-mt-unsafe)
  }
}

int run(int argc, char** argv) {
  kerf::cli::Session session;
  read_environment(session.server);
  const std::unique_ptr<CLI::App> app = kerf::cli::make_app(session);

  // Completes an unfinished command line, which must not be parsed as a whole.
  if (argc > 1 && std::string_view(argv[1]) == "__complete") {
    session.server.address = kerf::cli::with_port(session.server.address);
    return kerf::cli::print_completion(*app, {argv + 2, argv + argc}, session.server);
  }
  // --json takes effect even if other words cannot be parsed.
  if (std::find(argv, argv + argc, std::string_view("--json")) != argv + argc) kerf::cli::refuse_in_json();
  try {
    app->parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help or --version
    return app->exit(asked);
  } catch (const CLI::ParseError& error) {
    return kerf::cli::misuse(kerf::cli::explain(*app, error));
  }
  session.server.address = kerf::cli::with_port(session.server.address);
  try {
    return session.action();
  } catch (const kerf::client::CallFailed& refused) {  // The credentials cannot be used.
    return kerf::cli::refuse(refused.failure, session.server);
  }
}

// Checks that the output was written: it may be lost on a full disk behind a redirection.
int flushed(int code) {
  errno = 0;
  if ((std::fflush(stdout) == 0 && std::ferror(stdout) == 0) || code != kerf::cli::kDone) return code;
  return kerf::cli::refuse(kerf::resource_exhausted(
      "OUTPUT_NOT_WRITTEN",
      "cannot write standard output: " + std::generic_category().message(errno == 0 ? EIO : errno)));
}

}  // namespace

int main(int argc, char** argv) {
  // Keeps gRPC's own lines from standard error, where --json has one line of JSON.
  setenv("GRPC_VERBOSITY", "NONE", 0);  // NOLINT(concurrency-mt-unsafe)
  std::signal(SIGXFSZ, SIG_IGN);        // A file beyond `ulimit -f` is a failed write, and reported.
  try {
    return flushed(run(argc, argv));
  } catch (const std::exception& error) {
    return kerf::cli::refuse(kerf::internal_error("EXCEPTION", error.what()));
  }
}
