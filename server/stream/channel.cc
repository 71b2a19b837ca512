#include "server/stream/channel.h"

#include <string>
#include <utility>

#include "server/base/check.h"

namespace kerf::stream {

Result<std::shared_ptr<Subscriber>> Channel::subscribe(const SubscriberOptions& options, std::function<void()> ready) {
  const std::lock_guard lock(mutex_);
  if (end_) return Error{ErrorCode::kUnavailable, "CHANNEL_ENDED", "the sheet is gone or the server is stopping", {}};
  if (num_subscribers_ >= max_subscribers_) {
    return Error{ErrorCode::kResourceExhausted,
                 "TOO_MANY_SUBSCRIBERS",
                 "this sheet has " + std::to_string(max_subscribers_) + " viewers, as many as it may have",
                 {}};
  }
  auto subscriber = std::make_shared<Subscriber>(shared_from_this(), options, std::move(ready));
  auto subscribers = std::make_shared<Subscribers>(subscribers_ ? *subscribers_ : Subscribers{});
  subscribers->push_back({subscriber.get(), subscriber});
  subscribers_ = std::move(subscribers);
  ++num_subscribers_;
  if (options.strains) ++num_wanting_strains_;
  return subscriber;
}

void Channel::publish(std::shared_ptr<const sheet::Snapshot> snapshot) {
  {
    const std::lock_guard lock(mutex_);
    newest_ = std::move(snapshot);
    ++newest_publication_;
  }
  wake_all();
}

void Channel::wake_all() {
  std::shared_ptr<const Subscribers> subscribers;
  {
    const std::lock_guard lock(mutex_);
    subscribers = subscribers_;
  }
  if (!subscribers) return;
  for (const Entry& each : *subscribers) {
    if (const auto subscriber = each.handle.lock()) subscriber->wake();
  }
}

void Channel::ended(sheet::SinkEnd reason) {
  std::shared_ptr<const Subscribers> subscribers;
  {
    const std::lock_guard lock(mutex_);
    if (end_) return;
    end_ = reason;
    subscribers = subscribers_;
  }
  if (!subscribers) return;
  const auto why =
      reason == sheet::SinkEnd::kSheetDeleted ? wire::EndReason::kSheetDeleted : wire::EndReason::kServerStopping;
  for (const Entry& each : *subscribers) {
    if (const auto subscriber = each.handle.lock()) subscriber->end(why);
  }
}

bool Channel::has_ended() const {
  const std::lock_guard lock(mutex_);
  return end_.has_value();
}

EncodeCounters Channel::counters() const {
  const std::lock_guard lock(frames_mutex_);
  return history_.counters();
}

std::string Channel::epoch() const {
  const std::lock_guard lock(mutex_);
  KERF_CHECK(newest_ != nullptr, "an epoch is asked for before the first snapshot");
  return instance_ + '-' + std::to_string(newest_->stats.sheet_serial);
}

FramePick Channel::pick(const Viewed& viewed) {
  const std::lock_guard frames_lock(frames_mutex_);
  std::shared_ptr<const sheet::Snapshot> newest;
  std::int64_t publication = 0;
  {
    // Inside the other lock, so that publications come to the history in their order.
    const std::lock_guard lock(mutex_);
    newest = newest_;
    publication = newest_publication_;
  }
  KERF_CHECK(newest != nullptr, "a frame is taken before the first snapshot");
  return history_.pick(publication, *newest, viewed);
}

void Channel::leave(const Subscriber& subscriber) {
  const std::lock_guard lock(mutex_);
  auto remaining = std::make_shared<Subscribers>(*subscribers_);
  std::erase_if(*remaining, [&](const Entry& each) { return each.subscriber == &subscriber; });
  subscribers_ = std::move(remaining);
  --num_subscribers_;
  if (subscriber.wants_strains()) --num_wanting_strains_;
}

}  // namespace kerf::stream
