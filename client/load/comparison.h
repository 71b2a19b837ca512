#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/load/metrics.h"
#include "server/base/result.h"

namespace kerf::load {

// A metric of two reports.
struct ComparedMetric {
  std::string name;
  std::string unit;
  Better better = Better::kLow;
  std::optional<double> first;
  std::optional<double> second;
  bool enough = false;  // Both are of enough values.

  // Returns second / first; empty if one is missing or the first is 0.
  [[nodiscard]] std::optional<double> ratio() const;
};

// A setting that differs between two runs, as JSON.
struct ChangedSetting {
  std::string name;
  std::string first;
  std::string second;
};

// Two reports side by side.
struct Comparison {
  std::string first;  // Names of the reports.
  std::string second;
  std::vector<ChangedSetting> settings;  // Also the server's version and the processors.
  std::vector<ComparedMetric> metrics;   // Those that at least one report has.
};

// Compares two reports of to_json(). INVALID_ARGUMENT NOT_A_REPORT if one is none.
struct NamedReport {
  std::string name;
  std::string json;
};
Result<Comparison> compare(const NamedReport& first, const NamedReport& second);

// Judges conditions about ratios. INVALID_ARGUMENT NOT_A_RATIO for others. A ratio that does not exist, or is of too
// few values, is undecided.
Result<std::vector<Judgement>> judge(const Comparison& comparison, const std::vector<Condition>& conditions);

[[nodiscard]] std::string to_text(const Comparison& comparison);
[[nodiscard]] std::string to_json(const Comparison& comparison, const std::vector<Judgement>& judged);
// Returns one self-contained file.
[[nodiscard]] std::string to_html(const Comparison& comparison);

}  // namespace kerf::load
