#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "server/service/host/clock.h"
#include "server/service/host/wake_callback.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// Detects a write that does not complete because its reader takes nothing. Thread-safe.
class WriteTimeout : public std::enable_shared_from_this<WriteTimeout> {
 public:
  // `clock` must outlive this.
  WriteTimeout(host::Clock& clock, host::Nanoseconds timeout) : clock_(clock), timeout_(timeout), timer_(clock) {}

  // Sets `on_timeout`, called on the clock's thread whenever a write has been in progress for `timeout`.
  void begin(std::function<void()> on_timeout) { on_timeout_.set(std::move(on_timeout)); }
  void write_begun();
  void write_done();
  // Ends the calls of `on_timeout`, and waits for one in progress, unless stop() is called from within it. Idempotent.
  void stop();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();

  host::Clock& clock_;
  const host::Nanoseconds timeout_;
  host::WakeCallback on_timeout_;
  host::WakeTimer timer_;
  std::mutex mutex_;
  std::optional<host::Nanoseconds> begun_at_;  // Start of the write in progress; guarded by mutex_.
  bool is_timed_ = false;                      // A timer is set, or about to be; guarded by mutex_.
};

}  // namespace kerf::rpc
