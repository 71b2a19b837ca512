#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "client/load/plan.h"
#include "client/load/recorder.h"
#include "client/load/server_probe.h"

namespace kerf::load {

// How one sheet ran while it was measured.
struct SheetRun {
  std::string name;
  std::string run_state;  // at the end
  std::int64_t ticks = 0;
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  double real_time_factor = 0.0;  // simulated time over time on the clock
};

// All that a run found.
struct Report {
  Plan plan;
  std::string server_version;
  std::int32_t server_workers = 0;
  std::int32_t processors = 0;  // of this machine
  std::string started;          // UTC, ISO 8601
  bool interrupted = false;
  double measured_s = 0.0;                       // between the first list of sheets and the last
  double window_s = 0.0;                         // of what readers and cuts count
  std::string integrator;                        // of the first sheet
  std::map<std::string, std::int64_t> refusals;  // sheets not made, by reason
  std::string first_refusal;                     // the server's words
  double creation_s = 0.0;                       // of all sheets
  std::vector<SheetRun> sheets;
  std::array<ReaderTotals, kRoles.size()> readers;
  CutTotals cuts;
  std::vector<Stretch> stretches;              // of equal length, begin to end
  Histogram control_us;                        // how late a thread woke that only sleeps; see Control
  std::vector<Probe> probes;                   // by time, at least the first and the last
  std::int32_t list_pages = 0;                 // of the last ListSheets
  double list_s = 0.0;                         // that it took
  std::map<std::string, std::int64_t> errors;  // of calls, by reason

  [[nodiscard]] const ReaderTotals& of(Role role) const { return readers[static_cast<std::size_t>(role)]; }
};

// Of the sheets that were running at the end.
struct Pace {
  std::int64_t running = 0;
  double least = 0.0;  // real-time factors; 0 where no sheet ran
  double median = 0.0;
  double most = 0.0;
  std::int64_t slipped = 0;  // sheets that gave up simulated time
};
[[nodiscard]] Pace pace_of(const Report& report);

// Cores that the server, or this program, used; negative where that is not known.
[[nodiscard]] double server_cores(const Report& report);
[[nodiscard]] double client_cores(const Report& report);

// Of calls, and of readers that did not get what they were to get, each once, by reason: that never had a frame, or
// whose stream ended before the run did. Stalled readers are to be ended.
[[nodiscard]] std::map<std::string, std::int64_t> errors_of(const Report& report);
[[nodiscard]] std::int64_t num_errors(const Report& report);
// Readers were asked for, and not one of them had a frame.
[[nodiscard]] bool nobody_joined(const Report& report);
[[nodiscard]] std::int64_t ticks_of(const Report& report);     // of all sheets
[[nodiscard]] std::int64_t overruns_of(const Report& report);  // likewise

// What a reader of the report must know before believing it, a sentence each.
[[nodiscard]] std::vector<std::string> warnings(const Report& report);

// A latency beside others, us.
struct Latency {
  std::string name;
  const Histogram* us = nullptr;
};
// Those that were measured, the control run last.
[[nodiscard]] std::vector<Latency> latencies(const Report& report);

inline constexpr std::array<double, 4> kQuantiles{0.5, 0.9, 0.99, 0.999};

[[nodiscard]] std::string to_text(const Report& report);
[[nodiscard]] std::string to_json(const Report& report);
// One file that needs no other.
[[nodiscard]] std::string to_html(const Report& report);

}  // namespace kerf::load
