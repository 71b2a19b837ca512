#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "server/service/host/clock.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// Limits the duration of a transfer.
struct TransferTimeouts {
  host::Nanoseconds idle;   // Longest time without progress.
  host::Nanoseconds total;  // Longest time from beginning to end.
};

// Ends a call whose client is too slow to send or take data. Either the reactor or this timer ends the call, never
// both. Thread-safe.
class TransferDeadline : public std::enable_shared_from_this<TransferDeadline> {
 public:
  // Names the limit that was reached.
  enum class Timeout { kIdle, kTotal };

  // `clock` must outlive this.
  TransferDeadline(host::Clock& clock, TransferTimeouts timeouts) : clock_(clock), timeouts_(timeouts), timer_(clock) {}

  // Starts both timeouts. `on_timeout` is called on the clock's thread once one of them is reached: kIdle since this
  // call or the last made_progress(), or kTotal since this call.
  void begin(std::function<void(Timeout)> on_timeout);
  // Records progress. Returns false if it is too late: on_timeout() was or is being called.
  bool made_progress();
  // Stops the timer, because the reactor ends the call. Returns false if it is too late: on_timeout() was or is being
  // called.
  bool end();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();
  // These need mutex_ held:
  void extend();

  host::Clock& clock_;
  const TransferTimeouts timeouts_;
  host::WakeTimer timer_;
  std::mutex mutex_;
  std::function<void(Timeout)> on_timeout_;  // Null: not begun, or over. Guarded by mutex_.
  host::Nanoseconds total_deadline_{0};      // Deadline of the whole; guarded by mutex_.
  host::Nanoseconds deadline_{0};            // At most total_deadline_; guarded by mutex_.
};

}  // namespace kerf::rpc
