#pragma once

#include <exception>

#include "server/base/stop_condition.h"

namespace kerf {

// Thrown by interruption_point().
class Interrupted : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

// Lets a thread's work end early, at its interruption points, for as long as this exists. Scopes may nest; only the
// condition of the innermost one is polled. Construct and destroy it on the working thread.
class InterruptionScope {
 public:
  // `stop`: polled on this thread, at one of kPointsToAPoll interruption points.
  explicit InterruptionScope(StopCondition stop);
  ~InterruptionScope();
  InterruptionScope(const InterruptionScope&) = delete;
  InterruptionScope& operator=(const InterruptionScope&) = delete;

 private:
  friend void poll_stop_condition();
  const StopCondition stop_;
  InterruptionScope* const outer_;
};

// Throws Interrupted if the stop condition of the innermost scope is true.
void poll_stop_condition();

// Number of interruption points from one poll of the stop condition to the next. Between two points lie some
// microseconds of work.
inline constexpr int kPointsToAPoll = 256;
extern thread_local constinit int points_to_poll;

// Throws Interrupted if the work of this thread is to end early; call it in loops that may be long. Most calls only
// count down; every kPointsToAPoll-th one polls the stop condition.
inline void interruption_point() {
  if (--points_to_poll <= 0) poll_stop_condition();
}

}  // namespace kerf
