#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/load/condition.h"

namespace kerf::load {

struct Report;

enum class Unit { kCount, kFactor, kCores, kPercent, kMilliseconds, kHertz, kKilobytesPerSecond, kMegabytes };

// Returns the names of the units in which a limit may be given, each with its factor to the metric's own unit. The
// first is that unit.
const std::vector<std::pair<std::string_view, double>>& units_of(Unit unit);

// A figure of a report.
struct Figure {
  std::optional<double> value;  // Empty if nothing was measured.
  std::int64_t samples = 1;     // Number of values that it is made of.
  std::int64_t needed = 1;      // Number of values that it needs; a 99th percentile of fewer than 100 is their largest.

  [[nodiscard]] bool enough() const { return value && samples >= needed; }
};

enum class Better { kLow, kHigh, kNeither };

// Names a figure, for --fail-if, CSV and comparisons.
struct Metric {
  std::string name;  // "cut_p99"
  std::string what;
  Unit unit = Unit::kCount;
  Better better = Better::kLow;
  std::function<Figure(const Report&)> figure;
};

// Returns all metrics, in the order of reports.
const std::vector<Metric>& metrics();
// Returns nullptr if there is none of that name.
const Metric* find_metric(const std::string& name);
// Lists all metrics for the help, a line or two each.
[[nodiscard]] std::string list_of_metrics();

// Returns the number of values below which a quantile is only their largest: 100 for 0.99. `q` in 0..0.999.
[[nodiscard]] std::int64_t values_needed(double q);

// The outcome of a condition.
struct Judgement {
  enum class Verdict { kPassed, kFailed, kUndecided };

  Condition condition;
  Figure figure;
  Verdict verdict = Verdict::kPassed;
};
// Judges the conditions of the plan. One whose figure has too few values is undecided, whatever the figure.
[[nodiscard]] std::vector<Judgement> judge(const Report& report);
// Returns a sentence such as "cut_p99>50ms: failed, 61.2 ms of 300 values".
[[nodiscard]] std::string describe(const Judgement& judgement);
[[nodiscard]] const char* name_of(Judgement::Verdict verdict);  // "passed", "failed", "undecided"

// Return one line for each metric, and one for each interval of the run, with a line of names above them.
[[nodiscard]] std::string to_summary_csv(const Report& report);
[[nodiscard]] std::string to_interval_csv(const Report& report);

}  // namespace kerf::load
