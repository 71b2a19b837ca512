#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "server/service/host/clock.h"
#include "server/service/host/ready_signal.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// Detects a write that does not complete because its reader takes nothing. Thread-safe.
class WriteWatch : public std::enable_shared_from_this<WriteWatch> {
 public:
  // `clock` must outlive this.
  WriteWatch(host::Clock& clock, host::Nanoseconds limit) : clock_(clock), limit_(limit), timer_(clock) {}

  // Sets `stuck`, called on the clock's thread whenever a write has been in progress for the limit.
  void watch(std::function<void()> stuck) { stuck_.set(std::move(stuck)); }
  void begun();
  void done();
  // Ends the calls of `stuck`; waits for one in progress, unless that encloses this call. Idempotent.
  void stop();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();

  host::Clock& clock_;
  const host::Nanoseconds limit_;
  api::ReadySignal stuck_;
  api::WakeTimer timer_;
  std::mutex mutex_;
  std::optional<host::Nanoseconds> begun_at_;  // Start of the write in progress; guarded by mutex_.
  bool is_timed_ = false;                      // A timer is set, or about to be; guarded by mutex_.
};

}  // namespace kerf::rpc
