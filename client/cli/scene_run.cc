#include "client/cli/scene_run.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <string>
#include <utility>
#include <variant>

#include "server/analysis/analysis.h"
#include "server/sheet/recording.h"
#include "server/sheet/sheet.h"
#include "server/wire/analysis_codec.h"
#include "server/wire/recording_codec.h"
#include "server/wire/reply_codec.h"

namespace kerf::cli {
namespace {

constexpr std::int64_t kDefaultTicks = 600;

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Times the stages of a tick's commands.
class StageTimer : public sheet::StageObserver {
 public:
  struct CutTime {
    double cut_us = 0.0;
    double update_us = 0.0;
  };

  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { started_ = Clock::now(); }
  void end(sheet::Stage stage, std::int32_t command) override {
    if (command < 0) return;
    const double elapsed = std::chrono::duration<double, std::micro>(Clock::now() - started_).count();
    const auto index = static_cast<std::size_t>(command);
    if (index >= times_.size()) times_.resize(index + 1);
    if (stage == sheet::Stage::kCut) times_[index].cut_us += elapsed;
    if (stage == sheet::Stage::kModelUpdate) times_[index].update_us += elapsed;
  }
  void clear() { times_.clear(); }
  [[nodiscard]] CutTime time(std::size_t command) const {
    return command < times_.size() ? times_[command] : CutTime{};
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point started_;
  std::vector<CutTime> times_;  // by command
};

// The outcomes of a Cut or CutBatch; the cuts of a batch share its time equally.
void add_cuts(const sheet::CommandReply& reply, const StageTimer::CutTime& time, v1::RunResult& result) {
  std::vector<v1::CutResult> cuts = wire::encode_cut_results(reply);
  const auto count = static_cast<double>(cuts.size());
  for (v1::CutResult& cut : cuts) {
    cut.set_cut_us(time.cut_us / count);
    cut.set_update_us(time.update_us / count);
    *result.add_cuts() = std::move(cut);
  }
}

void describe_end(const sheet::Sheet& sheet, v1::RunResult& result) {
  result.set_scene(sheet.config().sheet_id);
  result.set_ticks(sheet.tick());
  result.set_num_vertices(sheet.mesh().num_vertices());
  result.set_num_triangles(sheet.mesh().num_solid_triangles());
  result.set_pieces(sheet.mesh().num_pieces());
  *result.mutable_energies() = wire::encode_energies(sheet.energies());
  result.set_state_hash(wire::encode_hash(sheet.state_hash()));
  if (sheet.tick() > 0) result.set_cpu_per_tick_us(1e6 * result.cpu_s() / static_cast<double>(sheet.tick()));
  result.set_integrator(sheet.integrator_description());
}

// Steps a dynamic scene, and records it where asked to.
Result<analysis::Outcome> step_scene(sheet::Sheet& sheet, const SceneRunOptions& options, SceneRun& run) {
  const std::int64_t scene_ticks = sheet.config().ticks > 0 ? sheet.config().ticks : kDefaultTicks;
  sheet::DynamicAnalysis analysis = std::get<sheet::DynamicAnalysis>(sheet.config().analysis);
  analysis.ticks = options.ticks > 0 ? options.ticks : scene_ticks;
  if (options.record) run.recording = wire::encode_recording_header(sheet.config(), options.build);
  StageTimer timer;
  const auto after = [&](const sheet::TickReport& report) {
    for (std::size_t i = 0; i < report.scheduled.size(); ++i) {
      if (report.scheduled[i].reply) add_cuts(*report.scheduled[i].reply, timer.time(i), run.result);
    }
    timer.clear();
    run.result.set_linear_iterations(run.result.linear_iterations() + report.stats.linear_iterations);
    run.result.set_linear_residual(std::max(run.result.linear_residual(), report.stats.linear_residual));
    const double share = report.stats.strained_share;
    run.result.set_largest_strained_share(std::max(run.result.largest_strained_share(), share));
    run.result.set_mean_strained_share(run.result.mean_strained_share() + share / static_cast<double>(analysis.ticks));
    if (options.record) run.recording += wire::encode_recorded_tick({report.tick, {}, sheet.state_hash()});
  };
  return analysis::run_dynamic(sheet, analysis, sheet.config().probes, options.watch, after, &timer);
}

}  // namespace

Result<SceneRun> run_scene(const sheet::SheetConfig& config, const SceneRunOptions& options) {
  const bool is_dynamic = std::holds_alternative<sheet::DynamicAnalysis>(config.analysis);
  if (options.record && !is_dynamic) {
    return invalid_argument("RECORDING_DYNAMIC_ONLY", "a recording can be made of a dynamic analysis only", "analysis");
  }
  Result<sheet::Sheet> created = sheet::Sheet::create(config);
  if (!created) return created.error();
  sheet::Sheet& sheet = *created;

  SceneRun run;
  const double cpu_before = process_cpu_s();
  Result<analysis::Outcome> outcome = [&]() -> Result<analysis::Outcome> {
    if (const auto* of_loads = std::get_if<sheet::StaticAnalysis>(&config.analysis)) {
      return analysis::run_static(sheet, *of_loads, config.probes, options.watch);
    }
    if (const auto* modes = std::get_if<sheet::ModalAnalysis>(&config.analysis)) {
      return analysis::run_modes(sheet, *modes, config.probes, options.watch);
    }
    return step_scene(sheet, options, run);
  }();
  if (!outcome) return outcome.error();
  run.result.set_cpu_s(process_cpu_s() - cpu_before);
  for (const sheet::ScheduledReply& scheduled : outcome->scheduled) {
    if (!is_dynamic) add_cuts(*scheduled.reply, {}, run.result);
  }
  for (const analysis::Table& table : outcome->tables) *run.result.add_tables() = wire::encode_table(table);
  if (outcome->statics) *run.result.mutable_static_() = wire::encode_statics(*outcome->statics);
  if (outcome->dynamics) {
    run.result.set_simulated_s(outcome->dynamics->simulated);
    wire::encode_flags(outcome->dynamics->flagged_ticks, *run.result.mutable_flagged_ticks());
  }
  describe_end(sheet, run.result);
  return run;
}

}  // namespace kerf::cli
