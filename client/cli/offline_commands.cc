#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/progress.h"
#include "client/cli/scene_options.h"
#include "client/cli/tables.h"
#include "server/base/disk.h"
#include "server/service/offline/files.h"
#include "server/service/offline/replay.h"
#include "server/service/offline/run.h"

namespace kerf::cli {
namespace {

struct RunArguments {
  std::string scene;
  std::int64_t ticks = 0;
  std::string out;
  std::string record;
  std::string csv;
  offline::Overrides overrides;
};

std::string summary(const v1::SelfContactCounts& counts) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(),
                "  self-contact: %lld phases, %lld searches, %lld contacts, %lld repairs, %lld zones, %lld unsettled, "
                "%lld intersections\n",
                static_cast<long long>(counts.phases()), static_cast<long long>(counts.searches()),
                static_cast<long long>(counts.contacts()), static_cast<long long>(counts.repairs()),
                static_cast<long long>(counts.zones()), static_cast<long long>(counts.unsettled()),
                static_cast<long long>(counts.intersections()));
  return text.data();
}

std::string summary(const v1::RunResult& result) {
  char text[512];
  if (!result.has_static_() && result.simulated_s() == 0.0) {
    std::snprintf(text, sizeof text, "%.3f s of CPU time\n", result.cpu_s());
  } else if (result.has_static_()) {
    std::snprintf(text, sizeof text, "%lld %s in %.3f s of CPU time\n", static_cast<long long>(result.ticks()),
                  result.ticks() == 1 ? "load" : "loads", result.cpu_s());
  } else {
    std::snprintf(text, sizeof text, "%lld ticks (%.3f s simulated) in %.3f s of CPU time, %.0f us a tick\n",
                  static_cast<long long>(result.ticks()), result.simulated_s(), result.cpu_s(),
                  result.cpu_per_tick_us());
  }
  std::string all = text;
  std::snprintf(text, sizeof text,
                "  %d vertices, %d triangles, %d %s, %d %s\n"
                "  kinetic %.4g J, membrane %.4g J, bending %.4g J\n"
                "  state hash %s\n",
                result.num_vertices(), result.num_triangles(), result.pieces(),
                result.pieces() == 1 ? "piece" : "pieces", result.cuts_size(), result.cuts_size() == 1 ? "cut" : "cuts",
                result.energies().kinetic_j(), result.energies().membrane_j(), result.energies().bending_j(),
                result.state_hash().c_str());
  all += text;
  if (result.simulated_s() > 0.0) all += "  " + result.integrator() + "\n";
  if (result.linear_iterations() > 0) {
    std::snprintf(text, sizeof text, "  linear solves: %lld iterations, residual at most %.2g of the right-hand side\n",
                  static_cast<long long>(result.linear_iterations()), result.linear_residual());
    all += text;
  }
  if (result.largest_strained_share() > 0.0) {
    std::snprintf(text, sizeof text,
                  "  beyond the material's strain limit: %.2g %% of the area at most, %.2g %% on average\n",
                  100.0 * result.largest_strained_share(), 100.0 * result.mean_strained_share());
    all += text;
  }
  if (result.has_self_contact()) all += summary(result.self_contact());
  all.pop_back();
  if (result.has_static_()) all += "\n  " + describe(result.static_());
  for (const v1::Table& table : result.tables()) all += excerpt(table);
  return all + describe_flags(result.flagged_ticks());
}

int run(const Session& session, const RunArguments& arguments) {
  RealDisk disk;
  Result<scene::SheetConfig> config = offline::read_scene(disk, arguments.scene);
  if (!config.ok()) return refuse(config.error());
  if (const Status known = offline::apply(arguments.overrides, *config); !known.ok()) return refuse(known.error());

  const Result<offline::SceneRun> done = [&] {
    ProgressBar bar(session);
    return offline::run_scene(*config, {arguments.ticks, !arguments.record.empty(), [&bar](const auto& progress) {
                                          bar.show(progress.done, progress.what);
                                          return true;
                                        }});
  }();
  if (!done.ok()) return refuse(done.error());

  const std::string json = to_script_json(done->result);
  if (!arguments.out.empty()) {
    const Status written = disk.write_file(arguments.out, json + "\n");
    if (!written.ok()) return refuse(written.error());
  }
  if (!arguments.record.empty()) {
    const Status written = disk.write_file(arguments.record, done->recording);
    if (!written.ok()) return refuse(written.error());
  }
  if (const Status written = write_csv(disk, arguments.csv, done->result.tables()); !written.ok()) {
    return refuse(written.error());
  }
  std::printf("%s\n", (session.json ? json : summary(done->result)).c_str());
  return done->result.has_static_() ? check_converged(done->result.static_()) : kDone;
}

// Returns a note on torn bytes for the line about a replay; empty if the file is whole.
std::string describe_tear(std::int64_t torn_bytes) {
  if (torn_bytes == 0) return "";
  return "; the last " + std::to_string(torn_bytes) + (torn_bytes == 1 ? " byte is" : " bytes are") +
         " an incomplete entry, left out";
}

int replay(const Session& session, const std::string& path) {
  RealDisk disk;
  const Result<offline::ReplayReport> report = [&] {
    std::optional<WaitingNote> note;
    return offline::replay(disk, path, [&](std::size_t entries) {
      note.emplace(session, "replaying " + std::to_string(entries) + " entries");
    });
  }();
  if (!report.ok()) return refuse(report.error());

  const std::optional<offline::Divergence>& divergence = report->divergence;
  if (session.json) {
    nlohmann::ordered_json json{
        {"identical", !divergence.has_value()}, {"ticks", report->ticks}, {"torn_bytes", report->torn_bytes}};
    if (divergence) {
      json["first_diverging_tick"] = divergence->tick;
      json["recorded_hash"] = divergence->recorded_hash;
      json["replayed_hash"] = divergence->replayed_hash;
    } else if (!report->state_hash.empty()) {
      json["state_hash"] = report->state_hash;
    }
    std::printf("%s\n", json.dump(2).c_str());
  }
  const std::string tear = describe_tear(report->torn_bytes);
  if (divergence) {
    std::fprintf(
        stderr, "kerf: the replay differs from tick %lld on (recorded %s, replayed %s); recorded by: %s, here: %s%s\n",
        static_cast<long long>(divergence->tick), divergence->recorded_hash.c_str(), divergence->replayed_hash.c_str(),
        report->recorded_by.c_str(), report->replayed_by.c_str(), tear.c_str());
    return kRefused;
  }
  if (!session.json) {
    const char* const hash = report->state_hash.empty() ? "none" : report->state_hash.c_str();
    std::printf("identical, bit for bit: %lld ticks, state hash %s%s\n", static_cast<long long>(report->ticks), hash,
                tear.c_str());
  }
  return kDone;
}

}  // namespace

void add_offline_commands(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App* running =
      app.add_subcommand("run",
                         "Run a scene file as fast as this machine can, without a server: in time, to an\n"
                         "equilibrium, or for its vibrations, as the scene's analysis says.\n"
                         "Example: kerf run deploy/scenes/demo.json --ticks 300 --out result.json");
  running->add_option("SCENE", arguments->scene, "Scene file: the JSON form of kerf.v1.Scene")
      ->required()
      ->type_name(value::kFile);
  running->group(group::kPhysics);
  running->add_option("--ticks", arguments->ticks, "How many ticks (default: the scene's, else 600)")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{10'000'000}));
  running->add_option("--out", arguments->out, "Write the results to this file (kerf.v1.RunResult as JSON)")
      ->type_name(value::kFile);
  running
      ->add_option("--csv", arguments->csv, "Write the tables of the scene's probes and modes to this folder, as CSV")
      ->type_name(value::kFolder)
      ->check(existing_folder());
  running->add_option("--record", arguments->record, "Write a recording for `kerf replay`")->type_name(value::kFile);
  add_integrator_options(*running, "the scene's", arguments->overrides);
  add_fidelity_option(*running, "the scene's", arguments->overrides);
  running
      ->add_option("--membrane-law", arguments->overrides.membrane_law,
                   "Membrane law, instead of the scene's: corotational, or green (Saint Venant-Kirchhoff),\n"
                   "cheaper in explicit steps, stiffer under tension")
      ->check(CLI::IsMember({"corotational", "green"}));
  running->callback(
      [&session, arguments] { session.action = [&session, arguments] { return run(session, *arguments); }; });

  const auto file = std::make_shared<std::string>();
  CLI::App* replaying =
      app.add_subcommand("replay",
                         "Run a recording again and compare every tick, bit for bit.\n"
                         "A file that ends within an entry is replayed up to the last complete one, with\na note and "
                         "exit code 0. Changed bytes, or a tick that differs, give exit code 1.");
  replaying->add_option("FILE", *file, "Recording, by `kerf run --record`, `kerf sheet record` or `kerfd --record`")
      ->required()
      ->type_name(value::kFile);
  replaying->group(group::kPhysics);
  replaying->callback([&session, file] { session.action = [&session, file] { return replay(session, *file); }; });
}

}  // namespace kerf::cli
