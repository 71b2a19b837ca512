#pragma once

#include <atomic>
#include <cstdint>

#include "server/service/host/clock.h"

namespace kerf::host {

// Holds the total wall time that sheets have lost because other load kept the machine busy. Time that one sheet loses
// is given up by all sheets. Thus all fall behind by the same time, regardless of how long their ticks take.
// Thread-safe.
class SharedSlip {
 public:
  [[nodiscard]] Nanoseconds total() const { return Nanoseconds(total_ns_.load()); }
  // Raises the total to `total`, the time that one sheet has given up for shared losses so far.
  void raise(Nanoseconds total) {
    std::int64_t before = total_ns_.load();
    while (before < total.count() && !total_ns_.compare_exchange_weak(before, total.count())) {
    }
  }

 private:
  std::atomic<std::int64_t> total_ns_{0};
};

// Schedules a sheet's ticks at absolute deadlines. They are one period apart: the simulated time of a tick over the
// speed. A late sheet catches up by at most Host::kMaxCatchUpTicks, and gives up the rest of the time. A plain value,
// driven by the times passed in.
class Pace {
 public:
  // `tick`: simulated time of a tick, > 0; initially also its period. `shared` must outlive this.
  Pace(Nanoseconds tick, SharedSlip& shared) : tick_(tick), period_(tick), shared_(&shared) {}

  // Sets the ratio of simulated to wall time (-, > 0) from `now` on. The next deadline moves by the change of the
  // period, but not to before `now`.
  void set_speed(double speed, Nanoseconds now);

  // Makes the next tick due at `now`. Time before `now` is not caught up.
  void start(Nanoseconds now);
  // Records a tick that ended at `end`, used `cpu` and simulated `share` of a tick, 0..1. The share is below 1 if the
  // integrator stopped early; the missing part counts as slipped time. `blocked`: wall time of the tick spent waiting
  // for the sheet's own recording file.
  void tick_done(Nanoseconds end, Nanoseconds cpu, double share, Nanoseconds blocked = Nanoseconds(0));

  [[nodiscard]] Nanoseconds deadline() const { return deadline_; }
  [[nodiscard]] std::int64_t overruns() const { return overruns_; }
  [[nodiscard]] Nanoseconds slipped() const { return slipped_; }  // Simulated time given up.
  [[nodiscard]] double speed() const { return speed_; }
  [[nodiscard]] Nanoseconds period() const { return period_; }  // Wall time from tick to tick.
  // -, simulated over wall time, last second or so.
  [[nodiscard]] double real_time_factor() const { return real_time_factor_; }
  [[nodiscard]] double tick_cpu_us() const { return tick_cpu_us_; }  // us, running mean of the CPU time of a tick.

  // Records the CPU time of a tick without a deadline, as in step() calls.
  void add_cpu(Nanoseconds cpu);

 private:
  // Largest mean CPU time of a tick, as a share of the period, of a sheet whose losses are shared. A sheet with longer
  // ticks is late because of its own work.
  static constexpr double kLightShare = 0.5;
  // Shortest period of a sheet whose losses are shared. With shorter periods a wake-up that is a millisecond late
  // already loses time, which other sheets need not give up.
  static constexpr Nanoseconds kShortestShared = std::chrono::milliseconds(8);

  // Adds to the shared slip the part of `given_up` that the sheet lost by waiting for a processor. Then gives up the
  // time that other sheets have added since.
  void share_slip(Nanoseconds given_up);

  Nanoseconds tick_;
  Nanoseconds period_;
  SharedSlip* shared_;
  Nanoseconds joined_slip_{0};  // Part of the shared slip that this sheet has given up.
  Nanoseconds waited_{0};       // Wall time spent waiting for a processor since the last deadline that was met.
  Nanoseconds last_end_{0};     // End of the last tick.
  double speed_ = 1.0;
  Nanoseconds deadline_{0};
  Nanoseconds slipped_{0};
  std::int64_t overruns_ = 0;
  Nanoseconds window_begin_{0};  // Start of the time over which real_time_factor_ is measured.
  double window_ticks_ = 0.0;    // Ticks simulated since window_begin_, with fractions.
  double real_time_factor_ = 1.0;
  double tick_cpu_us_ = 0.0;
};

}  // namespace kerf::host
