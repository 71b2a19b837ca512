#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "server/base/result.h"
#include "server/service/stream/window_control.h"

namespace kerf::stream {

struct FlowOptions {
  std::int32_t window = 2;                             // frames in flight, 1..8; 0: see WindowControl
  double max_rate_hz = 0.0;                            // frames a second, >= 0; 0: every one there is
  std::size_t max_unacknowledged_bytes = 4 << 20;      // no frame is sent while this much or more is in flight
  Nanoseconds ack_timeout = std::chrono::seconds(10);  // for the oldest frame in flight
  bool acknowledges = true;                            // false: frames count as acknowledged once they are sent
};

// When one stream may be sent its next frame, whatever frames are made of: while fewer than `window` frames and
// max_unacknowledged_bytes are unacknowledged and max_rate_hz allows. Not thread-safe.
class FlowControl {
 public:
  explicit FlowControl(const FlowOptions& options);

  struct Permit {
    bool may_send = false;
    bool too_slow = false;  // an acknowledgement is owed for longer than ack_timeout: the stream is to be ended
    std::optional<Nanoseconds> wake_at;  // ask again then, unless something else happens before
  };
  [[nodiscard]] Permit permit(Nanoseconds now) const;

  // A frame of so many bytes is sent; `publications` (>= 0) after the one before it there were for it to show. Returns
  // its sequence: 1, 2, 3, ...
  std::int64_t sent(std::size_t bytes, std::int64_t publications, Nanoseconds now);
  [[nodiscard]] std::int64_t last_sequence() const { return last_sequence_; }

  // All frames up to `sequence` have arrived, the last of them `held` ago (0: not told). One that is acknowledged
  // already is no error. True: a window that was closed has opened.
  // kInvalidArgument ACK_OUT_OF_RANGE, field "ack.sequence": outside 1..last sent; field "ack.held_us": below 0.
  Result<bool> acknowledge(std::int64_t sequence, Nanoseconds now, Nanoseconds held);

  // From now on. max_rate_hz as in the options; while paused nothing may be sent, and no acknowledgement is owed.
  void set_pace(double max_rate_hz, bool paused, Nanoseconds now);

  [[nodiscard]] std::int32_t window() const { return window_.window(); }

 private:
  struct InFlight {
    std::int64_t sequence = 0;
    std::size_t bytes = 0;
    Nanoseconds sent_at{0};
    bool alone = false;  // nothing else was under way
  };

  // Frames that may be under way at this time.
  [[nodiscard]] std::int32_t window_at(Nanoseconds now) const;
  [[nodiscard]] bool window_open(Nanoseconds now) const;
  [[nodiscard]] Nanoseconds ack_deadline() const;  // only with a frame in flight
  // Ones of equal rates end at the same times, so that all viewers of a rate are at the same frame and share what is
  // encoded for it.
  [[nodiscard]] Nanoseconds next_slot(Nanoseconds now) const;
  void note_interval(std::int64_t publications, Nanoseconds now);
  // Removes what is acknowledged; the last of it, if any.
  std::optional<InFlight> settle(std::int64_t sequence);

  const std::size_t max_unacknowledged_bytes_;
  const Nanoseconds ack_timeout_;
  const bool acknowledges_;
  std::deque<InFlight> in_flight_;
  std::size_t bytes_in_flight_ = 0;
  std::int64_t last_sequence_ = 0;
  WindowControl window_;
  Nanoseconds new_place_from_ = Nanoseconds::min();  // the last of the window's is to be taken
  double max_rate_hz_;
  bool paused_ = false;
  Nanoseconds next_allowed_ = Nanoseconds::min();  // by max_rate_hz_
  Nanoseconds last_sent_at_{0};
  double interval_s_ = 0.0;  // between publications, smoothed; 0: not known yet
};

}  // namespace kerf::stream
