#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/service/host/clock.h"

namespace kerf::host {

// Estimates the share of a worker that a running sheet needs: the wall time of its ticks over its period, as a running
// mean. It is at most one worker, since a strand never runs on two. It begins with the expected time of a tick, so that
// a burst of new sheets counts before any of them has ticked. A plain value.
class WorkerNeed {
 public:
  static constexpr std::int64_t kWhole = 1'000'000;  // One worker; needs are whole numbers, so sums of them are exact.
  // `period`: time between ticks, > 0.
  WorkerNeed(Nanoseconds period, Nanoseconds expected_tick);
  // Guesses the tick time of a sheet from its size alone: 300 ns per vertex. That holds for explicit steps of cloth at
  // 60 Hz on a core of 2 to 3 GHz.
  static Nanoseconds guessed_tick(std::int64_t num_vertices);

  void tick_done(Nanoseconds wall);
  // Sets the time between ticks from now on, > 0.
  void set_period(Nanoseconds period);
  [[nodiscard]] std::int64_t value() const;  // 0..kWhole

 private:
  double period_ns_;
  double share_;  // -, 0..1
};

// Decides whether one more sheet may run. The load is the need of all running sheets over the number of workers. After
// a refusal it keeps refusing until the load is well below the limit, so that it does not alternate. A plain value.
class Admission {
 public:
  static constexpr double kReopenShare = 0.9;  // -, of the limit

  // `max_load`: -, > 0; 0 admits everything.
  explicit Admission(double max_load) : max_load_(max_load) {}

  // Admits one more sheet, or kResourceExhausted OVERLOADED. `workers` is for the message only.
  Status admit(double load, std::int32_t workers);

 private:
  const double max_load_;
  bool closed_ = false;
};

}  // namespace kerf::host
