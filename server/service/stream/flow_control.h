#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "server/base/result.h"
#include "server/service/stream/window_control.h"

namespace kerf::stream {

struct FlowOptions {
  std::int32_t window = 2;                         // Limit on frames in flight, 1..8; 0: adaptive, see WindowControl.
  double max_rate_hz = 0.0;                        // Frames per second, >= 0; 0: no limit.
  std::size_t max_unacknowledged_bytes = 4 << 20;  // No frame is sent while at least this many bytes are in flight.
  Nanoseconds ack_timeout = std::chrono::seconds(10);  // Longest time from sending a frame to its acknowledgement.
  bool acknowledges = true;                            // False: frames count as acknowledged once they are sent.
};

// Decides when one stream may send its next frame, regardless of the frame's content. A frame is in flight from being
// sent until it is acknowledged. The stream may send while fewer than `window` frames and max_unacknowledged_bytes are
// in flight and max_rate_hz allows. Not thread-safe.
class FlowControl {
 public:
  explicit FlowControl(const FlowOptions& options);

  struct Permit {
    bool may_send = false;
    bool too_slow = false;               // No acknowledgement came within ack_timeout: the stream must end.
    std::optional<Nanoseconds> wake_at;  // Call permit() again then, unless something else happens before.
  };
  [[nodiscard]] Permit permit(Nanoseconds now) const;

  // Records a frame of `bytes` bytes as sent. `publications` (>= 0): number of snapshots published since the frame
  // before. Returns its sequence number: 1, 2, 3, ...
  std::int64_t sent(std::size_t bytes, std::int64_t publications, Nanoseconds now);
  [[nodiscard]] std::int64_t last_sequence() const { return last_sequence_; }

  // Records that all frames up to `sequence` have arrived; repeating a number is no error. `held`: time from the
  // arrival of frame `sequence` at the reader to its acknowledgement; 0 if unknown. Returns true if a closed window has
  // opened. kInvalidArgument ACK_OUT_OF_RANGE, field "ack.sequence": outside 1..last sent; field "ack.held_us": below
  // 0.
  Result<bool> acknowledge(std::int64_t sequence, Nanoseconds now, Nanoseconds held);

  // Sets the frame rate from `now` on; max_rate_hz is as in the options. While paused no frame may be sent, and no
  // acknowledgement is due.
  void set_frame_rate(double max_rate_hz, bool paused, Nanoseconds now);

  [[nodiscard]] std::int32_t window() const { return window_.window(); }

 private:
  struct InFlight {
    std::int64_t sequence = 0;
    std::size_t bytes = 0;
    Nanoseconds sent_at{0};
    bool alone = false;  // No other frame was in flight when this one was sent.
  };

  // Returns how many frames may be in flight at this time.
  [[nodiscard]] std::int32_t window_at(Nanoseconds now) const;
  [[nodiscard]] bool window_open(Nanoseconds now) const;
  [[nodiscard]] Nanoseconds ack_deadline() const;  // Requires a frame in flight.
  // Returns the end of the present time slot, whose length is 1 / max_rate_hz. Slots of equal length end at the same
  // times for all viewers. Thus viewers of one rate show the same frame and share its encoding.
  [[nodiscard]] Nanoseconds next_slot(Nanoseconds now) const;
  void note_interval(std::int64_t publications, Nanoseconds now);
  // Removes acknowledged frames; returns the last of them, if any.
  std::optional<InFlight> settle(std::int64_t sequence);

  const std::size_t max_unacknowledged_bytes_;
  const Nanoseconds ack_timeout_;
  const bool acknowledges_;
  std::deque<InFlight> in_flight_;
  std::size_t bytes_in_flight_ = 0;
  std::int64_t last_sequence_ = 0;
  WindowControl window_;
  Nanoseconds new_place_from_ = Nanoseconds::min();  // A place by which the window has grown may be used from then on.
  double max_rate_hz_;
  bool paused_ = false;
  Nanoseconds next_allowed_ = Nanoseconds::min();  // Earliest next frame by max_rate_hz_.
  Nanoseconds last_sent_at_{0};
  double interval_s_ = 0.0;  // Time between publications, smoothed; 0: not known yet.
};

}  // namespace kerf::stream
