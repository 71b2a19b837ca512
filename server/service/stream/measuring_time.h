#pragma once

#include <atomic>
#include <functional>
#include <utility>

#include "server/service/stream/window_control.h"

namespace kerf::stream {

// Limits the time that measurements for streams take of a sheet's strand: to a fifth of it, and to kLongest before a
// tick, apart from one measurement that takes longer by itself. For one thread, except rests_until().
class MeasuringTime {
 public:
  static constexpr Nanoseconds kLongest = std::chrono::milliseconds(2);
  static constexpr int kRest = 4;  // Time without measurements, over the time that they took before.

  // `now`: returns the time; null: time stands still, and nothing is limited.
  explicit MeasuringTime(std::function<Nanoseconds()> now) : now_(std::move(now)) {}

  [[nodiscard]] Nanoseconds now() const { return now_ ? now_() : Nanoseconds(0); }
  // Returns false if no measurement may begin yet.
  [[nodiscard]] bool begin() {
    begun_at_ = now();
    return begun_at_ >= rests_until();
  }
  // Returns false if the measurements since begin() have taken so long that others must wait.
  [[nodiscard]] bool may_continue() const { return now() - begun_at_ < kLongest; }
  void end() {
    const Nanoseconds at = now();
    rests_until_ = at + kRest * (at - begun_at_);
  }
  // Returns the time from which on a measurement may begin.
  [[nodiscard]] Nanoseconds rests_until() const { return rests_until_.load(); }

 private:
  std::function<Nanoseconds()> now_;
  Nanoseconds begun_at_{0};
  std::atomic<Nanoseconds> rests_until_{Nanoseconds::min()};
};

}  // namespace kerf::stream
