#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "server/service/host/clock.h"
#include "server/service/host/wake_timer.h"

namespace kerf::rpc {

// How long a transfer may take.
struct PatienceLimits {
  host::Nanoseconds silence;  // while nothing moves
  host::Nanoseconds whole;    // from its beginning to its end
};

// How long a call waits for its client to send or take what is next. Either its reactor ends the call, or this does:
// whoever is first, and never both. Thread-safe.
class Patience : public std::enable_shared_from_this<Patience> {
 public:
  // Which limit was reached.
  enum class Lapse { kSilence, kWhole };

  // `clock` must outlive this.
  Patience(host::Clock& clock, PatienceLimits limits) : clock_(clock), limits_(limits), timer_(clock) {}

  // `give_up` is called on the clock's thread, once nothing has moved for the limit since this or the last moved(), or
  // once the whole has taken longer than its own.
  void begin(std::function<void(Lapse)> give_up);
  // Something came, or was taken. False: it is too late, give_up() was or is being called.
  bool moved();
  // The call is ended by its reactor, unless this is false: then give_up() was or is being called.
  bool end();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();
  // With mutex_ held:
  void wait_anew();

  host::Clock& clock_;
  const PatienceLimits limits_;
  api::WakeTimer timer_;
  std::mutex mutex_;
  std::function<void(Lapse)> give_up_;  // null: not begun, or over. Guarded by mutex_
  host::Nanoseconds end_{0};            // of the whole; guarded by mutex_
  host::Nanoseconds deadline_{0};       // at most end_; guarded by mutex_
};

}  // namespace kerf::rpc
