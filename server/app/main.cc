#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <ratio>
#include <semaphore>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>

#include <unistd.h>

#include "server/app/config.h"
#include "server/app/server.h"
#include "server/wire/protobuf_log.h"

namespace {

constexpr int kExitRefused = 2;
constexpr unsigned kStopLimitS = 10;
constexpr std::chrono::nanoseconds kEchoTime = std::chrono::seconds(1);

// Prints a line on stderr, from any thread.
void note(std::string_view line) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  std::cerr.clear();  // a full disk behind a redirection may be one no longer
  std::cerr << "kerfd: " + std::string(line) + "\n" << std::flush;
}

// Blocked in every thread, so that only wait_for_stop() sees them.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Released by the first signal.
std::binary_semaphore stop_has_begun{0};

// Takes what comes within kEchoTime of the first signal: one wish to stop, told by the terminal and by a script around
// kerfd that passes it on. The next signal then ends the process, wherever it is.
void guard_the_stop(sigset_t signals) {
  stop_has_begun.acquire();
  const auto end = std::chrono::steady_clock::now() + kEchoTime;
  for (auto left = kEchoTime; left.count() > 0;) {
    const timespec wait{left.count() / std::nano::den, left.count() % std::nano::den};
    sigtimedwait(&signals, nullptr, &wait);
    left = end - std::chrono::steady_clock::now();
  }
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGINT, SIG_DFL);  // a shell has the programs that it starts in the background ignore it
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  while (true) pause();
}

// Until the first SIGTERM or SIGINT. A later one ends the process as usual, and so does a stop that takes too long.
void wait_for_stop(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  alarm(kStopLimitS);
  stop_has_begun.release();
}

}  // namespace

int main(int argc, char** argv) {
  // What matters is told by kerfd itself, on one line.
  setenv("GRPC_VERBOSITY", "NONE", 0);  // NOLINT(concurrency-mt-unsafe): before there is a second thread
  kerf::wire::discard_protobuf_log();   // what is wrong with a message is told to its sender
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond `ulimit -f` is a write that fails
  const sigset_t signals = block_stop_signals();

  auto parsed = kerf::app::parse_command_line(argc, argv);
  if (!parsed) {
    note(parsed.error().message);
    return kExitRefused;
  }
  if (const auto* notice = std::get_if<kerf::app::Notice>(&*parsed)) {
    std::cout << notice->text;
    return EXIT_SUCCESS;
  }
  auto config = std::get<kerf::app::Config>(std::move(parsed).value());
  if (config.web.empty()) {
    std::error_code ignored;
    config.web = kerf::app::default_web_directory(std::filesystem::read_symlink("/proc/self/exe", ignored));
  }

  auto server = kerf::app::Server::start(config, note);
  if (!server) {
    note(server.error().message);
    return kExitRefused;
  }
  std::thread(guard_the_stop, signals).detach();  // now, as the stop may find no memory for it; ends with the process
  std::cout << (*server)->ready_line() << std::endl;
  wait_for_stop(signals);
  note("stopping");
  (*server)->stop();
  return EXIT_SUCCESS;
}
