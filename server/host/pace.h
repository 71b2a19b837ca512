#pragma once

#include <cstdint>

#include "server/host/clock.h"

namespace kerf::host {

// When a sheet's next tick is due, and how it keeps up: absolute deadlines a period apart, which is what a tick
// simulates over the speed, at most kMaxCatchUpTicks late, the rest of the time given up. A plain value, driven by the
// times it is told.
class Pace {
 public:
  // `tick`: what one simulates, > 0; at first it takes as long.
  explicit Pace(Nanoseconds tick) : tick_(tick), period_(tick) {}

  // From `now` on, simulated time goes at `speed` (-, > 0) of the wall's. The tick to come is due as long after the one
  // before it as it would have been at this speed, but not before `now`.
  void set_speed(double speed, Nanoseconds now);

  // The next tick is due at `now`; time before is forgotten.
  void start(Nanoseconds now);
  // A tick that was due ended at `end`, having used `cpu` and simulated `share` of a tick, 0..1: less than all of it
  // where the integrator had to stop short, and what is missing is slipped time like any other.
  void tick_done(Nanoseconds end, Nanoseconds cpu, double share);

  [[nodiscard]] Nanoseconds deadline() const { return deadline_; }
  [[nodiscard]] std::int64_t overruns() const { return overruns_; }
  [[nodiscard]] Nanoseconds slipped() const { return slipped_; }  // simulated time
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] Nanoseconds period() const { return period_; }                 // of the wall, from tick to tick
  [[nodiscard]] double real_time_factor() const { return real_time_factor_; }  // -, over the last second or so
  [[nodiscard]] double tick_cpu_us() const { return tick_cpu_us_; }            // us, mean over the last ticks

  // A tick that was not timed against a deadline: step() calls.
  void add_cpu(Nanoseconds cpu);

 private:
  Nanoseconds tick_;
  Nanoseconds period_;
  double speed_ = 1.0;
  Nanoseconds deadline_{0};
  Nanoseconds slipped_{0};
  std::int64_t overruns_ = 0;
  Nanoseconds window_begin_{0};
  double window_ticks_ = 0.0;
  double real_time_factor_ = 1.0;
  double tick_cpu_us_ = 0.0;
};

}  // namespace kerf::host
