#pragma once

#include <mutex>
#include <thread>

#include "client/load/histogram.h"
#include "client/load/schedule.h"

namespace kerf::load {

// Measures the delays of this machine: a thread only sleeps to absolute deadlines, as the server's sheets and this
// program's cuts do, and notes how late it wakes.
class Control {
 public:
  // Begins at `schedule.start`, ends at `end`; `waiter` must outlive the Control.
  Control(const Schedule& schedule, Nanoseconds end, Waiter& waiter);
  ~Control();  // Waits until `end`.
  Control(const Control&) = delete;
  Control& operator=(const Control&) = delete;

  [[nodiscard]] Histogram lateness_us() const;

 private:
  mutable std::mutex mutex_;
  Histogram lateness_us_;
  std::thread thread_;
};

}  // namespace kerf::load
