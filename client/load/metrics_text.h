#pragma once

#include <optional>
#include <string>

#include "server/base/process_usage.h"

namespace kerf::load {

// Returns the value of the metric `name` in a page of metrics, Prometheus text format. `name` includes its labels, if
// any: kerf_sheets{state="running"}.
[[nodiscard]] std::optional<double> metric_in(const std::string& metrics, const std::string& name);

// Returns process_cpu_seconds_total and process_resident_memory_bytes.
[[nodiscard]] std::optional<ProcessUsage> usage_in(const std::string& metrics);

}  // namespace kerf::load
