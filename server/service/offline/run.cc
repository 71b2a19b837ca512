#include "server/service/offline/run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "server/base/overloaded.h"
#include "server/core/analysis/analysis.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/core/sheet/stage_observer.h"
#include "server/service/wire/analysis_codec.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/reply_codec.h"
#include "server/service/wire/self_contact_codec.h"

namespace kerf::offline {
namespace {

constexpr std::int64_t kDefaultTicks = 600;

double process_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Times the stages of each tick, and of its commands.
class StageTimer : public sheet::StageObserver {
 public:
  struct Times {
    double cut_us = 0.0;
    double update_us = 0.0;
    double step_us = 0.0;

    [[nodiscard]] double total_us() const { return cut_us + update_us + step_us; }
  };

  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { started_ = Clock::now(); }
  void end(sheet::Stage stage, std::int32_t command) override {
    const double elapsed = std::chrono::duration<double, std::micro>(Clock::now() - started_).count();
    add(stage, elapsed, tick_);
    if (command < 0) return;
    const auto index = static_cast<std::size_t>(command);
    if (index >= commands_.size()) commands_.resize(index + 1);
    add(stage, elapsed, commands_[index]);
  }
  void clear() {
    commands_.clear();
    tick_ = {};
  }
  [[nodiscard]] Times of_command(std::size_t command) const {
    return command < commands_.size() ? commands_[command] : Times{};
  }
  [[nodiscard]] const Times& of_tick() const { return tick_; }

 private:
  using Clock = std::chrono::steady_clock;

  static void add(sheet::Stage stage, double elapsed, Times& times) {
    switch (stage) {
      case sheet::Stage::kCut:
        times.cut_us += elapsed;
        break;
      case sheet::Stage::kModelUpdate:
        times.update_us += elapsed;
        break;
      case sheet::Stage::kLoads:
      case sheet::Stage::kIntegrate:
        times.step_us += elapsed;
        break;
    }
  }

  Clock::time_point started_;
  Times tick_;
  std::vector<Times> commands_;
};

// Collects the times of RunResult.tick_times.
class TickTimes {
 public:
  void add(std::int64_t tick, const StageTimer::Times& times, const fem::TickCost& cost) {
    ticks_.push_back({tick, times});
    for (std::size_t i = 0; i < parts_.size() && cost.total() > 0.0; ++i) {
      parts_[i] += times.step_us * cost.ns[i] / cost.total();
    }
  }

  [[nodiscard]] v1::TickTimes summary() {
    constexpr std::size_t kMostSlow = 10;
    v1::TickTimes summary;
    if (ticks_.empty()) return summary;
    const auto count = static_cast<double>(ticks_.size());
    StageTimer::Times mean;
    for (const Tick& tick : ticks_) {
      mean.cut_us += tick.times.cut_us / count;
      mean.update_us += tick.times.update_us / count;
      mean.step_us += tick.times.step_us / count;
    }
    *summary.mutable_mean() = encode({0, mean});
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (parts_[i] > 0.0) (*summary.mutable_parts_us())[std::string(fem::kTickPartNames[i])] = parts_[i] / count;
    }
    std::stable_sort(ticks_.begin(), ticks_.end(),
                     [](const Tick& a, const Tick& b) { return a.times.total_us() > b.times.total_us(); });
    summary.set_median_us(ticks_[ticks_.size() / 2].times.total_us());
    summary.set_p99_us(ticks_[ticks_.size() / 100].times.total_us());
    for (std::size_t i = 0; i < std::min(kMostSlow, ticks_.size()); ++i) *summary.add_slowest() = encode(ticks_[i]);
    return summary;
  }

 private:
  struct Tick {
    std::int64_t tick = 0;
    StageTimer::Times times;
  };

  static v1::TickTimes::Tick encode(const Tick& tick) {
    v1::TickTimes::Tick message;
    message.set_tick(tick.tick);
    message.set_total_us(tick.times.total_us());
    message.set_cut_us(tick.times.cut_us);
    message.set_update_us(tick.times.update_us);
    message.set_step_us(tick.times.step_us);
    return message;
  }

  std::vector<Tick> ticks_;
  std::array<double, fem::kTickPartNames.size()> parts_{};
};

// Adds the outcomes of a Cut or CutBatch; the cuts of a batch share its time equally.
void add_cuts(const scene::CommandReply& reply, const StageTimer::Times& time, v1::RunResult& result) {
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

// Steps a dynamic scene, and records it if requested.
Result<analysis::Outcome> step_scene(sheet::Sheet& sheet, const SceneRunOptions& options, SceneRun& run) {
  const std::int64_t scene_ticks = sheet.config().ticks > 0 ? sheet.config().ticks : kDefaultTicks;
  scene::DynamicAnalysis analysis = std::get<scene::DynamicAnalysis>(sheet.config().analysis);
  analysis.ticks = options.ticks > 0 ? options.ticks : scene_ticks;
  if (options.record) run.recording = wire::encode_recording_header(sheet.config(), wire::build_name());
  StageTimer timer;
  TickTimes times;
  std::optional<fem::SelfContactStats> self_contact;
  const auto after = [&](const sheet::TickReport& report) {
    for (std::size_t i = 0; i < report.scheduled.size(); ++i) {
      if (report.scheduled[i].reply.ok()) add_cuts(*report.scheduled[i].reply, timer.of_command(i), run.result);
    }
    times.add(report.tick, timer.of_tick(), sheet.expected_cost());
    timer.clear();
    if (sheet.self_contact().is_on) {
      if (!self_contact) self_contact.emplace();
      *self_contact += report.stats.self_contact;
    }
    run.result.set_linear_iterations(run.result.linear_iterations() + report.stats.linear_iterations);
    run.result.set_linear_residual(std::max(run.result.linear_residual(), report.stats.linear_residual));
    const double share = report.stats.strained_share;
    run.result.set_largest_strained_share(std::max(run.result.largest_strained_share(), share));
    run.result.set_mean_strained_share(run.result.mean_strained_share() + share / static_cast<double>(analysis.ticks));
    if (options.record) run.recording += wire::encode_recorded_tick({report.tick, {}, sheet.state_hash()});
  };
  Result<analysis::Outcome> outcome =
      analysis::run_dynamic(sheet, analysis, sheet.config().probes, options.watch, after, &timer);
  *run.result.mutable_tick_times() = times.summary();
  if (self_contact) *run.result.mutable_self_contact() = wire::encode_self_contact_counts(*self_contact);
  return outcome;
}

}  // namespace

Result<SceneRun> run_scene(const scene::SheetConfig& config, const SceneRunOptions& options) {
  const bool is_dynamic = std::holds_alternative<scene::DynamicAnalysis>(config.analysis);
  if (options.record && !is_dynamic) {
    return invalid_argument("RECORDING_DYNAMIC_ONLY", "a recording can be made of a dynamic analysis only", "analysis");
  }
  KERF_TRY_ASSIGN(sheet::Sheet sheet, sheet::Sheet::create(config));

  SceneRun run;
  const double cpu_before = process_cpu_s();
  KERF_TRY_ASSIGN(
      analysis::Outcome outcome,
      std::visit(Overloaded{
                     [&](const scene::DynamicAnalysis& /*in_time*/) { return step_scene(sheet, options, run); },
                     [&](const scene::StaticAnalysis& of_loads) {
                       return analysis::run_static(sheet, of_loads, config.probes, options.watch);
                     },
                     [&](const scene::ModalAnalysis& modes) {
                       return analysis::run_modes(sheet, modes, config.probes, options.watch);
                     },
                 },
                 config.analysis));
  run.result.set_cpu_s(process_cpu_s() - cpu_before);
  for (const sheet::ScheduledReply& scheduled : outcome.scheduled) {
    if (!is_dynamic) add_cuts(*scheduled.reply, {}, run.result);
  }
  for (const analysis::Table& table : outcome.tables) *run.result.add_tables() = wire::encode_table(table);
  if (outcome.statics) *run.result.mutable_static_() = wire::encode_statics(*outcome.statics);
  if (outcome.dynamics) {
    run.result.set_simulated_s(outcome.dynamics->simulated);
    wire::encode_flags(outcome.dynamics->flagged_ticks, *run.result.mutable_flagged_ticks());
  }
  describe_end(sheet, run.result);
  return run;
}

}  // namespace kerf::offline
