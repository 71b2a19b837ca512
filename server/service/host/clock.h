#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

namespace kerf::host {

// Represents a time, counted from an arbitrary start that is fixed for each clock, or the length of a span of time.
using Nanoseconds = std::chrono::nanoseconds;

inline double seconds(Nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}
inline double microseconds(Nanoseconds time) {
  return 1.0e6 * seconds(time);
}

enum class TimerId : std::uint64_t {};

// Provides the server's only notion of time: real in the daemon, moved by hand in tests and simulation. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  // Returns the present time, which never decreases.
  [[nodiscard]] virtual Nanoseconds now() const = 0;
  // Microseconds since 1970, for display only: it jumps when the machine's clock is set.
  [[nodiscard]] virtual std::int64_t unix_us() const = 0;
  // Returns the CPU time used by the calling thread so far.
  [[nodiscard]] virtual Nanoseconds thread_cpu() const = 0;
  // Calls `fire` once, at or soon after `deadline`, on a thread of the clock's choice. A deadline in the past fires at
  // once. `fire` must not block; it should post its work to another thread.
  virtual TimerId schedule(Nanoseconds deadline, std::function<void()> fire) = 0;
  // Cancels a timer. Returns true if `fire` will not be called, false if it was called or is being called now.
  virtual bool cancel(TimerId timer) = 0;
};

// Reads the machine's clocks; runs timers on one thread of its own.
class RealClock : public Clock {
 public:
  RealClock();
  // Drops pending timers without firing them.
  ~RealClock() override;
  RealClock(const RealClock&) = delete;
  RealClock& operator=(const RealClock&) = delete;

  [[nodiscard]] Nanoseconds now() const override;
  [[nodiscard]] std::int64_t unix_us() const override;
  [[nodiscard]] Nanoseconds thread_cpu() const override;
  TimerId schedule(Nanoseconds deadline, std::function<void()> fire) override;
  bool cancel(TimerId timer) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::host
