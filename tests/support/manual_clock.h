#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/host/clock.h"

namespace kerf::test {

// A clock that moves only by move_to(). A server with this clock does nothing by itself, and its actions are
// repeatable. Timers fire on the thread that moves the clock.
class ManualClock : public host::Clock {
 public:
  [[nodiscard]] host::Nanoseconds now() const override;
  [[nodiscard]] std::int64_t unix_us() const override;  // now() in microseconds, as if started in 1970.
  // Returns now(), because simulated work takes the time that passes on this clock.
  [[nodiscard]] host::Nanoseconds thread_cpu() const override;
  host::TimerId schedule(host::Nanoseconds deadline, std::function<void()> fire) override;
  bool cancel(host::TimerId timer) override;

  // Returns the deadline of the next timer, if any.
  [[nodiscard]] std::optional<host::Nanoseconds> next_deadline() const;
  [[nodiscard]] std::size_t num_timers() const;
  // Moves to `time` (>= now()) in one jump, then fires all timers due, in the order of (deadline, schedule()). Timers
  // that the fired ones set for times already past fire too.
  void move_to(host::Nanoseconds time);

 private:
  using Key = std::pair<host::Nanoseconds, std::uint64_t>;  // deadline, timer

  mutable std::mutex mutex_;
  host::Nanoseconds now_{0};
  std::uint64_t next_timer_ = 1;
  std::map<Key, std::function<void()>> timers_;
};

}  // namespace kerf::test
