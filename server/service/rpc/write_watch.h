#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "server/service/host/clock.h"
#include "server/service/host/ready_signal.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// Tells of a write that does not return because its reader takes nothing. Thread-safe.
class WriteWatch : public std::enable_shared_from_this<WriteWatch> {
 public:
  // `clock` must outlive this.
  WriteWatch(host::Clock& clock, host::Nanoseconds limit) : clock_(clock), limit_(limit), timer_(clock) {}

  // `stuck` is called on the clock's thread whenever a write has been under way for the limit.
  void watch(std::function<void()> stuck) { stuck_.set(std::move(stuck)); }
  void begun();
  void done();
  // No more calls of `stuck`; waits for one that is under way, unless this comes from within it. Idempotent.
  void stop();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();

  host::Clock& clock_;
  const host::Nanoseconds limit_;
  api::ReadySignal stuck_;
  api::WakeTimer timer_;
  std::mutex mutex_;
  std::optional<host::Nanoseconds> begun_at_;  // of the write under way; guarded by mutex_
  bool is_timed_ = false;                      // a timer is set, or about to be; guarded by mutex_
};

}  // namespace kerf::rpc
