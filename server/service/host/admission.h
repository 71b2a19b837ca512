#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/service/host/clock.h"

namespace kerf::host {

// How much of a worker's time a running sheet needs: what its ticks take, on the wall clock, over its period, in a
// running mean. At most all of it, as a strand is never on two workers. Begins as what a tick is expected to take, so
// that a burst of new sheets counts before any of them has ticked. A plain value.
class WorkerNeed {
 public:
  static constexpr std::int64_t kWhole =
      1'000'000;  // one worker; needs are whole numbers, so that sums of them are exact
  // `period`: of a tick, > 0.
  WorkerNeed(Nanoseconds period, Nanoseconds expected_tick);
  // Guesses the tick of a sheet of which only the size is known: 300 ns a vertex, as explicit steps of cloth take at 60
  // Hz on a core of 2 to 3 GHz.
  static Nanoseconds guessed_tick(std::int64_t num_vertices);

  void tick_done(Nanoseconds wall);
  // Ticks are so far apart from now on, > 0.
  void set_period(Nanoseconds period);
  [[nodiscard]] std::int64_t value() const;  // 0..kWhole

 private:
  double period_ns_;
  double share_;  // -, 0..1
};

// Whether one more sheet may run, by the load: what running sheets need over what the workers have. Once it has refused
// it goes on refusing until the load is well below the limit: a server at its limit does not take and refuse by turns.
// A plain value.
class Admission {
 public:
  static constexpr double kReopenShare = 0.9;  // -, of the limit

  // `max_load`: -, > 0; 0: everything is admitted.
  explicit Admission(double max_load) : max_load_(max_load) {}

  // kResourceExhausted OVERLOADED. `workers` is for the message.
  Status admit(double load, std::int32_t workers);

 private:
  const double max_load_;
  bool closed_ = false;
};

}  // namespace kerf::host
