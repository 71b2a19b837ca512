#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

namespace kerf::cli {

// Measures a viewer's stream: rates of the last two seconds, and totals.
class WatchMeter {
 public:
  struct Frame {
    double at_s = 0.0;  // Arrival, on any clock that never decreases.
    std::int64_t tick = 0;
    std::size_t bytes = 0;
    double age_ms = 0.0;       // From the end of the frame's tick until the frame arrived.
    std::int64_t skipped = 0;  // Ticks since the frame before that were not sent.
    std::int32_t vertices = 0;
    std::int32_t pieces = 0;
    double real_time_factor = 1.0;
  };

  void add(const Frame& frame);

  // Returns "tick 812  60.0 fps  12.4 kB/s  age p50 1.2 p95 3.4 ms  skipped 0  2500 vertices 3 pieces  x1.00 real
  // time".
  [[nodiscard]] std::string status() const;
  // Returns some lines about the whole stream; ages are those of the last 4096 frames.
  [[nodiscard]] std::string summary() const;

  [[nodiscard]] std::int64_t frames() const { return frames_; }

 private:
  std::deque<Frame> recent_;  // Frames that arrived in the last two seconds.
  std::vector<double> ages_;  // Ages of the last 4096 frames, ms, as a ring buffer.
  std::int64_t frames_ = 0;
  std::int64_t skipped_ = 0;
  std::uint64_t bytes_ = 0;
  double first_s_ = 0.0;
};

}  // namespace kerf::cli
