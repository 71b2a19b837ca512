#pragma once

#include <exception>
#include <functional>

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
  // `goes_on`: called on this thread, by some of the points; once false it must stay so.
  explicit InterruptionScope(std::function<bool()> goes_on);
  ~InterruptionScope();
  InterruptionScope(const InterruptionScope&) = delete;
  InterruptionScope& operator=(const InterruptionScope&) = delete;

 private:
  friend void ask_whether_to_go_on();
  const std::function<bool()> goes_on_;
  InterruptionScope* const outer_;
};

// Throws Interrupted if the scope's function returns false.
void ask_whether_to_go_on();

// Number of points from one call of the scope's function to the next. Each point stands for some microseconds of work.
inline constexpr int kPointsToAnAsking = 256;
extern thread_local constinit int points_to_asking;

// Call it in loops that may be long. It costs a count, and now and then a call of the scope's function.
inline void interruption_point() {
  if (--points_to_asking <= 0) ask_whether_to_go_on();
}

}  // namespace kerf
