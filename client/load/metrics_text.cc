#include "client/load/metrics_text.h"

#include <cstdlib>
#include <sstream>

namespace kerf::load {

std::optional<double> metric_in(const std::string& metrics, const std::string& name) {
  std::istringstream lines(metrics);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.size() <= name.size() || line.compare(0, name.size(), name) != 0 || line[name.size()] != ' ') continue;
    const char* begin = line.c_str() + name.size() + 1;
    char* end = nullptr;
    const double value = std::strtod(begin, &end);
    if (end != begin) return value;
  }
  return std::nullopt;
}

std::optional<ProcessUsage> usage_in(const std::string& metrics) {
  const std::optional<double> cpu = metric_in(metrics, "process_cpu_seconds_total");
  const std::optional<double> memory = metric_in(metrics, "process_resident_memory_bytes");
  if (!cpu || !memory) return std::nullopt;
  return ProcessUsage{*cpu, static_cast<std::int64_t>(*memory)};
}

}  // namespace kerf::load
