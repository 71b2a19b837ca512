#include "client/load/stages.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <utility>

namespace kerf::load {
namespace {

constexpr std::size_t kMostStages = 100;
constexpr double kLongestStage = 1800.0;  // s
constexpr std::int32_t kMostTarget = 10'000;
constexpr std::array<std::pair<std::string_view, double>, 3> kUnits{{{"ms", 1e-3}, {"s", 1.0}, {"m", 60.0}}};

double seconds(Nanoseconds time) {
  return 1e-9 * static_cast<double>(time.count());
}

Error bad_stages(const std::string& why) {
  return invalid_argument("BAD_STAGES", "--stages: " + why + "; write LENGTH:TARGET,..., such as 10s:4,2m:16,500ms:0",
                          "--stages");
}

Result<Nanoseconds> parse_length(const std::string& text) {
  double value = 0.0;
  const auto [rest, wrong] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
  const auto* const known =
      std::find_if(kUnits.begin(), kUnits.end(), [unit](const auto& each) { return each.first == unit; });
  if (wrong != std::errc() || known == kUnits.end()) return bad_stages('"' + text + "\" is no length of time");
  value *= known->second;
  if (!(value >= 0.0 && value <= kLongestStage)) return bad_stages('"' + text + "\" is not in 0s..30m");
  return Nanoseconds(std::llround(1e9 * value));
}

Result<Stage> parse_stage(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return bad_stages('"' + text + "\" has no colon");
  Stage stage;
  KERF_TRY_ASSIGN(stage.length, parse_length(text.substr(0, colon)));
  const char* const end = text.data() + text.size();
  const auto [rest, wrong] = std::from_chars(text.data() + colon + 1, end, stage.target);
  if (wrong != std::errc() || rest != end || stage.target < 0 || stage.target > kMostTarget) {
    return bad_stages('"' + text.substr(colon + 1) + "\" is no whole number in 0.." + std::to_string(kMostTarget));
  }
  return stage;
}

}  // namespace

Result<std::vector<Stage>> parse_stages(const std::string& text) {
  std::vector<Stage> stages;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t begin = part.find_first_not_of(' ');
    KERF_TRY_ASSIGN(const Stage stage, parse_stage(begin == std::string::npos ? part : part.substr(begin)));
    stages.push_back(stage);
  }
  if (stages.empty()) return bad_stages("there is no stage");
  if (stages.size() > kMostStages) return bad_stages("there are more than 100 stages");
  return stages;
}

std::string text_of(const std::vector<Stage>& stages) {
  std::ostringstream text;
  for (const Stage& stage : stages) {
    text << (text.tellp() > 0 ? "," : "") << seconds(stage.length) << "s:" << stage.target;
  }
  return text.str();
}

std::vector<Step> steps_of(const std::vector<Stage>& stages) {
  std::vector<Step> steps;
  Nanoseconds begin{0};
  std::int32_t count = 0;
  for (const Stage& stage : stages) {
    const std::int32_t change = std::abs(stage.target - count);
    const std::int32_t sign = stage.target > count ? 1 : -1;
    // The even change passes the middle between two counts at these times.
    for (std::int32_t k = 0; k < change; ++k) {
      count += sign;
      steps.push_back({begin + stage.length * (2 * k + 1) / (2 * change), count});
    }
    begin += stage.length;
  }
  return steps;
}

std::int32_t largest_target(const std::vector<Stage>& stages) {
  std::int32_t most = 0;
  for (const Stage& stage : stages) most = std::max(most, stage.target);
  return most;
}

double length_s(const std::vector<Stage>& stages) {
  Nanoseconds length{0};
  for (const Stage& stage : stages) length += stage.length;
  return seconds(length);
}

double mean_count(const std::vector<Stage>& stages, double from, double to) {
  double sum = 0.0;
  double since = from;
  std::int32_t count = 0;
  for (const Step& step : steps_of(stages)) {
    const double time = std::clamp(seconds(step.time), from, to);
    sum += count * (time - since);
    since = time;
    count = step.count;
  }
  return (sum + count * (to - since)) / (to - from);
}

}  // namespace kerf::load
