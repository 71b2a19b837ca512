#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "server/service/host/clock.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// Limits the duration of a transfer.
struct PatienceLimits {
  host::Nanoseconds silence;  // Longest time without progress.
  host::Nanoseconds whole;    // Longest time from beginning to end.
};

// Ends a call whose client is too slow to send or take data. Exactly one of the reactor and this timer ends it.
// Thread-safe.
class Patience : public std::enable_shared_from_this<Patience> {
 public:
  // Names the limit that was reached.
  enum class Lapse { kSilence, kWhole };

  // `clock` must outlive this.
  Patience(host::Clock& clock, PatienceLimits limits) : clock_(clock), limits_(limits), timer_(clock) {}

  // Starts both limits. `give_up` is called on the clock's thread once one of them is reached: kSilence since this call
  // or the last moved(), or kWhole since this call.
  void begin(std::function<void(Lapse)> give_up);
  // Records progress. Returns false if it is too late: give_up() was or is being called.
  bool moved();
  // Stops the timer, because the reactor ends the call. Returns false if it is too late: give_up() was or is being
  // called.
  bool end();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();
  // These need mutex_ held:
  void wait_anew();

  host::Clock& clock_;
  const PatienceLimits limits_;
  api::WakeTimer timer_;
  std::mutex mutex_;
  std::function<void(Lapse)> give_up_;  // Null: not begun, or over. Guarded by mutex_.
  host::Nanoseconds end_{0};            // Deadline of the whole; guarded by mutex_.
  host::Nanoseconds deadline_{0};       // At most end_; guarded by mutex_.
};

}  // namespace kerf::rpc
