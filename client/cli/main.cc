#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/suggestions.h"

namespace {

int run(int argc, char** argv) {
  kerf::cli::Session session;
  if (const char* server = std::getenv("KERF_SERVER")) session.server = server;  // NOLINT(concurrency-mt-unsafe)
  const std::unique_ptr<CLI::App> app = kerf::cli::make_app(session);

  // Completes an unfinished command line, which must not be parsed as a whole.
  if (argc > 1 && std::string_view(argv[1]) == "__complete") {
    return kerf::cli::print_completion(*app, {argv + 2, argv + argc}, kerf::cli::with_port(session.server));
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
  session.server = kerf::cli::with_port(session.server);
  return session.action();
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
  std::signal(SIGXFSZ, SIG_IGN);  // A file beyond `ulimit -f` is a failed write, and reported.
  try {
    return flushed(run(argc, argv));
  } catch (const std::exception& error) {
    return kerf::cli::refuse(kerf::internal_error("EXCEPTION", error.what()));
  }
}
