#pragma once

#include <atomic>
#include <cstdint>

#include "server/service/host/clock.h"

namespace kerf::host {

// Time of the wall that sheets have lost to a machine that was busy with something else. What one of them loses all
// lose, so that their time slips alike, whatever a tick of each takes. Thread-safe.
class SharedSlip {
 public:
  [[nodiscard]] Nanoseconds total() const { return Nanoseconds(total_ns_.load()); }
  // Some sheet has lost so much of it.
  void raise(Nanoseconds total) {
    std::int64_t before = total_ns_.load();
    while (before < total.count() && !total_ns_.compare_exchange_weak(before, total.count())) {
    }
  }

 private:
  std::atomic<std::int64_t> total_ns_{0};
};

// When a sheet's next tick is due, and how it keeps up: absolute deadlines a period apart, which is what a tick
// simulates over the speed, at most kMaxCatchUpTicks late, the rest of the time given up. A plain value, driven by the
// times it is told.
class Pace {
 public:
  // `tick`: what one simulates, > 0; at first it takes as long. `shared` must outlive this.
  Pace(Nanoseconds tick, SharedSlip& shared) : tick_(tick), period_(tick), shared_(&shared) {}

  // From `now` on, simulated time goes at `speed` (-, > 0) of the wall's. The tick to come is due as long after the one
  // before it as it would have been at this speed, but not before `now`.
  void set_speed(double speed, Nanoseconds now);

  // The next tick is due at `now`; time before is forgotten.
  void start(Nanoseconds now);
  // A tick that was due ended at `end`, having used `cpu` and simulated `share` of a tick, 0..1: less than all of it
  // where the integrator had to stop short, and what is missing is slipped time like any other. `blocked`: of the time
  // that it did not compute, what it waited for its own files.
  void tick_done(Nanoseconds end, Nanoseconds cpu, double share, Nanoseconds blocked = Nanoseconds(0));

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
  // At most this share of its time a sheet computes whose losses count for all: a heavier one is late by itself.
  static constexpr double kLightShare = 0.5;
  // So is one whose period is shorter: a wake-up that is a millisecond late is no loss to others.
  static constexpr Nanoseconds kShortestShared = std::chrono::milliseconds(8);

  // Adds what was lost to waiting of `given_up` to what all lose, and gives up what others have lost since.
  void share_slip(Nanoseconds given_up);

  Nanoseconds tick_;
  Nanoseconds period_;
  SharedSlip* shared_;
  Nanoseconds joined_slip_{0};  // as much of the shared one as this has given up
  Nanoseconds waited_{0};       // wall time that the ticks since the last deadline that was met did not compute in
  Nanoseconds last_end_{0};     // of a tick
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
