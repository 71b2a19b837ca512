#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/host/clock.h"

namespace kerf::host {

// Holds one timer of a stream, for the earliest deadline requested. A later deadline is ignored, and must be
// requested again after the timer has fired. Thread-safe.
class WakeTimer {
 public:
  explicit WakeTimer(Clock& clock) : clock_(clock) {}
  ~WakeTimer() { stop(); }
  WakeTimer(const WakeTimer&) = delete;
  WakeTimer& operator=(const WakeTimer&) = delete;

  // Calls `fire` at `deadline` on the clock's thread. `fire` must first call fired(); new deadlines may be requested
  // from then on. `fire` may be called after this object is destroyed.
  void wake_at(Nanoseconds deadline, std::function<void()> fire);
  void fired();
  // Cancels the timer and refuses new ones. Idempotent.
  void stop();

 private:
  Clock& clock_;
  std::mutex mutex_;
  std::optional<std::pair<Nanoseconds, TimerId>> timer_;  // guarded by mutex_
  bool stopped_ = false;                                  // Guarded by mutex_.
};

}  // namespace kerf::host
