#include "client/load/plan.h"

#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

namespace kerf::load {
namespace {

constexpr std::int64_t kMaxVertices = 500'000;  // Per sheet.
constexpr std::size_t kMaxPrefix = 41;

struct Range {
  const char* option;
  double value;
  double least;
  double most;
  bool or_zero = false;
};

std::vector<Range> ranges(const Plan& p) {
  return {
      {"--sheets", static_cast<double>(p.sheets), 1, 10'000},
      {"--grid", static_cast<double>(p.columns), 2, 1000},
      {"--grid", static_cast<double>(p.rows), 2, 1000},
      {"--tick-rate", p.tick_rate_hz, 1, 1000},
      {"--viewers", static_cast<double>(p.viewers), 0, 1000},
      {"--viewer-rate", p.viewer_rate_hz, 0.001, 1000, true},
      {"--slow-readers", static_cast<double>(p.slow_readers), 0, 1000},
      {"--hold", p.hold_s, 0.001, 60},
      {"--stall", p.stall_s, 0.001, 3600},
      {"--stalled-readers", static_cast<double>(p.stalled_readers), 0, 1000},
      {"--image-viewers", static_cast<double>(p.image_viewers), 0, 100},
      {"--image-size", static_cast<double>(p.image_width), 16, 4096},
      {"--image-size", static_cast<double>(p.image_height), 16, 4096},
      {"--cuts-per-second", p.cuts_per_second, 0, 1000},
      {"--way", p.way_ms, 0, 10'000},
      {"--way-rate", p.way_kib_per_s, 1, 1e6, true},
      {"--warm-up", p.warm_up_s, 0, 600},
      {"--duration", p.duration_s, 0.1, 1800},
      {"--server-pid", static_cast<double>(p.server_pid), 1, 4'194'304, true},
  };
}

bool is_prefix(std::string_view text) {
  const auto lower = [](char c) { return c >= 'a' && c <= 'z'; };
  const auto usual = [&](char c) { return lower(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !text.empty() && text.size() <= kMaxPrefix && lower(text[0]) && std::all_of(text.begin(), text.end(), usual);
}

}  // namespace

void set_stages(std::vector<Stage> stages, Staged staged, Plan& plan) {
  plan.duration_s = length_s(stages);
  (staged == Staged::kViewers ? plan.viewers : plan.sheets) = largest_target(stages);
  plan.stages = std::move(stages);
  plan.staged = staged;
}

Status check(const Plan& plan) {
  for (const Range& range : ranges(plan)) {
    if (range.or_zero && range.value == 0.0) continue;
    if (range.value >= range.least && range.value <= range.most) continue;
    std::ostringstream message;
    message << range.option << ": " << range.value << " is not in " << range.least << ".." << range.most;
    return invalid_argument("OUT_OF_RANGE", message.str(), range.option);
  }
  if (num_vertices(plan) > kMaxVertices) {
    return invalid_argument("OUT_OF_RANGE",
                            "--grid: " + std::to_string(num_vertices(plan)) + " vertices; a sheet has at most " +
                                std::to_string(kMaxVertices),
                            "--grid");
  }
  if (!is_prefix(plan.prefix)) {
    return invalid_argument("BAD_PREFIX",
                            "--prefix: \"" + plan.prefix +
                                "\" must begin with a letter a-z and have nothing but those, digits and -, at most " +
                                std::to_string(kMaxPrefix) + " of them",
                            "--prefix");
  }
  for (const Condition& condition : plan.fail_if) {
    if (!condition.of_ratio) continue;
    return invalid_argument("NOT_A_COMPARISON",
                            "--fail-if: \"" + condition.text + "\": limits with x are for the ratios of --compare",
                            "--fail-if");
  }
  if (plan.transport == Transport::kWebSocket && plan.http.empty()) {
    return invalid_argument("NO_HTTP", "--transport ws: give --http HOST:PORT, the viewer's port of the server",
                            "--http");
  }
  return Nothing{};
}

}  // namespace kerf::load
