#pragma once

#include <algorithm>
#include <cstdint>

#include "server/service/host/clock.h"

namespace kerf::host {

// Compares the measured time of a sheet's ticks with their counted cost, see TickEstimate::scale. A plain value.
class TickScale {
 public:
  // Records the CPU time of a tick without commands. `counted_ns`: its counted cost, >= 0; a tick with a cost of 0 is
  // left out.
  void tick_done(Nanoseconds cpu, double counted_ns) {
    if (!(counted_ns > 0.0) || cpu.count() <= 0) return;
    const double scale = static_cast<double>(cpu.count()) / counted_ns;
    mean_ += std::max(kLeastWeight, 1.0 / static_cast<double>(++num_ticks_)) * (scale - mean_);
  }
  // Returns the running mean of measured over counted time, -, > 0; 1 before the first tick.
  [[nodiscard]] double value() const { return num_ticks_ > 0 ? mean_ : 1.0; }

 private:
  // -, smallest weight of the newest tick in the mean; a slow first tick soon counts little.
  static constexpr double kLeastWeight = 0.1;

  std::int64_t num_ticks_ = 0;
  double mean_ = 0.0;
};

}  // namespace kerf::host
