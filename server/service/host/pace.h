#pragma once

#include <atomic>
#include <cstdint>

#include "server/service/host/clock.h"

namespace kerf::host {

// Holds the total wall time that sheets have lost to other load on the machine. All sheets give up the time that one of
// them loses, so that all slip alike, regardless of their tick times. Thread-safe.
class SharedSlip {
 public:
  [[nodiscard]] Nanoseconds total() const { return Nanoseconds(total_ns_.load()); }
  // Raises the total to the loss of some sheet.
  void raise(Nanoseconds total) {
    std::int64_t before = total_ns_.load();
    while (before < total.count() && !total_ns_.compare_exchange_weak(before, total.count())) {
    }
  }

 private:
  std::atomic<std::int64_t> total_ns_{0};
};

// Schedules a sheet's ticks at absolute deadlines one period apart: the simulated time of a tick over the speed. A
// sheet catches up by at most kMaxCatchUpTicks, and gives up the rest of the time. A plain value, driven by the times
// passed in.
class Pace {
 public:
  // `tick`: simulated time of a tick, > 0; initially also its period. `shared` must outlive this.
  Pace(Nanoseconds tick, SharedSlip& shared) : tick_(tick), period_(tick), shared_(&shared) {}

  // Sets the ratio of simulated to wall time (-, > 0) from `now` on. The next tick moves to its deadline at this speed,
  // but not before `now`.
  void set_speed(double speed, Nanoseconds now);

  // Makes the next tick due at `now`, and forgets the time before.
  void start(Nanoseconds now);
  // Records a tick that ended at `end`, used `cpu` and simulated `share` of a tick, 0..1. The share is below 1 if the
  // integrator stopped early; the missing part counts as slipped time. `blocked`: time spent waiting for the sheet's
  // own files.
  void tick_done(Nanoseconds end, Nanoseconds cpu, double share, Nanoseconds blocked = Nanoseconds(0));

  [[nodiscard]] Nanoseconds deadline() const { return deadline_; }
  [[nodiscard]] std::int64_t overruns() const { return overruns_; }
  [[nodiscard]] Nanoseconds slipped() const { return slipped_; }  // Simulated time given up.
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] Nanoseconds period() const { return period_; }                 // Wall time from tick to tick.
  [[nodiscard]] double real_time_factor() const { return real_time_factor_; }  // -, over the last second or so.
  [[nodiscard]] double tick_cpu_us() const { return tick_cpu_us_; }            // us, running mean.

  // Records the time of a tick without a deadline, as in step() calls.
  void add_cpu(Nanoseconds cpu);

 private:
  // Largest share of its period that a sheet may compute for its losses to be shared; a heavier one is late by itself.
  static constexpr double kLightShare = 0.5;
  // Shortest period for losses to be shared: a wake-up a millisecond late is no loss to others.
  static constexpr Nanoseconds kShortestShared = std::chrono::milliseconds(8);

  // Adds the part of `given_up` that was lost by waiting to the shared slip, and gives up the losses of others since.
  void share_slip(Nanoseconds given_up);

  Nanoseconds tick_;
  Nanoseconds period_;
  SharedSlip* shared_;
  Nanoseconds joined_slip_{0};  // Part of the shared slip that this has given up.
  Nanoseconds waited_{0};       // Wall time without computation since the last deadline that was met.
  Nanoseconds last_end_{0};     // End of the last tick.
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
