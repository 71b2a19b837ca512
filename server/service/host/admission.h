#pragma once

#include <cstdint>

#include "server/base/result.h"
#include "server/service/host/clock.h"

namespace kerf::host {

// Estimates the share of one worker thread that a running sheet needs: the running mean of the wall time of a tick over
// the period between ticks. The share is at most 1, because a sheet never runs on two workers at once. It starts from
// the expected time of a tick, so that a burst of new sheets counts before any of them has ticked. A plain value.
class WorkerNeed {
 public:
  // One worker. Needs are whole numbers, so that their sums are exact.
  static constexpr std::int64_t kWhole = 1'000'000;
  // `period`: time between ticks, > 0.
  WorkerNeed(Nanoseconds period, Nanoseconds expected_tick);
  // Guesses the tick time of a sheet from its size alone: 300 ns per vertex. The guess holds for explicit steps of
  // cloth at 60 Hz on a core of 2 to 3 GHz.
  static Nanoseconds guessed_tick(std::int64_t num_vertices);

  // Records a tick that took the wall time `wall`.
  void tick_done(Nanoseconds wall);
  // Sets the time between ticks from now on, > 0.
  void set_period(Nanoseconds period);
  [[nodiscard]] std::int64_t value() const;  // Share of one worker, 0..kWhole.

 private:
  double period_ns_;
  double share_;  // -, 0..1, running mean.
};

// Returns a need as a number of workers.
inline double in_workers(std::int64_t need) {
  return static_cast<double>(need) / static_cast<double>(WorkerNeed::kWhole);
}

// Decides whether one more sheet may run. The load is the sum of the needs of all running sheets, in workers, over the
// number of workers. After a refusal, sheets are refused until the load is below kReopenShare of the limit. Thus
// admissions and refusals do not alternate. A plain value.
class Admission {
 public:
  static constexpr double kReopenShare = 0.9;  // -, share of the limit below which sheets are admitted again.

  // `max_load`: load from which sheets are refused, -, > 0; 0 admits every sheet.
  explicit Admission(double max_load) : max_load_(max_load) {}

  // Admits one more sheet at the present `load`, or returns kResourceExhausted OVERLOADED. `workers`: number of
  // workers, for the error message only.
  Status admit(double load, std::int32_t workers);

 private:
  const double max_load_;
  bool closed_ = false;  // True from a refusal until a sheet is admitted again.
};

}  // namespace kerf::host
