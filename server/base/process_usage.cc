#include "server/base/process_usage.h"

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace kerf {
namespace {

std::string content_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Returns the resident memory of a process in bytes, or nothing if there is no such process.
std::optional<std::int64_t> resident_bytes_of(const std::string& process) {
  std::istringstream pages(content_of("/proc/" + process + "/statm"));
  std::int64_t total = 0;
  std::int64_t resident = 0;
  pages >> total >> resident;
  if (!pages) return std::nullopt;
  return resident * sysconf(_SC_PAGESIZE);
}

}  // namespace

std::optional<ProcessUsage> usage_of(std::int64_t pid) {
  // The fields of proc(5) are numbered from 1. Fields from 3 on follow the bracket after the process name, which may
  // itself have blanks and brackets. utime and stime are fields 14 and 15, in clock ticks.
  const std::string stat = content_of("/proc/" + std::to_string(pid) + "/stat");
  const std::size_t bracket = stat.rfind(')');
  if (bracket == std::string::npos) return std::nullopt;
  std::istringstream fields(stat.substr(bracket + 1));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0.0;
  double system = 0.0;
  fields >> user >> system;
  const std::optional<std::int64_t> resident = resident_bytes_of(std::to_string(pid));
  if (!fields || !resident) return std::nullopt;
  return ProcessUsage{(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK)), *resident};
}

ProcessUsage own_usage() {
  return usage_of(getpid()).value_or(ProcessUsage{});
}

std::int64_t resident_bytes() {
  return resident_bytes_of("self").value_or(0);
}

}  // namespace kerf
