#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <variant>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/on_signal.h"
#include "client/cli/progress.h"
#include "client/load/run.h"
#include "server/base/disk.h"

namespace kerf::cli {
namespace {

struct LoadArguments {
  load::Plan plan;
  std::string grid = "32x32";
  std::string image_size = "640x360";
  std::string transport = "grpc";
  std::string html;  // A file; empty: none.
};

// Checks that a file can be written at `path`; an existing file is left unchanged.
Status check_writable(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  const auto refused = [&](const std::string& why) {
    return unavailable("FILE_IO", "cannot write " + path + ": " + why, "--html");
  };
  if (access(folder.c_str(), W_OK) != 0) return refused(std::generic_category().message(errno));
  if (!std::filesystem::is_directory(folder)) return refused(folder.string() + " is not a folder");
  if (std::filesystem::is_directory(path)) return refused("it is a folder");
  return Nothing{};
}

std::string news_of(const load::Progress& progress) {
  return progress.stage + "  " + std::to_string(progress.frames) + " frames  " + std::to_string(progress.cuts) +
         " cuts  " + std::to_string(progress.errors) + " errors";
}

// Parses the options that hold several numbers in one word. Returns kDone, or an exit code after printing the error.
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
  arguments.plan.server = session.server.address;
  arguments.plan.transport = arguments.transport == "ws" ? load::Transport::kWebSocket : load::Transport::kGrpc;
  if (const int code = read_sizes(arguments); code != kDone) return code;
  if (const Status valid = load::check(arguments.plan); !valid.ok()) return misuse(valid.error().message);
  if (!arguments.html.empty()) {  // Checked before a run that may take half an hour.
    if (const Status writable = check_writable(arguments.html); !writable.ok()) return refuse(writable.error());
  }
  // A token must not be sent in the clear to either address; the files are the same.
  ServerTarget http = session.server;
  if (!arguments.plan.http.empty()) http.address = arguments.plan.http;
  for (const ServerTarget& server : {http, session.server}) {
    client::Result<client::Secrets> secrets = secrets_of(server);
    if (!secrets) return refuse(secrets.failure(), server);
    arguments.plan.secrets = std::move(secrets).value();
  }
  const sigset_t interrupts = block_interrupts();  // Before gRPC starts its threads.
  load::Stopper stopper;
  const Result<load::Report> report = [&] {
    // Ends the run in order, so that its sheets are deleted and its results are printed.
    const OnSignal interrupted(interrupts, [&stopper] { stopper.stop(); });
    ProgressBar bar(session);
    return load::run(
        arguments.plan, [&](const load::Progress& progress) { bar.show(progress.share, news_of(progress)); }, stopper);
  }();
  if (!report.ok()) return refuse(report.error());
  const std::string text = session.json ? load::to_json(*report) : load::to_text(*report);
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (!arguments.html.empty()) {
    RealDisk disk;
    if (const Status written = disk.write_file(arguments.html, load::to_html(*report)); !written.ok()) {
      return refuse(written.error());
    }
  }
  if (load::nobody_joined(*report) && !report->interrupted) {
    return refuse(unavailable("NO_READER", "no reader received a frame: see the report"));
  }
  return kDone;
}

void add_sheet_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--sheets", plan.sheets, "Sheets to make, 1..10000")->capture_default_str();
  command.add_option("--grid", arguments.grid, "Vertices of each, COLUMNSxROWS")->capture_default_str();
  command.add_option("--tick-rate", plan.tick_rate_hz, "Ticks per second, 1..1000")->capture_default_str();
  command.add_flag("--still", plan.still, "Create sheets at rest, which fall asleep (otherwise they keep swinging)");
  command.add_option("--prefix", plan.prefix, "Prefix of the names of the sheets")->capture_default_str();
  command.add_option("--cuts-per-second", plan.cuts_per_second, "Cuts of all sheets together, 0..1000")
      ->capture_default_str();
  command.add_flag("--keep-cuts", plan.keep_cuts, "Do not undo cuts: sheets become finer and slower");
  command.add_option("--seed", plan.seed, "Seed of the random places of cuts")->capture_default_str();
}

void add_reader_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--viewers", plan.viewers, "Readers of frames, spread over the sheets, 0..1000")
      ->capture_default_str();
  command
      .add_option("--viewer-rate", plan.viewer_rate_hz,
                  "Frames per second that they request, 0.001..1000; 0: every tick")
      ->capture_default_str();
  command.add_option("--slow-readers", plan.slow_readers, "Readers that hold every frame for --hold, 0..1000")
      ->capture_default_str();
  command.add_option("--hold", plan.hold_s, "Seconds that slow readers hold a frame, 0.001..60")->capture_default_str();
  command
      .add_option("--stalled-readers", plan.stalled_readers,
                  "Readers that take one frame, then neither read nor acknowledge for --stall, 0..1000")
      ->capture_default_str();
  command
      .add_option("--stall", plan.stall_s,
                  "Seconds that stalled readers stall, 0.001..3600; a server disconnects readers after 10")
      ->capture_default_str();
  command.add_option("--image-viewers", plan.image_viewers, "Readers of pictures, 0..100")->capture_default_str();
  command.add_option("--image-size", arguments.image_size, "Size of their pictures in pixels")->capture_default_str();
  command.add_option("--way", plan.way_ms, "Network delay between readers and server, milliseconds each way")
      ->capture_default_str();
  command.add_option("--way-rate", plan.way_kib_per_s, "Bandwidth of each reader's connection, KiB/s; 0: no limit")
      ->capture_default_str();
}

void add_run_options(CLI::App& command, LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  command.add_option("--duration", plan.duration_s, "Seconds to measure, 0.1..1800")->capture_default_str();
  command.add_option("--warm-up", plan.warm_up_s, "Seconds before that, with everything running")
      ->capture_default_str();
  command.add_option("--http", plan.http,
                     "HTTP address of the server, HOST:PORT: for --transport ws, and for CPU and memory from /metrics");
  command
      .add_option("--transport", arguments.transport, "Transport of frames: grpc, or ws (a WebSocket, as browsers use)")
      ->check(CLI::IsMember({"grpc", "ws"}))
      ->capture_default_str();
  command.add_option("--server-pid", plan.server_pid,
                     "Process of the server on this machine: CPU and memory from /proc");
  command.add_option("--html", arguments.html, "File to write: a report with plots")->type_name(value::kFile);
}

}  // namespace

void add_load_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<LoadArguments>();
  CLI::App* command = app.add_subcommand(
      "load",
      "Put a running server under load and measure it: creates sheets, watches, cuts and deletes them.\n"
      "Latencies count from when something was due, so that stalls are included.\n"
      "Example: kerf load --sheets 64 --viewers 16 --cuts-per-second 10 --duration 30 --html report.html");
  command->group(group::kPhysics);
  add_sheet_options(*command, *arguments);
  add_reader_options(*command, *arguments);
  add_run_options(*command, *arguments);
  command->callback(
      [&session, arguments] { session.action = [&session, arguments] { return run_load(session, *arguments); }; });
}

}  // namespace kerf::cli
