#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "server/sheet/sheet.h"

namespace kerf::host {

// Durations in fixed classes; counts[i] holds those <= kBounds[i] and above the bound before, the last one the rest.
struct DurationHistogram {
  static constexpr std::array<double, 12> kBounds{1.0e-5, 1.0e-4, 2.5e-4, 5.0e-4, 1.0e-3, 2.5e-3,
                                                  5.0e-3, 1.0e-2, 1.7e-2, 3.3e-2, 1.0e-1, 1.0};  // s
  std::array<std::uint64_t, kBounds.size() + 1> counts{};
  double sum_s = 0.0;
  std::uint64_t total = 0;

  void add(double duration_s);
};

// What a host has done and holds now. Counters never fall; they include sheets deleted since.
struct HostMetrics {
  // Counters.
  std::int64_t ticks = 0;             // stepped
  std::int64_t failed_ticks = 0;      // of these: the integrator found no finite step
  std::int64_t snapshots = 0;         // built
  std::int64_t contact_phases = 0;    // substeps in which colliders were looked at
  std::int64_t cuts = 0;              // applied
  std::int64_t commands = 0;          // done, cuts and scheduled ones among them
  std::int64_t commands_refused = 0;  // by a full queue, by validation or by the sheet
  std::int64_t overruns = 0;          // ticks that ended after their deadline
  std::int64_t sleeps = 0;            // times a sheet fell asleep
  // Ticks that reported the flag of that bit, see fem::StepFlags and fem::kStepFlagNames.
  std::array<std::int64_t, fem::kStepFlagNames.size()> flagged_ticks{};
  double slipped_s = 0.0;           // s, simulated time given up
  double tick_cpu_s = 0.0;          // s, thread CPU time of all ticks
  DurationHistogram tick_duration;  // wall time of a tick, publishing included
  DurationHistogram cut_duration;   // wall time of a cut: plan, apply, remesh, model update
  // Now.
  std::int32_t sheets = 0;
  std::int32_t running_sheets = 0;
  std::int32_t paused_sheets = 0;
  std::int32_t sleeping_sheets = 0;
  std::int32_t failed_sheets = 0;
  std::int32_t queued_commands = 0;
  std::int32_t sinks = 0;
};

}  // namespace kerf::host
