#pragma once

#include <atomic>

#include "server/service/host/clock.h"

namespace kerf::host {

// Says whether the tick in progress takes long. One thread calls begin() and end(); the other functions are for any
// thread.
class TickProgress {
 public:
  // `long_tick`: time after which a tick is long. `clock` must outlive this.
  TickProgress(const Clock& clock, Nanoseconds long_tick) : clock_(clock), long_tick_(long_tick) {}

  void begin() { began_ = clock_.now(); }
  void end() {
    was_long_ = is_long();
    began_ = kNone;
  }

  // True if the tick in progress has become long.
  [[nodiscard]] bool is_long() const {
    const Nanoseconds began = began_;
    return began != kNone && clock_.now() - began > long_tick_;
  }
  // True if the last tick that ended was long.
  [[nodiscard]] bool was_long() const { return was_long_; }
  // True if the tick in progress is long, or is likely to become so because the one before it was.
  [[nodiscard]] bool is_expected_long() const { return is_long() || (was_long_ && began_.load() != kNone); }

 private:
  static constexpr Nanoseconds kNone = Nanoseconds::max();

  const Clock& clock_;
  const Nanoseconds long_tick_;
  std::atomic<Nanoseconds> began_{kNone};  // Start of the tick in progress.
  std::atomic<bool> was_long_{false};
};

}  // namespace kerf::host
