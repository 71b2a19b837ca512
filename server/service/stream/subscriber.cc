#include "server/service/stream/subscriber.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

#include "server/service/stream/channel.h"

namespace kerf::stream {
namespace {

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

Subscriber::Subscriber(std::shared_ptr<Channel> channel, const SubscriberOptions& options, std::function<void()> ready)
    : channel_(std::move(channel)),
      options_(options),
      number_(next_number()),
      ready_(std::move(ready)),
      flow_(options.flow) {
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
  const FlowControl::Permit permit = flow_.permit(now);
  if (permit.too_slow) return end_now(wire::EndReason::kTooSlow);
  if (!permit.may_send) return {std::nullopt, permit.wake_at};
  // Set before the check: a publication from here on is either seen by the check or finds wants_frame_ set.
  wants_frame_ = true;
  wants_values_ = true;
  const std::int64_t newest = channel_->newest_publication();
  if (newest <= std::max(viewed_.publication, stale_through_)) return {std::nullopt, permit.wake_at};
  std::optional<Message> message = take(now);
  if (!message) return wait_for_values(newest, permit, now);
  wants_frame_ = false;
  wants_values_ = false;
  return {std::move(message), std::nullopt};
}

// A sheet at rest publishes nothing by itself, so its snapshot is asked for, once after each publication.
Subscriber::Next Subscriber::wait_for_values(std::int64_t newest, const FlowControl::Permit& permit, Nanoseconds now) {
  Next next{std::nullopt, permit.wake_at};
  const std::optional<Nanoseconds> from = channel_->next_values_at();
  if (!from) return next;
  if (now < *from) {
    next.wake_at = std::min(permit.wake_at.value_or(*from), *from);
  } else {
    next.wants_snapshot = std::exchange(asked_after_, newest) != newest;
  }
  return next;
}

std::optional<Message> Subscriber::take(Nanoseconds now) {
  const bool is_first = flow_.last_sequence() == 0;
  if (is_first) {
    viewed_.sheet_serial = channel_->serial_of(options_.epoch);
    if (viewed_.sheet_serial) viewed_.topology_version = options_.topology_version;
  }
  const auto reader = options_.meter ? std::optional(number_) : std::nullopt;
  std::optional<FramePick> picked = channel_->pick(viewed_, reader);
  if (!picked) return std::nullopt;
  FramePick& pick = *picked;
  const bool begins = is_first || pick.begins;
  const std::string epoch = begins ? channel_->epoch_of(*pick.viewed.sheet_serial) : std::string();
  const std::int64_t skipped = begins ? 0 : std::max<std::int64_t>(0, pick.tick - last_tick_ - 1);
  Message message;
  message.parts.push_back(std::move(pick.body));
  if (pick.topology) message.parts.push_back(std::move(pick.topology));
  if (pick.strains) message.parts.push_back(std::move(pick.strains));
  if (options_.meter) {
    const std::vector<std::string>* const columns = is_first ? &options_.meter->columns() : nullptr;
    message.parts.push_back(std::make_shared<const std::string>(wire::encode_probe_values(pick.values, columns)));
  }
  const std::size_t bytes = message.size();
  const std::int64_t sequence = flow_.sent(bytes, pick.viewed.publication - viewed_.publication, now);
  message.parts.insert(message.parts.begin(),
                       std::make_shared<const std::string>(wire::encode_frame_head(sequence, skipped, epoch, bytes)));
  last_tick_ = pick.tick;
  viewed_ = pick.viewed;
  return message;
}

bool Subscriber::set_frame_rate(double max_rate_hz, bool paused, Nanoseconds now) {
  bool goes_on = false;
  {
    const std::lock_guard lock(mutex_);
    flow_.set_frame_rate(max_rate_hz, paused, now);
    goes_on = paused_ && !paused;
    paused_ = paused;
    if (goes_on) stale_through_ = channel_->newest_publication();
    wants_values_ = goes_on;
  }
  channel_->want_snapshots(*this, !paused);
  ready_();
  return goes_on;
}

std::int32_t Subscriber::window() const {
  const std::lock_guard lock(mutex_);
  return flow_.window();
}

Subscriber::Next Subscriber::end_now(wire::EndReason reason) {
  ended_ = true;
  Message message;
  message.parts.push_back(std::make_shared<const std::string>(wire::encode_ended(reason)));
  message.says_too_slow = reason == wire::EndReason::kTooSlow;
  return {std::move(message), std::nullopt};
}

Status Subscriber::acknowledge(std::int64_t sequence, Nanoseconds now, Nanoseconds held) {
  {
    const std::lock_guard lock(mutex_);
    KERF_TRY_ASSIGN(const bool opened, flow_.acknowledge(sequence, now, held));
    if (!opened || ended_ || left_) return Nothing{};
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

void Subscriber::measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) {
  if (!options_.meter || !wants_values_ || left_) return;
  snapshot.measured.push_back({number_, options_.meter->measure(sheet, snapshot.stats.sheet_serial)});
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
