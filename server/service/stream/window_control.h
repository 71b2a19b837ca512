#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace kerf::stream {

// Since any fixed start, the same for all calls on one object.
using Nanoseconds = std::chrono::nanoseconds;

inline constexpr std::int32_t kMaxWindow = 8;

// How many frames of one stream may be under way, so that the reader is kept as busy as it can be and no frame waits
// behind another on the way.
//
// A reader that acknowledges tells how long it held the frame: what is left of the time since it was sent is the way
// there and back. A way of w with a frame wanted every t seconds (the sheet's tick, or how long the reader holds each,
// if that is longer) needs (w + held) / t frames under way: one for a slow reader however far it is from being done,
// eight for a quick one far away. That is rounded up only where the last of them waits at the reader for less than a
// tick: a slow reader has fewer frames rather than old ones. Frames that would wait in a narrow link are not sent: when
// the way takes longer than it does when nothing else is on it, w0, then window (1 - w0 / w) frames wait there (L.
// Brakmo, L. Peterson, "TCP Vegas", 1995), and the window shrinks while that is more than one.
class WindowControl {
 public:
  // fixed 1..kMaxWindow: the window, whatever is acknowledged; 0: from 1 what is wanted, as soon as acknowledgements
  // tell how long a frame was held, and 1 where they do not.
  explicit WindowControl(std::int32_t fixed);

  [[nodiscard]] std::int32_t window() const { return window_; }
  // After a window has grown: from the acknowledgement so long until its new place is taken. That puts the new frame
  // halfway between two others; right behind one of them it would wait at the reader.
  [[nodiscard]] Nanoseconds pause_before_new() const;

  // A frame was acknowledged. `total`: since it was sent, > 0; `held`: of that, by the reader, in 0..total; `alone`:
  // nothing else was under way when it was sent; `interval`: between the frames that the reader could have at most.
  void acknowledged(Nanoseconds total, Nanoseconds held, bool alone, Nanoseconds interval);

 private:
  [[nodiscard]] double wanted(double interval_s) const;

  bool adapts_;
  bool is_told_ = false;
  std::int32_t window_;
  std::int32_t since_change_ = 0;    // acknowledgements
  double way_s_ = 0.0;               // smoothed; 0 before the first
  double held_s_ = 0.0;              // likewise
  double empty_way_s_ = 0.0;         // w0
  std::deque<double> empty_ways_s_;  // the last few that were measured with nothing else on the way
};

}  // namespace kerf::stream
