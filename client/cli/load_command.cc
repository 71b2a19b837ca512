#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/load_scenario.h"
#include "client/cli/on_signal.h"
#include "client/cli/progress.h"
#include "client/cli/suggestions.h"
#include "client/load/comparison.h"
#include "client/load/metrics.h"
#include "client/load/run.h"
#include "server/base/disk.h"

namespace kerf::cli {
namespace {

struct LoadArguments {
  load::Plan plan;
  std::string grid = "32x32";
  std::string image_size = "640x360";
  std::string transport = "grpc";
  std::string cut_kind = "slit";
  std::string stages;
  std::string stages_of = "viewers";
  std::vector<std::string> fail_if;
  std::string scenario;  // Files; empty: none.
  std::string html;
  std::string csv;
  std::string csv_summary;
  std::vector<std::string> compare;  // Two files of reports, or none.
};

struct OutputFile {
  const char* option;
  const std::string& path;
};
std::array<OutputFile, 3> files_of(const LoadArguments& arguments) {
  return {{{"--html", arguments.html}, {"--csv", arguments.csv}, {"--csv-summary", arguments.csv_summary}}};
}

// Checks that a file can be written at `path`; an existing file is left unchanged.
Status check_writable(const OutputFile& file) {
  const std::string& path = file.path;
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  const auto refused = [&](const std::string& why) {
    return unavailable("FILE_IO", "cannot write " + path + ": " + why, file.option);
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

// Parses the conditions, the stages and the choices. Returns kDone, or an exit code after printing the error.
int read_choices(LoadArguments& arguments) {
  load::Plan& plan = arguments.plan;
  plan.transport = arguments.transport == "ws" ? load::Transport::kWebSocket : load::Transport::kGrpc;
  for (const auto& [name, kind] : load::kCutKinds) {
    if (name == arguments.cut_kind) plan.cut_kind = kind;
  }
  if (!arguments.stages.empty()) {
    Result<std::vector<load::Stage>> stages = load::parse_stages(arguments.stages);
    if (!stages.ok()) return misuse(stages.error().message);
    load::set_stages(*std::move(stages),
                     arguments.stages_of == "sheets" ? load::Staged::kSheets : load::Staged::kViewers, plan);
  }
  for (const std::string& text : arguments.fail_if) {
    const Result<load::Condition> condition = load::parse_condition(text);
    if (condition.ok()) {
      plan.fail_if.push_back(*condition);
      continue;
    }
    std::string hint;
    if (condition.error().reason == "UNKNOWN_METRIC") {
      std::vector<std::string> names;
      for (const load::Metric& metric : load::metrics()) names.push_back(metric.name);
      hint = did_you_mean(near_names(load::metric_word(text), names)) + " `kerf load --help` lists all";
    }
    return misuse("--fail-if: " + condition.error().message + hint);
  }
  return kDone;
}

// Returns the exit code of the conditions, after a line on stderr for each that did not pass; none with --json, whose
// report has them.
int code_of(const Session& session, const std::vector<load::Judgement>& judged) {
  using Verdict = load::Judgement::Verdict;
  int code = kDone;
  for (const load::Judgement& judgement : judged) {
    if (judgement.verdict == Verdict::kPassed) continue;
    if (!session.json) std::fprintf(stderr, "kerf: --fail-if %s\n", load::describe(judgement).c_str());
    if (judgement.verdict == Verdict::kFailed) code = kFailed;
    if (judgement.verdict == Verdict::kUndecided && code == kDone) code = kUndecided;
  }
  return code;
}

// Prints two reports side by side.
int compare(const Session& session, const LoadArguments& arguments) {
  constexpr std::size_t kMostReportBytes = 64 << 20;
  RealDisk disk;
  std::array<load::NamedReport, 2> reports;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    Result<std::string> text = disk.read_file(arguments.compare[i], kMostReportBytes);
    if (!text.ok()) return refuse(text.error());
    reports[i] = {arguments.compare[i], *std::move(text)};
  }
  const Result<load::Comparison> comparison = load::compare(reports[0], reports[1]);
  if (!comparison.ok()) return refuse(comparison.error());
  const Result<std::vector<load::Judgement>> judged = load::judge(*comparison, arguments.plan.fail_if);
  if (!judged.ok()) return misuse(judged.error().message);
  std::fputs((session.json ? load::to_json(*comparison, *judged) : load::to_text(*comparison)).c_str(), stdout);
  if (!arguments.html.empty()) {
    const Status written = disk.write_file(arguments.html, load::to_html(*comparison));
    if (!written.ok()) return refuse(written.error());
  }
  return code_of(session, *judged);
}

// Writes the report to the files asked for.
Status write_files(const LoadArguments& arguments, const load::Report& report) {
  RealDisk disk;
  if (!arguments.html.empty()) KERF_TRY(disk.write_file(arguments.html, load::to_html(report)));
  if (!arguments.csv.empty()) KERF_TRY(disk.write_file(arguments.csv, load::to_interval_csv(report)));
  if (!arguments.csv_summary.empty()) KERF_TRY(disk.write_file(arguments.csv_summary, load::to_summary_csv(report)));
  return Nothing{};
}

int run_load(const Session& session, const CLI::App& command, LoadArguments& arguments) {
  if (!arguments.scenario.empty()) {
    if (const Status read = read_scenario(command, arguments.scenario); !read.ok()) return refuse(read.error());
  }
  arguments.plan.server = session.server.address;
  if (const int code = read_choices(arguments); code != kDone) return code;
  if (!arguments.compare.empty()) return compare(session, arguments);
  if (const int code = read_sizes(arguments); code != kDone) return code;
  if (const Status valid = load::check(arguments.plan); !valid.ok()) return misuse(valid.error().message);
  for (const OutputFile& file : files_of(arguments)) {  // Checked before a run that may take half an hour.
    if (file.path.empty()) continue;
    if (const Status writable = check_writable(file); !writable.ok()) return refuse(writable.error());
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
  if (const Status written = write_files(arguments, *report); !written.ok()) return refuse(written.error());
  if (load::nobody_joined(*report) && !report->interrupted) {
    return refuse(unavailable("NO_READER", "no reader received a frame: see the report"));
  }
  return code_of(session, load::judge(*report));
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
  command.add_option("--cut-kind", arguments.cut_kind, "Shape of the cuts, each at most 0.1 m long")
      ->check(CLI::IsMember({"slit", "curve", "circle", "star", "drawing", "mixed"}))
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
}

void add_stage_options(CLI::App& command, LoadArguments& arguments) {
  command
      .add_option("--stages", arguments.stages,
                  "Stages of the run in place of --duration and of the number of viewers or sheets, such as "
                  "10s:4,30s:16,10s:0: from 0 evenly to 4 in 10 s, then to 16, then to none")
      ->type_name("LENGTH:TARGET,...");
  command.add_option("--stages-of", arguments.stages_of, "Stages count viewers, or sheets, which run while they count")
      ->check(CLI::IsMember({"viewers", "sheets"}))
      ->capture_default_str();
  command
      .add_option(
          "--fail-if", arguments.fail_if,
          "Condition under which the run has failed, such as \"cut_p99>50ms\"; repeatable. Exit code 3 if one "
          "holds, 4 if none does and one has too few values. With --compare limits are ratios: \"cut_p99>1.2x\"")
      ->type_name("CONDITION")
      ->take_all();
  command.add_option("--scenario", arguments.scenario, "File with options as JSON, such as deploy/examples/load.json")
      ->type_name(value::kFile);
}

void add_output_options(CLI::App& command, LoadArguments& arguments) {
  command.add_option("--html", arguments.html, "File to write: a report with plots")->type_name(value::kFile);
  command.add_option("--csv", arguments.csv, "File to write: a line for each interval of a second or more")
      ->type_name(value::kFile);
  command.add_option("--csv-summary", arguments.csv_summary, "File to write: a line for each metric")
      ->type_name(value::kFile);
  command
      .add_option("--compare", arguments.compare,
                  "Print two reports of `kerf --json load` side by side, with ratios, and run nothing; --html also")
      ->type_name("FILE FILE")
      ->expected(2);
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
  add_stage_options(*command, *arguments);
  add_output_options(*command, *arguments);
  command->footer("Metrics of --fail-if. " + load::list_of_metrics());
  command->callback([&session, command, arguments] {
    session.action = [&session, command, arguments] { return run_load(session, *command, *arguments); };
  });
}

}  // namespace kerf::cli
