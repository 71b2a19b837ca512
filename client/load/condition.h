#pragma once

#include <string>

#include "server/base/result.h"

namespace kerf::load {

// Compares a metric of the report with a limit, as in "cut_p99>50ms". A run in which it holds has failed. A limit with
// the unit x is for two reports: "cut_p99>1.2x" is about the ratio of the second to the first.
struct Condition {
  enum class Relation { kAbove, kAtLeast, kBelow, kAtMost };

  std::string text;    // As given, without spaces around it.
  std::string metric;  // One of metrics().
  Relation relation = Relation::kAbove;
  double limit = 0.0;     // In the metric's own unit.
  bool of_ratio = false;  // The limit is that of a ratio.

  [[nodiscard]] bool holds(double value) const;
};

// Parses METRIC, one of > >= < <=, and a number with a unit that fits the metric, or x. INVALID_ARGUMENT
// UNKNOWN_METRIC, BAD_UNIT or BAD_CONDITION.
Result<Condition> parse_condition(const std::string& text);
// Returns the word of `text` where a metric is expected.
[[nodiscard]] std::string metric_word(const std::string& text);

}  // namespace kerf::load
