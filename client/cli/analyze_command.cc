#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/progress.h"
#include "client/cli/tables.h"
#include "client/cpp/client.h"
#include "kerf/v1/sheets.grpc.pb.h"
#include "server/base/disk.h"
#include "server/service/wire/json.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxRequestBytes = std::size_t{1} << 20;

struct AnalyzeArguments {
  std::string id;
  std::string file;
  std::int32_t modes = 0;
  bool resting = false;
  std::int32_t steps = 0;
  double tolerance = 0.0;
  bool dynamic = false;
  std::int64_t ticks = 0;
  std::int32_t every = 1;
  std::string csv;
};

// Sets the static analysis requested by options.
void set_static(const AnalyzeArguments& arguments, v1::StaticAnalysis& message) {
  message.set_steps(arguments.steps);
  message.set_tolerance(arguments.tolerance);
}

int analyze(const Session& session, const AnalyzeArguments& arguments) {
  RealDisk disk;
  v1::AnalyzeSheetRequest request;
  if (!arguments.file.empty()) {
    const Result<std::string> json = disk.read_file(arguments.file, kMaxRequestBytes);
    if (!json.ok()) return refuse(json.error());
    if (const Status read = wire::from_json(*json, request); !read.ok()) return refuse(read.error());
    if (arguments.dynamic && request.has_analysis()) {
      return misuse("--dynamic sets the analysis, but " + arguments.file + " has one: leave one of them out");
    }
  }
  if (arguments.dynamic) {
    v1::DynamicAnalysis& dynamic = *request.mutable_analysis()->mutable_dynamic();
    dynamic.set_ticks(arguments.ticks);
    dynamic.set_measure_every(arguments.every);
  } else if (arguments.modes > 0) {
    request.mutable_analysis()->mutable_modes()->set_count(arguments.modes);
    if (arguments.resting) set_static(arguments, *request.mutable_analysis()->mutable_modes()->mutable_about());
  } else if (arguments.file.empty()) {
    set_static(arguments, *request.mutable_analysis()->mutable_static_());
  }
  request.set_name("sheets/" + arguments.id);
  client::Client client = connect(session.server);
  v1::AnalyzeSheetResponse response;
  const grpc::Status status = [&] {
    const WaitingNote note(session, "analysing");
    return client.call(&v1::SheetService::Stub::AnalyzeSheet, client.sheets(), request, response,
                       std::chrono::hours(24));
  }();
  if (!status.ok()) return refuse(status, session.server);
  if (const Status written = write_csv(disk, arguments.csv, response.tables()); !written.ok()) {
    return refuse(written.error());
  }
  if (session.json) {
    std::printf("%s\n", to_script_json(response).c_str());
  } else {
    std::string text = response.name() + " as it was at tick " + std::to_string(response.tick());
    if (response.has_static_()) text += "\n  " + describe(response.static_());
    if (response.has_dynamic()) text += "\n  " + describe(response.dynamic());
    for (const v1::Table& table : response.tables()) text += excerpt(table);
    std::printf("%s\n", text.c_str());
  }
  return response.has_static_() ? check_converged(response.static_()) : kDone;
}

}  // namespace

void add_analyze_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<AnalyzeArguments>();
  CLI::App* analyzing =
      app.add_subcommand("analyze",
                         "Compute the equilibrium, the vibrations or the next ticks of a sheet, on a copy:\n"
                         "the sheet itself keeps running.\n"
                         "Examples: kerf analyze cloth\n"
                         "          kerf analyze cloth --modes 6\n"
                         "          kerf analyze cloth --dynamic --ticks 120 --csv tables/\n"
                         "          kerf analyze cloth --request probes.json --csv tables/");
  analyzing->group(group::kPhysics);
  add_sheet_id(*analyzing, arguments->id);
  auto* modes = analyzing
                    ->add_option("--modes", arguments->modes,
                                 "Compute this many of the lowest vibrations, about the sheet as it is")
                    ->check(CLI::Range(1, 200));
  analyzing->add_flag("--resting", arguments->resting, "Compute the vibrations about its equilibrium instead")
      ->needs(modes);
  auto* steps =
      analyzing->add_option("--steps", arguments->steps, "Approach the load in this many equal steps (default: 1)")
          ->check(CLI::Range(1, 10'000));
  auto* tolerance =
      analyzing
          ->add_option("--tolerance", arguments->tolerance,
                       "Largest residual force at an equilibrium, relative to loads and reactions (default: 1e-9)")
          ->check(CLI::Range(1e-13, 0.1));
  auto* dynamic = analyzing
                      ->add_flag("--dynamic", arguments->dynamic,
                                 "Continue from now for --ticks under the present loads, and measure the probes")
                      ->excludes(modes)
                      ->excludes(steps)
                      ->excludes(tolerance);
  analyzing->add_option("--ticks", arguments->ticks, "Number of ticks (default: 0, the state as it is)")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{100'000}))
      ->needs(dynamic);
  analyzing
      ->add_option("--every", arguments->every,
                   "Ticks from one measurement to the next; the end is always measured (default: 1)")
      ->check(CLI::Range(1, 10'000'000))
      ->needs(dynamic);
  analyzing
      ->add_option("--request", arguments->file,
                   "File with the whole request: kerf.v1.AnalyzeSheetRequest as JSON, probes included;\n"
                   "with --dynamic, without an analysis")
      ->type_name(value::kFile)
      ->excludes(modes)
      ->excludes(steps)
      ->excludes(tolerance);
  analyzing->add_option("--csv", arguments->csv, "Write the tables to this folder, as CSV")
      ->type_name(value::kFolder)
      ->check(existing_folder());
  analyzing->callback(
      [&session, arguments] { session.action = [&session, arguments] { return analyze(session, *arguments); }; });
}

}  // namespace kerf::cli
