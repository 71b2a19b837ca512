#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

namespace kerf::host {

// Since an arbitrary start that is the same for all readings of one clock; never runs backwards.
using Nanoseconds = std::chrono::nanoseconds;

inline double seconds(Nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

enum class TimerId : std::uint64_t {};

// All that the server knows of time. Real in the daemon; moved by hand in tests and simulation. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Nanoseconds now() const = 0;
  // Microseconds since 1970; may jump when somebody sets the machine's clock, so only for showing.
  [[nodiscard]] virtual std::int64_t unix_us() const = 0;
  // CPU time used by the calling thread so far.
  [[nodiscard]] virtual Nanoseconds thread_cpu() const = 0;
  // Calls `fire` once, at or soon after `deadline`, from a thread of the clock's choice; a deadline in the past fires
  // at once. `fire` must not block: it hands the work to somebody.
  virtual TimerId schedule(Nanoseconds deadline, std::function<void()> fire) = 0;
  // True: `fire` will not be called. False: it was, or is being called at this moment.
  virtual bool cancel(TimerId timer) = 0;
};

// The machine's clocks, with one thread of its own for timers.
class RealClock : public Clock {
 public:
  RealClock();
  // Timers that are left do not fire.
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
