#include "server/service/stream/window_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf::stream {
namespace {

// Acknowledgements of a new viewer that are measured before the window may grow.
constexpr std::int32_t kMeasuredAlone = 2;
constexpr double kSmoothing = 0.25;    // -; weight of the newest measurement
constexpr std::size_t kEmptyWays = 4;  // Number of measurements behind w0.
constexpr double kMostWaiting = 1.0;   // Frames queued in the link above which the window shrinks.
constexpr double kFewWaiting = 0.5;    // Frames queued in the link below which it may grow.
constexpr double kMostHeldUp = 0.75;   // -, share of `interval` for which a frame may wait at the reader behind others.
constexpr double kShortestWayS = 1.0e-6;

double seconds_of(Nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

void smooth(double& mean, double value) {
  mean = mean == 0.0 ? value : mean + kSmoothing * (value - mean);
}

}  // namespace

// Starts with a window of 1: a second frame could wait behind the first until the reader reports how long it holds one.
WindowControl::WindowControl(std::int32_t fixed) : adapts_(fixed == 0), window_(std::max(fixed, 1)) {}

double WindowControl::wanted(double interval_s) const {
  const double every_s = std::max({interval_s, held_s_, kShortestWayS});
  return std::floor((empty_way_s_ + held_s_ + kMostHeldUp * interval_s) / every_s);
}

void WindowControl::acknowledged(Nanoseconds total, Nanoseconds held, bool alone, Nanoseconds interval) {
  if (!adapts_) return;
  if (!std::exchange(is_told_, true)) {
    // Ignores the first frame of a new viewer, which is larger than all that follow. The first frames that follow are
    // measured one by one before the window grows.
    since_change_ = -kMeasuredAlone;
    return;
  }
  const double way_s = std::max(kShortestWayS, seconds_of(total - held));
  smooth(way_s_, way_s);
  smooth(held_s_, seconds_of(held));
  if (alone) {
    empty_ways_s_.push_back(way_s);
    if (empty_ways_s_.size() > kEmptyWays) empty_ways_s_.pop_front();
    empty_way_s_ = *std::min_element(empty_ways_s_.begin(), empty_ways_s_.end());
  }
  empty_way_s_ = empty_way_s_ == 0.0 ? way_s : std::min(empty_way_s_, way_s);

  // Takes one step per window of acknowledgements: earlier ones concern frames sent under another window.
  if (++since_change_ < window_) return;
  const double waiting = window_ * (1.0 - empty_way_s_ / std::max(way_s_, empty_way_s_));
  const auto wish = static_cast<std::int32_t>(std::clamp(wanted(seconds_of(interval)), 1.0, double{kMaxWindow}));
  std::int32_t next = window_;
  if (window_ > wish || waiting > kMostWaiting) {
    next = window_ - 1;
  } else if (window_ < wish && waiting < kFewWaiting) {
    next = window_ + 1;
  }
  next = std::clamp(next, 1, kMaxWindow);
  if (next == window_) return;
  window_ = next;
  since_change_ = 0;
}

Nanoseconds WindowControl::pause_before_new() const {
  const double between_s = (way_s_ + held_s_) / std::max(window_ - 1, 1);
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(0.5 * between_s));
}

}  // namespace kerf::stream
