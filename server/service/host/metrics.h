#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/core/fem/model/tick_cost.h"
#include "server/core/sheet/sheet.h"

namespace kerf::host {

// Counts values in fixed bins: counts[i] is the number of values <= kBounds[i] and above kBounds[i - 1]. The last count
// is the number of values above all bounds.
template <const auto& kLimits>
struct Histogram {
  static constexpr const auto& kBounds = kLimits;
  std::array<std::uint64_t, kLimits.size() + 1> counts{};
  double sum = 0.0;
  std::uint64_t total = 0;

  void add(double value) {
    std::size_t bin = 0;
    while (bin < kBounds.size() && value > kBounds[bin]) ++bin;
    ++counts[bin];
    sum += value;
    ++total;
  }
};

inline constexpr std::array<double, 12> kDurationBounds{1.0e-5, 1.0e-4, 2.5e-4, 5.0e-4, 1.0e-3, 2.5e-3,
                                                        5.0e-3, 1.0e-2, 1.7e-2, 3.3e-2, 1.0e-1, 1.0};  // s
using DurationHistogram = Histogram<kDurationBounds>;
inline constexpr std::array<double, 8> kResidualBounds{1.0e-12, 1.0e-8, 1.0e-6, 1.0e-4, 1.0e-3, 1.0e-2, 0.1, 1.0};  // -
using ResidualHistogram = Histogram<kResidualBounds>;

// Holds the counters and gauges of a host. Counters never fall, and include sheets deleted since.
struct HostMetrics {
  // Counters.
  std::int64_t ticks = 0;           // Ticks done.
  std::int64_t failed_ticks = 0;    // Ticks in which the integrator found no finite step.
  std::int64_t snapshots = 0;       // Built.
  std::int64_t contact_phases = 0;  // Substeps in which colliders were considered.
  std::int64_t cuts = 0;            // Applied.
  std::int64_t commands = 0;        // Done, cuts and scheduled ones included.
  // Refused: by the sheet, by a full queue, for lack of memory or for an unknown sheet.
  std::int64_t commands_refused = 0;
  std::int64_t overruns = 0;           // Ticks that ended after their deadline.
  std::int64_t sleeps = 0;             // Times a sheet fell asleep.
  std::int64_t overload_refusals = 0;  // Sheets refused because of the load.
  std::int64_t lost_sheets = 0;        // Sheets lost for lack of memory.
  std::int64_t short_ticks = 0;        // Ticks that lacked memory and froze their sheet.
  fem::FlagCounts flagged_ticks{};
  fem::SelfContactStats self_contact;
  double slipped_s = 0.0;   // s, simulated time that late sheets gave up
  double tick_cpu_s = 0.0;  // s, thread CPU time of all ticks
  // s, CPU time of ticks without commands, by part of a tick. Each tick's time is divided in proportion to the counted
  // costs of its parts, see fem::TickCost.
  std::array<double, fem::kTickPartNames.size()> tick_part_cpu_s{};
  std::int64_t linear_iterations = 0;  // Iterations of the linear solver, with implicit integrators.
  ResidualHistogram linear_residual;   // Largest residual of each tick with an implicit integrator, see fem::StepStats.
  DurationHistogram tick_duration;     // Wall time of a tick, publishing included.
  DurationHistogram cut_duration;      // Wall time of a cut: plan, apply, remesh, model update.
  // Now.
  std::int32_t sheets = 0;
  std::int32_t running_sheets = 0;
  std::int32_t paused_sheets = 0;
  std::int32_t sleeping_sheets = 0;
  std::int32_t failed_sheets = 0;
  std::int32_t queued_commands = 0;
  std::int32_t sinks = 0;
  std::int64_t worker_need = 0;  // Sum over running sheets and those being built to run, see WorkerNeed.
};

}  // namespace kerf::host
