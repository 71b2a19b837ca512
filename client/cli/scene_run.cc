#include "client/cli/scene_run.h"

#include <chrono>
#include <ctime>
#include <string>
#include <utility>

#include "server/sheet/recording.h"
#include "server/sheet/sheet.h"
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

// Times the stages of the commands; a tick's cuts share what they took.
class StageTimer : public sheet::StageObserver {
 public:
  void begin(sheet::Stage /*stage*/, std::int32_t /*command*/) override { started_ = Clock::now(); }
  void end(sheet::Stage stage, std::int32_t /*command*/) override {
    const double elapsed = std::chrono::duration<double, std::micro>(Clock::now() - started_).count();
    if (stage == sheet::Stage::kCut) cut_us_ += elapsed;
    if (stage == sheet::Stage::kModelUpdate) update_us_ += elapsed;
  }
  // Since the last call: {cut, model update}.
  std::pair<double, double> take() { return {std::exchange(cut_us_, 0.0), std::exchange(update_us_, 0.0)}; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point started_;
  double cut_us_ = 0.0;
  double update_us_ = 0.0;
};

Error refused_command(const sheet::ScheduledReply& scheduled) {
  Error error = scheduled.reply.error();
  error.message = "scheduled command " + std::to_string(scheduled.index) + ": " + error.message;
  const std::string path = "commands[" + std::to_string(scheduled.index) + "].command";
  error.field = error.field.empty() ? path : path + "." + error.field;
  return error;
}

void describe_end(const sheet::Sheet& sheet, std::int64_t ticks, v1::RunResult& result) {
  result.set_scene(sheet.config().sheet_id);
  result.set_ticks(sheet.tick());
  result.set_num_vertices(sheet.mesh().num_vertices());
  result.set_num_triangles(sheet.mesh().num_solid_triangles());
  result.set_pieces(sheet.mesh().num_pieces());
  *result.mutable_energies() = wire::encode_energies(sheet.energies());
  result.set_state_hash(wire::encode_hash(sheet.state_hash()));
  result.set_cpu_per_tick_us(1e6 * result.cpu_s() / static_cast<double>(ticks));
  result.set_integrator(sheet.integrator_description());
}

}  // namespace

Result<SceneRun> run_scene(const sheet::SheetConfig& config, const SceneRunOptions& options) {
  Result<sheet::Sheet> created = sheet::Sheet::create(config);
  if (!created) return created.error();
  sheet::Sheet& sheet = *created;
  const std::int64_t scene_ticks = config.ticks > 0 ? config.ticks : kDefaultTicks;
  const std::int64_t ticks = options.ticks > 0 ? options.ticks : scene_ticks;

  SceneRun run;
  if (options.record) run.recording = wire::encode_recording_header(config, options.build);
  StageTimer timer;
  const double cpu_before = process_cpu_s();
  for (std::int64_t tick = 1; tick <= ticks; ++tick) {
    const sheet::TickReport report = sheet.step({}, &timer);
    run.result.set_simulated_s(run.result.simulated_s() + report.stats.simulated);
    const auto [cut_us, update_us] = timer.take();
    for (const sheet::ScheduledReply& scheduled : report.scheduled) {
      if (!scheduled.reply) return refused_command(scheduled);
      if (!scheduled.reply->cut) continue;
      v1::CutResult& cut = *run.result.add_cuts();
      cut = wire::encode_cut_result(*scheduled.reply);
      cut.set_cut_us(cut_us);
      cut.set_update_us(update_us);
    }
    for (std::size_t bit = 0; bit < fem::kStepFlagNames.size(); ++bit) {
      if ((report.stats.flags >> bit & 1U) == 0) continue;
      ++(*run.result.mutable_flagged_ticks())[std::string(fem::kStepFlagNames[bit])];
    }
    if (options.record) run.recording += wire::encode_recorded_tick({report.tick, {}, sheet.state_hash()});
    if (options.on_tick) options.on_tick(tick, ticks);
  }
  run.result.set_cpu_s(process_cpu_s() - cpu_before);
  describe_end(sheet, ticks, run.result);
  return run;
}

}  // namespace kerf::cli
