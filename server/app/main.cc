#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <ratio>
#include <semaphore>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include "server/app/config.h"
#include "server/app/server.h"
#include "server/app/site_folders.h"
#include "server/service/wire/protobuf_log.h"

namespace {

constexpr int kExitRefused = 2;
constexpr std::chrono::nanoseconds kStopLimit = std::chrono::milliseconds(9000);  // Measured from the signal.
constexpr std::chrono::nanoseconds kEchoTime = std::chrono::seconds(1);

// Prints a line on stderr, from any thread.
void note(std::string_view line) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  std::cerr.clear();  // A full disk behind a redirection may have room again.
  std::cerr << "kerfd: " + std::string(line) + "\n" << std::flush;
}

// Blocks the stop signals in every thread, so that only wait_for_stop() receives them.
sigset_t block_stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Released by the first signal.
std::binary_semaphore stop_has_begun{0};

// Ignores signals within kEchoTime of the first: a terminal and a script around kerfd may both send one. The next
// signal then ends the process at once. So does kStopLimit, with success if all sheets are closed and only threads and
// connections remain.
void guard_the_stop(sigset_t signals, const std::weak_ptr<const kerf::app::Server>& running) {
  stop_has_begun.acquire();
  const auto begin = std::chrono::steady_clock::now();
  const auto end = begin + kEchoTime;
  for (auto left = kEchoTime; left.count() > 0;) {
    const timespec wait{left.count() / std::nano::den, left.count() % std::nano::den};
    sigtimedwait(&signals, nullptr, &wait);
    left = end - std::chrono::steady_clock::now();
  }
  std::signal(SIGTERM, SIG_DFL);
  std::signal(SIGINT, SIG_DFL);  // Shells make programs in the background ignore SIGINT.
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  std::this_thread::sleep_until(begin + kStopLimit);
  const std::shared_ptr<const kerf::app::Server> server = running.lock();
  const bool is_done = !server || server->has_closed_sheets();
  note(is_done ? "stopped; connections that do not close are left to the system" : "the sheets did not stop in time");
  _exit(is_done ? EXIT_SUCCESS : EXIT_FAILURE);
}

// True if this process is to outlive its terminal, as with nohup.
bool ignores_hang_up() {
  struct sigaction action {};
  sigaction(SIGHUP, nullptr, &action);
  return action.sa_handler == SIG_IGN;
}

// Waits for the first SIGTERM or SIGINT. A SIGHUP has files read again; if there are none, it stops the server as well.
void wait_for_stop(const sigset_t& signals, kerf::app::Server& server) {
  int signal = 0;
  do {
    sigwait(&signals, &signal);
  } while (signal == SIGHUP && (server.reload() || ignores_hang_up()));
  stop_has_begun.release();
}

// Makes threads share memory arenas if addresses are limited (ulimit -v): arenas of their own reserve too many.
void share_memory_between_threads() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) mallopt(M_ARENA_MAX, 2);
}

// Starts the server; returns null after printing the reason if it does not start.
std::shared_ptr<kerf::app::Server> start(const kerf::app::Config& config) {
  try {
    auto started = kerf::app::Server::start(config, note);
    if (started.ok()) return std::move(started).value();
    note(started.error().message);
  } catch (const std::exception& error) {  // No memory, or no thread.
    note("the system lacks resources for this server: " + std::string(error.what()));
  }
  return nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  share_memory_between_threads();

  // Silences gRPC: kerfd itself reports errors, on one line.
  setenv("GRPC_VERBOSITY", "NONE", 0);  // NOLINT(concurrency-mt-unsafe): before there is a second thread
  kerf::wire::discard_protobuf_log();   // Faults of a message are reported to its sender.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);  // A file beyond `ulimit -f` is a failed write.
  const sigset_t signals = block_stop_signals();

  auto parsed = kerf::app::parse_command_line(argc, argv);
  if (!parsed.ok()) {
    note(parsed.error().message);
    return kExitRefused;
  }
  if (const auto* notice = std::get_if<kerf::app::Notice>(&*parsed)) {
    std::cout << notice->text;
    return notice->status;
  }
  auto config = std::get<kerf::app::Config>(std::move(parsed).value());
  std::error_code ignored;
  const std::filesystem::path executable = std::filesystem::read_symlink("/proc/self/exe", ignored);
  if (config.data_dir.empty() && !config.keeps_nothing) config.data_dir = kerf::app::default_data_directory();
  if (config.data_dir.empty() && !config.keeps_nothing) {
    note(
        "there is no folder for kept sheets, as neither XDG_DATA_HOME nor HOME is set; give --data DIR, or --data "
        "none");
    return kExitRefused;
  }
  if (config.web.empty()) config.web = kerf::app::default_web_directory(executable);
  if (config.docs.empty()) config.docs = kerf::app::default_docs_directory(executable);

  const std::shared_ptr<kerf::app::Server> server = start(config);
  if (!server) return kExitRefused;
  // Started now, because there may be no memory for a thread when the server stops.
  std::thread(guard_the_stop, signals, std::weak_ptr<const kerf::app::Server>(server)).detach();
  std::cout << server->ready_line() << std::endl;
  wait_for_stop(signals, *server);
  note("stopping");
  server->stop();
  return EXIT_SUCCESS;
}
