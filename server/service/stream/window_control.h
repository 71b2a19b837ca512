#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace kerf::stream {

// Time since an arbitrary start, the same for all calls on one object.
using Nanoseconds = std::chrono::nanoseconds;

inline constexpr std::int32_t kMaxWindow = 8;

// Chooses how many frames of one stream may be in flight. The reader is to be as busy as possible, and no frame is to
// wait behind another in transit.
//
// A reader that acknowledges a frame reports how long it held the frame. The rest of the time since the frame was sent
// is the round trip time w. Let w0 be the round trip time without other frames in flight. Let t be the interval between
// frames: that between publications, or the time for which the reader holds each frame, if that is longer. Then (w0 +
// held) / t frames must be in flight: one for a slow reader, however long it holds each, eight for a quick one far
// away. The quotient is rounded up only if the last frame then waits at the reader for at most 0.75 intervals between
// publications. Thus a slow reader has fewer frames rather than old ones.
//
// Frames that would queue in a narrow link are not sent: n (1 - w0 / w) frames of a window of n queue in the link. The
// window shrinks while that is more than one. (L. Brakmo, L. Peterson, "TCP Vegas", 1995.)
class WindowControl {
 public:
  // `fixed`: 1..kMaxWindow sets a constant window. 0 starts at 1 and adapts once acknowledgements report how long
  // frames were held; it stays 1 without such reports.
  explicit WindowControl(std::int32_t fixed);

  [[nodiscard]] std::int32_t window() const { return window_; }
  // Returns how long to wait, after an acknowledgement that enlarged the window, before the additional frame is sent.
  // The additional frame then arrives halfway between two others. Sent right behind one of them, it would wait at the
  // reader.
  [[nodiscard]] Nanoseconds pause_before_new() const;

  // Records an acknowledged frame. `total`: time since the frame was sent, > 0. `held`: part of `total` that the frame
  // spent at the reader, 0..total. `alone`: no other frame was in flight when it was sent. `interval`: shortest
  // possible time between the reader's frames.
  void acknowledged(Nanoseconds total, Nanoseconds held, bool alone, Nanoseconds interval);

 private:
  [[nodiscard]] double wanted(double interval_s) const;

  bool adapts_;
  bool is_told_ = false;  // The first acknowledgement with a reported time has come.
  std::int32_t window_;
  std::int32_t since_change_ = 0;    // Acknowledgements since the window changed.
  double way_s_ = 0.0;               // Round trip time, smoothed; 0 before the first.
  double held_s_ = 0.0;              // Time for which the reader holds a frame, smoothed; 0 before the first.
  double empty_way_s_ = 0.0;         // w0
  std::deque<double> empty_ways_s_;  // The last few round trip times measured without other frames in flight.
};

}  // namespace kerf::stream
