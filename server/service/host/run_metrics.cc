#include "server/service/host/run_metrics.h"

#include <algorithm>

#include "server/base/check.h"

namespace kerf::host {

namespace {

std::int32_t& gauge(HostMetrics& metrics, RunState state) {
  switch (state) {
    case RunState::kRunning:
      return metrics.running_sheets;
    case RunState::kPaused:
      return metrics.paused_sheets;
    case RunState::kSleeping:
      return metrics.sleeping_sheets;
    case RunState::kFailed:
      return metrics.failed_sheets;
  }
  check_failed("state", __FILE__, __LINE__, "unknown run state");
}

}  // namespace

bool RunMetrics::set_state(RunState state) {
  if (is_ended_ || state_ == state) return false;
  board_.update([&](HostMetrics& m) {
    if (state_) {
      --gauge(m, *state_);
    } else {
      ++m.sheets;
    }
    ++gauge(m, state);
  });
  state_ = state;
  return true;
}

void RunMetrics::end() {
  board_.update([&](HostMetrics& m) {
    m.sinks -= num_sinks_;
    if (!state_) return;
    --gauge(m, *state_);
    --m.sheets;
  });
  is_ended_ = true;
}

void RunMetrics::tick_done(const Tick& tick, const sheet::TickReport& report,
                           const std::vector<Result<CommandResult>>& results) {
  if (tick.is_by_clock) need_.tick_done(tick.wall);
  const std::int64_t need = tick.is_by_clock ? need_.value() : counted_need_;
  const auto refused = [](const auto& result) { return !result.ok(); };
  const std::int64_t num_refused = std::count_if(results.begin(), results.end(), refused);
  const std::int64_t num_done = static_cast<std::int64_t>(results.size()) - num_refused;
  const fem::TickCost cost = tick.cost.value_or(fem::TickCost{});
  board_.update([&](HostMetrics& m) {
    for (std::size_t i = 0; i < cost.ns.size() && cost.total() > 0.0; ++i) {
      m.tick_part_cpu_s[i] += seconds(tick.cpu) * cost.ns[i] / cost.total();
    }
    if (report.advanced) {
      ++m.ticks;
      m.tick_cpu_s += seconds(tick.cpu);
      m.tick_duration.add(seconds(tick.wall));
    }
    if (report.step_failed) ++m.failed_ticks;
    if (tick.is_short) ++m.short_ticks;
    fem::count_flags(report.stats.flags, m.flagged_ticks);
    m.self_contact += report.stats.self_contact;
    if (report.advanced && report.stats.newton_iterations > 0) {
      m.linear_iterations += report.stats.linear_iterations;
      m.linear_residual.add(report.stats.linear_residual);
    }
    m.commands += num_done;
    m.commands_refused += num_refused;
    for (const Result<CommandResult>& result : results) {
      if (!result.ok() || !(result->reply.cut || !result->reply.batch.empty())) continue;
      m.cut_duration.add(1.0e-6 * (result->timings.cut_us + result->timings.update_us));
    }
    m.contact_phases += tick.totals.contact_phases - totals_.contact_phases;
    m.cuts += tick.totals.cuts - totals_.cuts;
    m.overruns += tick.totals.overruns - totals_.overruns;
    m.slipped_s += seconds(tick.totals.slipped - totals_.slipped);
    m.worker_need += need - counted_need_;
  });
  totals_ = tick.totals;
  counted_need_ = need;
}

void RunMetrics::set_need(std::int64_t need) {
  if (need == counted_need_) return;
  board_.update([&](HostMetrics& m) { m.worker_need += need - counted_need_; });
  counted_need_ = need;
}

void RunMetrics::commands_refused(std::int64_t count) {
  board_.update([&](HostMetrics& m) { m.commands_refused += count; });
}

void RunMetrics::sink_added() {
  ++num_sinks_;
  board_.update([](HostMetrics& m) { ++m.sinks; });
}

void RunMetrics::sink_removed() {
  --num_sinks_;
  board_.update([](HostMetrics& m) { --m.sinks; });
}

void RunMetrics::snapshot_built() {
  board_.update([](HostMetrics& m) { ++m.snapshots; });
}

void RunMetrics::fell_asleep() {
  board_.update([](HostMetrics& m) { ++m.sleeps; });
}

void RunMetrics::lost() {
  board_.update([](HostMetrics& m) { ++m.lost_sheets; });
}

}  // namespace kerf::host
