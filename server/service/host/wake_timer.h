#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "server/service/host/clock.h"

namespace kerf::api {

// One timer of a stream, the earliest that was asked for: a later one is asked for again when it has fired in vain.
// Thread-safe.
class WakeTimer {
 public:
  explicit WakeTimer(host::Clock& clock) : clock_(clock) {}
  ~WakeTimer() { stop(); }
  WakeTimer(const WakeTimer&) = delete;
  WakeTimer& operator=(const WakeTimer&) = delete;

  // `fire` is called on the clock's thread, after which others may be asked for; it must begin with fired(), and may
  // come when this is gone.
  void wake_at(host::Nanoseconds deadline, std::function<void()> fire);
  void fired();
  // No more timers. Idempotent.
  void stop();

 private:
  host::Clock& clock_;
  std::mutex mutex_;
  std::optional<std::pair<host::Nanoseconds, host::TimerId>> timer_;  // guarded by mutex_
  bool stopped_ = false;                                              // likewise
};

}  // namespace kerf::api
