#pragma once

#include <functional>
#include <memory>
#include <mutex>

#include "server/api/wake_timer.h"
#include "server/host/clock.h"

namespace kerf::rpc {

// How long a call waits for what its client sends next. Either its reactor ends the call, or this does: whoever is
// first, and never both. Thread-safe.
class Patience : public std::enable_shared_from_this<Patience> {
 public:
  // `clock` must outlive this.
  Patience(host::Clock& clock, host::Nanoseconds limit) : clock_(clock), limit_(limit), timer_(clock) {}

  // `give_up` is called on the clock's thread, once nothing has come for the limit since this or the last arrived().
  void begin(std::function<void()> give_up);
  // Something came. False: it is too late, give_up() was or is being called.
  bool arrived();
  // The call is ended by its reactor, unless this is false: then give_up() was or is being called.
  bool end();

 private:
  void wait_until(host::Nanoseconds deadline);
  void timer_fired();

  host::Clock& clock_;
  const host::Nanoseconds limit_;
  api::WakeTimer timer_;
  std::mutex mutex_;
  std::function<void()> give_up_;  // null: not begun, or over. Guarded by mutex_
  host::Nanoseconds deadline_{0};  // guarded by mutex_
};

}  // namespace kerf::rpc
