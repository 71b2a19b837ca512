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

// Describes the run of one sheet during the measurement.
struct SheetRun {
  std::string name;
  std::string run_state;  // At the end.
  std::int64_t ticks = 0;
  std::int64_t overruns = 0;
  double slipped_s = 0.0;
  double real_time_factor = 0.0;  // Simulated time over the wall time during which it was to run.
};

// Holds all results of a run.
struct Report {
  Plan plan;
  std::string server_version;
  std::int32_t server_workers = 0;
  std::int32_t processors = 0;  // On this machine.
  std::string started;          // UTC, ISO 8601
  bool interrupted = false;
  double measured_s = 0.0;                       // Between the first list of sheets and the last.
  double window_s = 0.0;                         // Time during which readers and cuts were counted.
  std::string integrator;                        // Integrator of the first sheet.
  std::map<std::string, std::int64_t> refusals;  // Number of sheets not made, by reason.
  std::string first_refusal;                     // The server's words.
  double creation_s = 0.0;                       // Time in which all sheets were created.
  Nanoseconds begin{0};                          // Beginning of the measured time.
  std::vector<SheetRun> sheets;
  std::array<ReaderTotals, kRoles.size()> readers;
  CutTotals cuts;
  std::vector<Stretch> stretches;              // Parts of the measured time, equally long, in order of time.
  Histogram control_us;                        // Lateness of a thread that only sleeps; see Control.
  std::vector<Probe> probes;                   // By time, at least the first and the last.
  std::int32_t list_pages = 0;                 // Pages of the last ListSheets.
  double list_s = 0.0;                         // Duration of the last ListSheets.
  std::map<std::string, std::int64_t> errors;  // Errors of calls, by reason.

  [[nodiscard]] const ReaderTotals& of(Role role) const { return readers[static_cast<std::size_t>(role)]; }
};

// Summarises the sheets running at the end; with stages of sheets, those that ran for half a second or longer.
struct Pace {
  std::int64_t running = 0;
  double least = 0.0;  // Least real-time factor; 0 if no sheet ran.
  double median = 0.0;
  double most = 0.0;
  std::int64_t slipped = 0;  // Sheets that gave up simulated time.
};
[[nodiscard]] Pace pace_of(const Report& report);

// Returns the integrator of the first sheet, without the estimates by which the server chose it.
[[nodiscard]] std::string short_integrator(const Report& report);

// Return the mean number that was to be there from `from` to `to`, seconds from the beginning of the measured time.
[[nodiscard]] double num_viewers(const Report& report, double from, double to);
[[nodiscard]] double num_sheets(const Report& report, double from, double to);
// Returns the time for which readers of a role read, summed over all of them.
[[nodiscard]] double reader_seconds(const Report& report, Role role);
[[nodiscard]] std::int64_t num_refused(const Report& report);  // Sheets.

// Return the mean number of cores that the server, or this program, used; negative if unknown.
[[nodiscard]] double server_cores(const Report& report);
[[nodiscard]] double client_cores(const Report& report);

// Counts errors by reason: those of calls, and one for each reader without a frame, or whose stream ended early.
// Stalled readers are expected to be ended.
[[nodiscard]] std::map<std::string, std::int64_t> errors_of(const Report& report);
[[nodiscard]] std::int64_t num_errors(const Report& report);
// True if readers were requested and none of them had a frame.
[[nodiscard]] bool nobody_joined(const Report& report);
[[nodiscard]] std::int64_t ticks_of(const Report& report);     // Sum over all sheets.
[[nodiscard]] std::int64_t overruns_of(const Report& report);  // Sum over all sheets.

// Returns doubts about the validity of the report, a sentence each.
[[nodiscard]] std::vector<std::string> warnings(const Report& report);

// Names a latency histogram, us.
struct Latency {
  std::string name;
  const Histogram* us = nullptr;
};
// Returns the latencies that were measured; the last is Report::control_us.
[[nodiscard]] std::vector<Latency> latencies(const Report& report);

inline constexpr std::array<double, 4> kQuantiles{0.5, 0.9, 0.99, 0.999};
inline constexpr const char* kFewValues = "* of too few values: the largest of them stands for the percentile";

[[nodiscard]] std::string to_text(const Report& report);
[[nodiscard]] std::string to_json(const Report& report);
// Returns one self-contained file.
[[nodiscard]] std::string to_html(const Report& report);

}  // namespace kerf::load
