#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

namespace kerf::load {

using Nanoseconds = std::chrono::nanoseconds;

// Of std::chrono::steady_clock.
[[nodiscard]] Nanoseconds now();
[[nodiscard]] std::int64_t microseconds(Nanoseconds time);

// Where a schedule waits. Tests have one whose time they make.
class Waiter {
 public:
  virtual ~Waiter() = default;
  [[nodiscard]] virtual Nanoseconds now() const = 0;
  // Until `time`, which may be past; false: it is over, before that.
  virtual bool wait_until(Nanoseconds time) = 0;
};

// Real time, until somebody ends it. Thread-safe.
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

// Arrivals at times that are fixed beforehand: number k at start + k * interval. Whoever measures from these and not
// from when it got round to sending sees a stalled server in every arrival of the stall, and not in one (no coordinated
// omission).
struct Schedule {
  Nanoseconds start{0};
  Nanoseconds interval{1};  // > 0
  [[nodiscard]] Nanoseconds at(std::int64_t k) const { return start + k * interval; }
};

// Calls `arrive` with the number and intended time of each arrival, once that time has come, late ones at once and none
// left out, until one would be at or after `end` or the waiter says that it is over. Returns how many there were.
std::int64_t run_schedule(const Schedule& schedule, Nanoseconds end, Waiter& waiter,
                          const std::function<void(std::int64_t k, Nanoseconds intended)>& arrive);

}  // namespace kerf::load
