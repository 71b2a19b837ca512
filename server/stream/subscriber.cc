#include "server/stream/subscriber.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/stream/channel.h"

namespace kerf::stream {
namespace {

std::string text_of(wire::EndReason reason) {
  switch (reason) {
    case wire::EndReason::kSheetDeleted:
      return "the sheet was deleted";
    case wire::EndReason::kServerStopping:
      return "the server is stopping; connect again later";
    case wire::EndReason::kTooSlow:
      return "no frame was acknowledged for too long; acknowledge each, or watch again when there is time for it";
  }
  return {};
}

}  // namespace

Subscriber::Subscriber(std::shared_ptr<Channel> channel, const SubscriberOptions& options, std::function<void()> ready)
    : channel_(std::move(channel)),
      options_(options),
      ready_(std::move(ready)),
      window_(options.window),
      max_rate_hz_(options.max_rate_hz) {
  viewed_.encoding = options_.encoding;
  viewed_.strains = options_.strains;
}

Subscriber::~Subscriber() {
  leave();
}

Subscriber::Next Subscriber::next(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (ended_ || left_) return {};
  if (end_) return end_now(*end_);
  if (paused_) return {};
  if (!in_flight_.empty() && now >= ack_deadline()) return end_now(wire::EndReason::kTooSlow);
  const std::optional<Nanoseconds> deadline =
      in_flight_.empty() ? std::nullopt : std::optional<Nanoseconds>(ack_deadline());
  if (!window_open()) return {std::nullopt, deadline};
  if (now < next_allowed_) {
    const Nanoseconds wake_at = deadline ? std::min(*deadline, next_allowed_) : next_allowed_;
    return {std::nullopt, wake_at};
  }
  // Before looking: a publication from here on either is seen below or finds this set.
  wants_frame_ = true;
  if (channel_->newest_publication() == viewed_.publication) return {std::nullopt, deadline};
  wants_frame_ = false;
  return {take(now), std::nullopt};
}

Message Subscriber::take(Nanoseconds now) {
  const bool is_first = last_sequence_ == 0;
  const std::string epoch = is_first ? channel_->epoch() : std::string();
  if (is_first && !options_.epoch.empty() && options_.epoch == epoch) {
    viewed_.topology_version = options_.topology_version;
  }
  FramePick pick = channel_->pick(viewed_);
  const std::int64_t skipped = viewed_.publication == 0 ? 0 : std::max<std::int64_t>(0, pick.tick - last_tick_ - 1);
  ++last_sequence_;
  Message message;
  message.parts.push_back(std::move(pick.body));
  if (pick.topology) message.parts.push_back(std::move(pick.topology));
  if (pick.strains) message.parts.push_back(std::move(pick.strains));
  message.parts.insert(message.parts.begin(), std::make_shared<const std::string>(wire::encode_frame_head(
                                                  last_sequence_, skipped, epoch, message.size())));

  if (options_.acknowledges) {
    in_flight_.push_back({last_sequence_, message.size(), now, in_flight_.empty()});
    bytes_in_flight_ += message.size();
  }
  note_interval(pick.viewed.publication, now);
  last_tick_ = pick.tick;
  viewed_ = pick.viewed;
  if (max_rate_hz_ > 0.0) next_allowed_ = next_slot(now);
  return message;
}

void Subscriber::note_interval(std::int64_t publication, Nanoseconds now) {
  const std::int64_t publications = publication - viewed_.publication;
  if (viewed_.publication > 0 && publications > 0) {
    const double interval_s =
        std::chrono::duration<double>(now - last_taken_at_).count() / static_cast<double>(publications);
    constexpr double kSmoothing = 0.1;
    tick_interval_s_ =
        tick_interval_s_ == 0.0 ? interval_s : tick_interval_s_ + kSmoothing * (interval_s - tick_interval_s_);
  }
  last_taken_at_ = now;
}

Nanoseconds Subscriber::next_slot(Nanoseconds now) const {
  const auto interval = static_cast<std::int64_t>(1.0e9 / max_rate_hz_);
  return Nanoseconds((now.count() / interval + 1) * interval);
}

void Subscriber::set_pace(double max_rate_hz, bool paused, Nanoseconds now) {
  {
    const std::lock_guard lock(mutex_);
    max_rate_hz_ = max_rate_hz;
    paused_ = paused;
    next_allowed_ = Nanoseconds::min();
    // What is owed is owed from now, after a pause.
    for (InFlight& frame : in_flight_) frame.sent_at = now;
  }
  ready_();
}

std::int32_t Subscriber::window() const {
  const std::lock_guard lock(mutex_);
  return window_.window();
}

bool Subscriber::window_open() const {
  return std::ssize(in_flight_) < window_.window() &&
         (in_flight_.empty() || bytes_in_flight_ < options_.max_unacknowledged_bytes);
}

Nanoseconds Subscriber::ack_deadline() const {
  return in_flight_.front().sent_at + options_.ack_timeout;
}

Subscriber::Next Subscriber::end_now(wire::EndReason reason) {
  ended_ = true;
  Message message;
  message.parts.push_back(std::make_shared<const std::string>(wire::encode_ended(reason, text_of(reason))));
  return {std::move(message), std::nullopt};
}

std::optional<Subscriber::InFlight> Subscriber::settle(std::int64_t sequence) {
  std::optional<InFlight> last;
  while (!in_flight_.empty() && in_flight_.front().sequence <= sequence) {
    last = in_flight_.front();
    bytes_in_flight_ -= last->bytes;
    in_flight_.pop_front();
  }
  return last;
}

Status Subscriber::acknowledge(std::int64_t sequence, Nanoseconds now, Nanoseconds held) {
  {
    const std::lock_guard lock(mutex_);
    if (sequence < 1 || sequence > last_sequence_) {
      return invalid_argument("ACK_OUT_OF_RANGE",
                              "frame " + std::to_string(sequence) + " is acknowledged, but the frames sent are 1 to " +
                                  std::to_string(last_sequence_),
                              "ack.sequence");
    }
    if (held < Nanoseconds(0)) {
      return invalid_argument("ACK_OUT_OF_RANGE", "ack.held_us is below 0; it is a time, or 0 where it is not known",
                              "ack.held_us");
    }
    const bool was_open = window_open();
    const std::optional<InFlight> last = settle(sequence);
    const Nanoseconds total = last ? now - last->sent_at : Nanoseconds(0);
    if (held > Nanoseconds(0) && total > Nanoseconds(0)) {
      const double slowest_s = max_rate_hz_ > 0.0 ? 1.0 / max_rate_hz_ : 0.0;
      const auto interval = std::chrono::duration<double>(std::max(slowest_s, tick_interval_s_));
      window_.acknowledged(total, std::min(held, total), last->alone,
                           std::chrono::duration_cast<Nanoseconds>(interval));
    }
    if (was_open || !window_open() || ended_ || left_) return Nothing{};
  }
  ready_();
  return Nothing{};
}

bool Subscriber::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

void Subscriber::leave() {
  if (!left_.exchange(true)) channel_->leave(*this);
}

void Subscriber::wake() {
  if (wants_frame_.exchange(false) && !left_) ready_();
}

void Subscriber::end(wire::EndReason reason) {
  {
    const std::lock_guard lock(mutex_);
    if (end_ || ended_ || left_) return;
    end_ = reason;
  }
  ready_();
}

}  // namespace kerf::stream
