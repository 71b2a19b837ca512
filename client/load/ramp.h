#pragma once

#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

#include "client/load/schedule.h"
#include "client/load/stages.h"

namespace kerf::load {

// Follows the stages of a run on a thread of its own.
class Ramp {
 public:
  // Calls `set` with each count once its time, from `begin`, has come. Late changes follow at once. All arguments must
  // outlive the Ramp.
  Ramp(const std::vector<Stage>& stages, Nanoseconds begin, Waiter& waiter, std::function<void(std::int32_t)> set);
  ~Ramp();  // Waits for the last stage, or for the waiter's end.
  Ramp(const Ramp&) = delete;
  Ramp& operator=(const Ramp&) = delete;

 private:
  std::thread thread_;
};

}  // namespace kerf::load
