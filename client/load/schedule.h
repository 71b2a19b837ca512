#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

namespace kerf::load {

using Nanoseconds = std::chrono::nanoseconds;

// Returns the time of std::chrono::steady_clock.
[[nodiscard]] Nanoseconds now();
[[nodiscard]] std::int64_t microseconds(Nanoseconds time);

// Waits for the times of a schedule. Tests implement one with simulated time.
class Waiter {
 public:
  virtual ~Waiter() = default;
  [[nodiscard]] virtual Nanoseconds now() const = 0;
  // Waits until `time`, which may be past. Returns false if the waiting is ended before `time`.
  virtual bool wait_until(Nanoseconds time) = 0;
};

// Waits in real time until stop() is called. Thread-safe.
class Stopper : public Waiter {
 public:
  [[nodiscard]] Nanoseconds now() const override { return load::now(); }
  bool wait_until(Nanoseconds time) override;
  void stop();
  [[nodiscard]] bool stopped() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_ = false;
};

// Defines arrivals at times fixed beforehand: number k at start + k * interval. Latencies measured from these times,
// not from the times of sending, show a stalled server in every arrival of the stall (no coordinated omission).
struct Schedule {
  Nanoseconds start{0};
  Nanoseconds interval{1};  // > 0
  [[nodiscard]] Nanoseconds at(std::int64_t k) const { return start + k * interval; }
};

// Calls `arrive` with the number and intended time of each arrival once that time has come. Late arrivals follow at
// once; none is left out. Ends when the next arrival is at or after `end`, or when the waiter ends. Returns the number
// of arrivals.
std::int64_t run_schedule(const Schedule& schedule, Nanoseconds end, Waiter& waiter,
                          const std::function<void(std::int64_t k, Nanoseconds intended)>& arrive);

}  // namespace kerf::load
