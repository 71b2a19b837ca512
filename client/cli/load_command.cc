#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/load/run.h"
#include "server/host/disk.h"

namespace kerf::cli {
namespace {

struct LoadArguments {
  load::Plan plan;
  std::string grid = "32x32";
  std::string image_size = "640x360";
  std::string transport = "grpc";
  std::string html;  // a file; empty: none
};

// SIGINT and SIGTERM end a run in good order, so that its sheets are deleted and what was measured is told; a second
// one ends the program at once. Signals are taken by a thread of their own, as nothing of a run may be called from a
// handler.
class EndOnSignal {
 public:
  explicit EndOnSignal(load::Stopper& stopper) {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    sigaddset(&signals_, SIGUSR1);  // this object's own, to end the thread
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    thread_ = std::thread([this, &stopper] {
      int signal = 0;
      bool asked = false;
      while (sigwait(&signals_, &signal) == 0 && signal != SIGUSR1) {
        if (asked) _exit(kRefused);
        asked = true;
        stopper.stop();
      }
    });
  }
  ~EndOnSignal() {
    pthread_kill(thread_.native_handle(), SIGUSR1);
    thread_.join();
  }
  EndOnSignal(const EndOnSignal&) = delete;
  EndOnSignal& operator=(const EndOnSignal&) = delete;

 private:
  sigset_t signals_{};
  std::thread thread_;
};

// A line on stderr that is written over and over, where that is a terminal.
class StatusLine {
 public:
  void show(const load::Progress& progress) {
    if (!live_) return;
    constexpr int kWide = 30;
    const int full = static_cast<int>(progress.share * kWide);
    std::fprintf(stderr, "\r%-13s [%s%s] %3.0f %%  %lld frames  %lld cuts  %lld errors\033[K", progress.stage.c_str(),
                 std::string(static_cast<std::size_t>(full), '#').c_str(),
                 std::string(static_cast<std::size_t>(kWide - full), '.').c_str(), 100.0 * progress.share,
                 static_cast<long long>(progress.frames), static_cast<long long>(progress.cuts),
                 static_cast<long long>(progress.errors));
  }
  void clear() const {
    if (live_) std::fprintf(stderr, "\r\033[K");
  }

 private:
  const bool live_ = isatty(STDERR_FILENO) != 0;
};

// What is written in one word, as numbers; kDone, or the exit code of what is wrong, which has been said.
int read_sizes(LoadArguments& arguments) {
  const Parsed<GridSize> grid = parse_grid(arguments.grid);
  if (const auto* wrong = std::get_if<UsageError>(&grid)) return misuse("--grid: " + wrong->message);
  arguments.plan.columns = std::get<GridSize>(grid).columns;
  arguments.plan.rows = std::get<GridSize>(grid).rows;
  const Parsed<ImageSize> image = parse_image_size(arguments.image_size);
  if (const auto* wrong = std::get_if<UsageError>(&image)) return misuse("--image-size: " + wrong->message);
  arguments.plan.image_width = std::get<ImageSize>(image).width;
  arguments.plan.image_height = std::get<ImageSize>(image).height;
  return kDone;
}

int run_load(const Session& session, LoadArguments& arguments) {
  arguments.plan.server = session.server;
  arguments.plan.transport = arguments.transport == "ws" ? load::Transport::kWebSocket : load::Transport::kGrpc;
  if (const int code = read_sizes(arguments); code != kDone) return code;
  if (const Status valid = load::check(arguments.plan); !valid) return misuse(valid.error().message);
  host::RealDisk disk;
  if (!arguments.html.empty()) {  // sooner than after a run of half an hour
    if (const Status writable = disk.write_file(arguments.html, ""); !writable) return refuse(writable.error());
  }
  load::Stopper stopper;
  StatusLine line;
  const Result<load::Report> report = [&] {
    const EndOnSignal end(stopper);
    return load::run(
        arguments.plan, [&](const load::Progress& progress) { line.show(progress); }, stopper);
  }();
  line.clear();
  if (!report) return refuse(report.error());
  const std::string text = session.json ? load::to_json(*report) : load::to_text(*report);
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (!arguments.html.empty()) {
    if (const Status written = disk.write_file(arguments.html, load::to_html(*report)); !written) {
      return refuse(written.error());
    }
  }
  return kDone;
}

void add_sheet_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--sheets", plan.sheets, "Sheets to make, 1..10000")->capture_default_str();
  command.add_option("--grid", arguments.grid, "Vertices of each, COLUMNSxROWS")->capture_default_str();
  command.add_option("--tick-rate", plan.tick_rate_hz, "Ticks a second, 1..1000")->capture_default_str();
  command.add_flag("--still", plan.still,
                   "Sheets that nothing moves, which fall asleep (else they swing all the time)");
  command.add_option("--prefix", plan.prefix, "Names of the sheets begin with this")->capture_default_str();
  command.add_option("--cuts-per-second", plan.cuts_per_second, "Cuts of all sheets together, 0..1000")
      ->capture_default_str();
  command.add_flag("--keep-cuts", plan.keep_cuts, "Do not take cuts back: sheets become finer and dearer");
  command.add_option("--seed", plan.seed, "Of where cuts go")->capture_default_str();
}

void add_reader_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--viewers", plan.viewers, "Readers of frames, shared out among the sheets, 0..1000")
      ->capture_default_str();
  command
      .add_option("--viewer-rate", plan.viewer_rate_hz, "Frames a second that they ask for, 0.001..1000; 0: every tick")
      ->capture_default_str();
  command.add_option("--slow-readers", plan.slow_readers, "Readers that hold every frame for --hold, 0..1000")
      ->capture_default_str();
  command.add_option("--hold", plan.hold_s, "Seconds, 0.001..60")->capture_default_str();
  command
      .add_option("--stalled-readers", plan.stalled_readers,
                  "Readers that take one frame, neither read nor acknowledge for --stall, then tell how they were "
                  "ended, 0..1000")
      ->capture_default_str();
  command.add_option("--stall", plan.stall_s, "Seconds, 0.001..3600; a server ends readers after 10")
      ->capture_default_str();
  command.add_option("--image-viewers", plan.image_viewers, "Readers of pictures, 0..100")->capture_default_str();
  command.add_option("--image-size", arguments.image_size, "Of their pictures, in pixels")->capture_default_str();
  command
      .add_option("--way", plan.way_ms, "Milliseconds that the way between readers and server takes, each direction")
      ->capture_default_str();
  command
      .add_option("--way-rate", plan.way_kib_per_s, "KiB/s that each reader's connection passes at most; 0: no limit")
      ->capture_default_str();
}

void add_run_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--duration", plan.duration_s, "Seconds that are measured, 0.1..1800")->capture_default_str();
  command.add_option("--warm-up", plan.warm_up_s, "Seconds before, with everything running")->capture_default_str();
  command.add_option(
      "--http", plan.http,
      "The viewer's port of the server, HOST:PORT: for --transport ws, and for CPU and memory from /metrics");
  command
      .add_option("--transport", arguments.transport, "Of readers of frames: grpc, or ws (a WebSocket, as browsers)")
      ->check(CLI::IsMember({"grpc", "ws"}))
      ->capture_default_str();
  command.add_option("--server-pid", plan.server_pid, "Its process on this machine: the same, from /proc");
  command.add_option("--html", arguments.html, "File to write: a report with plots")->type_name(value::kFile);
}

}  // namespace

void add_load_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<LoadArguments>();
  CLI::App* command = app.add_subcommand(
      "load",
      "Put a running server under load and measure it: makes sheets, watches and cuts them, deletes them again.\n"
      "Latencies count from when something should have happened, so that a stall is not left out.\n"
      "Example: kerf load --sheets 64 --viewers 16 --cuts-per-second 10 --duration 30 --html report.html");
  command->group(group::kPhysics);
  add_sheet_options(*command, *arguments);
  add_reader_options(*command, *arguments);
  add_run_options(*command, *arguments);
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return run_load(session, *arguments); }; });
}

}  // namespace kerf::cli
