#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "server/service/host/clock.h"
#include "server/service/host/pace.h"

namespace kerf::host {

// Decides when a sheet ticks: it keeps the deadlines of a Pace, the one timer for the next of them, and whether time
// passes at all.
//
//              pause()                 sleep()
//   kPaused <------------ kRunning -------------> kSleeping
//           ------------>          <-------------
//              resume()                 wake()
//
// pause() also leads from kSleeping to kPaused. resume() and wake() set no timer; start() does.
//
// Invariants:
//   1. At most one timer is set. None is after stop(), pause() or sleep().
//   2. accept() returns true only for calls made since the last stop().
// For one thread at a time.
class TickClock {
 public:
  enum class Mode {
    kRunning,
    kPaused,
    kSleeping,  // Time passes again once the sheet is changed.
  };
  // Receives a due tick, with a number for accept(). Called on a thread of the clock, or within the call that sets the
  // timer if the deadline has passed. Must post its work; may be called after the TickClock is gone.
  using Due = std::function<void(std::uint64_t call)>;

  // `tick`: simulated time of a tick, > 0. `slip` and `clock` must outlive this.
  TickClock(Nanoseconds tick, SharedSlip& slip, Clock& clock) : clock_(clock), pace_(tick, slip) {}

  // Sets the receiver of due ticks. To be called before any timer is set.
  void set_due(Due due) { due_ = std::move(due); }

  [[nodiscard]] Mode mode() const { return mode_; }
  [[nodiscard]] bool is_paused() const { return mode_ == Mode::kPaused; }
  [[nodiscard]] bool is_sleeping() const { return mode_ == Mode::kSleeping; }
  void pause();
  void resume() { mode_ = Mode::kRunning; }
  void sleep();
  void wake() { mode_ = Mode::kRunning; }

  // Makes the next tick due now.
  void start();
  // Removes the timer. Calls that were made already are no longer accepted.
  void stop();
  // Sets the timer for the next deadline.
  void set_timer();
  // Sets the timer to fire after `periods`, >= 0, of Pace::period() from now.
  void set_timer_after(std::int64_t periods);
  // Calls the receiver of set_due() at once, without a timer.
  void call_now() const { due_(generation_); }
  [[nodiscard]] bool has_timer() const { return timer_.has_value(); }
  // Returns true unless stop() was called after the call with this number was prepared. The timer then counts as fired.
  bool accept(std::uint64_t call);

  // Sets the ratio of simulated to wall time, -, > 0. A timer that is set stays as it is.
  void set_speed(double speed) { pace_.set_speed(speed, clock_.now()); }
  [[nodiscard]] const Pace& pace() const { return pace_; }
  // Record a tick, or only its CPU time; see the functions of the same names in Pace.
  void tick_done(Nanoseconds end, Nanoseconds cpu, double share, Nanoseconds blocked) {
    pace_.tick_done(end, cpu, share, blocked);
  }
  void add_cpu(Nanoseconds cpu) { pace_.add_cpu(cpu); }

 private:
  Clock& clock_;
  Pace pace_;
  Due due_;
  Mode mode_ = Mode::kRunning;
  std::optional<TimerId> timer_;
  std::uint64_t generation_ = 0;  // Number of calls of stop(); calls of older generations are outdated.
};

}  // namespace kerf::host
