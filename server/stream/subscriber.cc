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
    : channel_(std::move(channel)), options_(options), ready_(std::move(ready)) {
  viewed_.encoding = options_.encoding;
}

Subscriber::~Subscriber() {
  leave();
}

Subscriber::Next Subscriber::next(Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  if (ended_ || left_) return {};
  if (end_) return end_now(*end_);
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
  FramePick pick = channel_->pick(viewed_);
  const std::int64_t skipped = viewed_.publication == 0 ? 0 : std::max<std::int64_t>(0, pick.tick - last_tick_ - 1);
  const std::size_t rest = pick.body->size() + (pick.topology ? pick.topology->size() : 0);
  ++last_sequence_;
  Message message;
  message.parts.push_back(std::make_shared<const std::string>(wire::encode_frame_head(last_sequence_, skipped, rest)));
  message.parts.push_back(std::move(pick.body));
  if (pick.topology) message.parts.push_back(std::move(pick.topology));

  in_flight_.push_back({last_sequence_, message.size(), now});
  bytes_in_flight_ += message.size();
  last_tick_ = pick.tick;
  viewed_ = pick.viewed;
  if (options_.max_rate_hz > 0.0) {
    const Nanoseconds interval(static_cast<std::int64_t>(1.0e9 / options_.max_rate_hz));
    // In step with the rate while frames keep coming, from now on after a pause.
    next_allowed_ = (next_allowed_ < now - interval ? now : next_allowed_) + interval;
  }
  return message;
}

bool Subscriber::window_open() const {
  return std::ssize(in_flight_) < options_.window &&
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

Status Subscriber::acknowledge(std::int64_t sequence) {
  {
    const std::lock_guard lock(mutex_);
    if (sequence < 1 || sequence > last_sequence_) {
      return invalid_argument("ACK_OUT_OF_RANGE",
                              "frame " + std::to_string(sequence) + " is acknowledged, but the frames sent are 1 to " +
                                  std::to_string(last_sequence_),
                              "ack.sequence");
    }
    const bool was_open = window_open();
    while (!in_flight_.empty() && in_flight_.front().sequence <= sequence) {
      bytes_in_flight_ -= in_flight_.front().bytes;
      in_flight_.pop_front();
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
