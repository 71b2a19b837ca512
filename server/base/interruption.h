#pragma once

#include <exception>

#include "server/base/stop_condition.h"

namespace kerf {

// Thrown by interruption_point().
class Interrupted : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

// Lets a thread's work end early, at its interruption points, for as long as this exists. Scopes nest: the innermost
// decides. Construct and destroy it on the working thread.
class InterruptionScope {
 public:
  // `stop`: called on this thread, by some of the points.
  explicit InterruptionScope(StopCondition stop);
  ~InterruptionScope();
  InterruptionScope(const InterruptionScope&) = delete;
  InterruptionScope& operator=(const InterruptionScope&) = delete;

 private:
  friend void poll_stop_condition();
  const StopCondition stop_;
  InterruptionScope* const outer_;
};

// Throws Interrupted if the scope's condition is true.
void poll_stop_condition();

// Number of points from one poll of the scope's condition to the next. Each point stands for some microseconds of work.
inline constexpr int kPointsToAPoll = 256;
extern thread_local constinit int points_to_poll;

// Call it in loops that may be long. It costs a count, and now and then a poll of the scope's condition.
inline void interruption_point() {
  if (--points_to_poll <= 0) poll_stop_condition();
}

}  // namespace kerf
