#include "server/service/stream/flow_control.h"

#include <algorithm>
#include <string>

namespace kerf::stream {

FlowControl::FlowControl(const FlowOptions& options)
    : max_unacknowledged_bytes_(options.max_unacknowledged_bytes),
      ack_timeout_(options.ack_timeout),
      acknowledges_(options.acknowledges),
      window_(options.window),
      max_rate_hz_(options.max_rate_hz) {}

FlowControl::Permit FlowControl::permit(Nanoseconds now) const {
  if (paused_) return {};
  if (!in_flight_.empty() && now >= ack_deadline()) return {false, true, std::nullopt};
  const std::optional<Nanoseconds> deadline =
      in_flight_.empty() ? std::nullopt : std::optional<Nanoseconds>(ack_deadline());
  if (!window_open(now)) {
    const bool opens_soon = now < new_place_from_ && window_open(new_place_from_);
    return {false, false, opens_soon ? std::min(deadline.value_or(new_place_from_), new_place_from_) : deadline};
  }
  if (now < next_allowed_) return {false, false, deadline ? std::min(*deadline, next_allowed_) : next_allowed_};
  return {true, false, deadline};
}

std::int64_t FlowControl::sent(std::size_t bytes, std::int64_t publications, Nanoseconds now) {
  ++last_sequence_;
  if (acknowledges_) {
    in_flight_.push_back({last_sequence_, bytes, now, in_flight_.empty()});
    bytes_in_flight_ += bytes;
  }
  note_interval(publications, now);
  if (max_rate_hz_ > 0.0) next_allowed_ = next_slot(now);
  return last_sequence_;
}

void FlowControl::note_interval(std::int64_t publications, Nanoseconds now) {
  if (last_sequence_ > 1 && publications > 0) {
    const double interval_s =
        std::chrono::duration<double>(now - last_sent_at_).count() / static_cast<double>(publications);
    constexpr double kSmoothing = 0.1;
    interval_s_ = interval_s_ == 0.0 ? interval_s : interval_s_ + kSmoothing * (interval_s - interval_s_);
  }
  last_sent_at_ = now;
}

Nanoseconds FlowControl::next_slot(Nanoseconds now) const {
  const auto interval = static_cast<std::int64_t>(1.0e9 / max_rate_hz_);
  return Nanoseconds((now.count() / interval + 1) * interval);
}

void FlowControl::set_frame_rate(double max_rate_hz, bool paused, Nanoseconds now) {
  const bool goes_on = paused_ && !paused;
  max_rate_hz_ = max_rate_hz;
  paused_ = paused;
  next_allowed_ = Nanoseconds::min();
  if (!goes_on) return;
  // Restarts the acknowledgement timeout of frames sent before the pause.
  for (InFlight& frame : in_flight_) frame.sent_at = now;
}

std::int32_t FlowControl::window_at(Nanoseconds now) const {
  return now < new_place_from_ ? std::max(window_.window() - 1, 1) : window_.window();
}

bool FlowControl::window_open(Nanoseconds now) const {
  return std::ssize(in_flight_) < window_at(now) &&
         (in_flight_.empty() || bytes_in_flight_ < max_unacknowledged_bytes_);
}

Nanoseconds FlowControl::ack_deadline() const {
  return in_flight_.front().sent_at + ack_timeout_;
}

std::optional<FlowControl::InFlight> FlowControl::settle(std::int64_t sequence) {
  std::optional<InFlight> last;
  while (!in_flight_.empty() && in_flight_.front().sequence <= sequence) {
    last = in_flight_.front();
    bytes_in_flight_ -= last->bytes;
    in_flight_.pop_front();
  }
  return last;
}

Result<bool> FlowControl::acknowledge(std::int64_t sequence, Nanoseconds now, Nanoseconds held) {
  if (sequence < 1 || sequence > last_sequence_) {
    return invalid_argument("ACK_OUT_OF_RANGE",
                            "frame " + std::to_string(sequence) + " was acknowledged, but the frames sent are 1 to " +
                                std::to_string(last_sequence_),
                            "ack.sequence");
  }
  if (held < Nanoseconds(0)) {
    return invalid_argument("ACK_OUT_OF_RANGE",
                            "ack.held_us is negative; give a time in microseconds, or 0 if it is unknown",
                            "ack.held_us");
  }
  const bool was_open = window_open(now);
  const std::optional<InFlight> last = settle(sequence);
  const Nanoseconds total = last ? now - last->sent_at : Nanoseconds(0);
  if (held > Nanoseconds(0) && total > Nanoseconds(0)) {
    const double slowest_s = max_rate_hz_ > 0.0 ? 1.0 / max_rate_hz_ : 0.0;
    const auto interval = std::chrono::duration<double>(std::max(slowest_s, interval_s_));
    const std::int32_t before = window_.window();
    window_.acknowledged(total, std::min(held, total), last->alone, std::chrono::duration_cast<Nanoseconds>(interval));
    if (window_.window() > before) new_place_from_ = now + window_.pause_before_new();
  }
  return !was_open && window_open(now);
}

}  // namespace kerf::stream
