#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "client/load/recorder.h"
#include "client/load/schedule.h"

namespace kerf::load {

// Runs the first sheets of a run and pauses the others. set() is for one thread, count() for any, the rest for after
// it.
class SheetSwitch {
 public:
  // `running`: the number of sheets that run already. All arguments must outlive the SheetSwitch.
  SheetSwitch(const std::vector<std::string>& sheets, std::int32_t running, client::Client& client, Recorder& recorder);

  // Runs the first `count` sheets, or all if there are fewer, and pauses the others. Refusals are errors of the run.
  void set(std::int32_t count);
  [[nodiscard]] const std::atomic<std::int32_t>& count() const { return count_; }
  // Returns the seconds before `until` in which a sheet was to run since the first set().
  [[nodiscard]] double ran_s(std::size_t sheet, Nanoseconds until) const;

 private:
  struct Run {
    Nanoseconds before{0};             // Time of earlier runs.
    std::optional<Nanoseconds> since;  // Empty while paused.
  };

  const std::vector<std::string>& sheets_;
  client::Client& client_;
  Recorder& recorder_;
  std::atomic<std::int32_t> count_;
  std::vector<Run> runs_;
};

}  // namespace kerf::load
