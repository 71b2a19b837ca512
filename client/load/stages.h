#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/load/schedule.h"
#include "server/base/result.h"

namespace kerf::load {

// A stage of a run: the number of viewers or sheets changes evenly to `target` over `length`.
struct Stage {
  Nanoseconds length{0};    // >= 0; 0: at once.
  std::int32_t target = 0;  // 0..10,000
};

// Defines the time, from the beginning of the first stage, from which there are `count` of them.
struct Step {
  Nanoseconds time{0};
  std::int32_t count = 0;
};

// Parses "10s:4,2m:16,500ms:0": a length and a target for each stage, at most 100. INVALID_ARGUMENT BAD_STAGES.
Result<std::vector<Stage>> parse_stages(const std::string& text);
// Returns the text that parse_stages() reads.
[[nodiscard]] std::string text_of(const std::vector<Stage>& stages);

// Returns all changes in order of time; each changes the count by one. The count begins at 0.
[[nodiscard]] std::vector<Step> steps_of(const std::vector<Stage>& stages);
[[nodiscard]] std::int32_t largest_target(const std::vector<Stage>& stages);
[[nodiscard]] double length_s(const std::vector<Stage>& stages);
// Returns the mean count from `from` to `to`, seconds; `to` > `from`.
[[nodiscard]] double mean_count(const std::vector<Stage>& stages, double from, double to);

}  // namespace kerf::load
