#include "server/service/stream/channel.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/base/check.h"

namespace kerf::stream {
namespace {

// Compares positions last: they can differ within one tick only while a sheet is paused or asleep.
bool looks_the_same(const sheet::Snapshot& a, const sheet::Snapshot& b) {
  return a.tick == b.tick && a.topology == b.topology && a.positions == b.positions;
}

wire::EndReason end_reason(sheet::SinkEnd end) {
  switch (end) {
    case sheet::SinkEnd::kSheetDeleted:
      return wire::EndReason::kSheetDeleted;
    case sheet::SinkEnd::kSheetLost:
      return wire::EndReason::kSheetLost;
    case sheet::SinkEnd::kHostStopping:
      return wire::EndReason::kServerStopping;
  }
  check_failed("end", __FILE__, __LINE__, "unknown end of a sink");
}

}  // namespace

Result<std::shared_ptr<Subscriber>> Channel::subscribe(const SubscriberOptions& options, std::function<void()> ready) {
  auto subscriber = std::make_shared<Subscriber>(shared_from_this(), options, std::move(ready));
  KERF_TRY(admit(subscriber, options.strains));
  return subscriber;
}

Status Channel::admit(const std::shared_ptr<Reader>& reader, bool wants_strains) {
  const std::lock_guard lock(mutex_);
  if (end_) return unavailable("CHANNEL_ENDED", "the sheet is gone or the server is stopping");
  if (num_subscribers_ >= max_subscribers_) {
    return resource_exhausted("TOO_MANY_SUBSCRIBERS",
                              "this sheet has " + std::to_string(max_subscribers_) + " viewers, which is its limit");
  }
  auto readers = std::make_shared<Readers>(*readers_);
  readers->push_back({reader.get(), reader, true, wants_strains});
  replace_readers(std::move(readers));
  return Nothing{};
}

void Channel::want_snapshots(const Reader& reader, bool wants) {
  change(reader, [wants](Entry& entry) { entry.wants_snapshots = wants; });
}

void Channel::want_strains(const Reader& reader, bool wants) {
  change(reader, [wants](Entry& entry) { entry.wants_strains = wants; });
}

void Channel::change(const Reader& reader, const std::function<void(Entry&)>& change) {
  const std::lock_guard lock(mutex_);
  auto readers = std::make_shared<Readers>(*readers_);
  for (Entry& each : *readers) {
    if (each.reader == &reader) change(each);
  }
  replace_readers(std::move(readers));
}

void Channel::leave(const Reader& reader) {
  const std::lock_guard lock(mutex_);
  auto remaining = std::make_shared<Readers>(*readers_);
  std::erase_if(*remaining, [&](const Entry& each) { return each.reader == &reader; });
  replace_readers(std::move(remaining));
}

void Channel::replace_readers(std::shared_ptr<const Readers> readers) {
  readers_ = std::move(readers);
  const auto count = [this](const auto& wants) {
    return static_cast<std::int32_t>(std::count_if(readers_->begin(), readers_->end(), wants));
  };
  num_subscribers_ = static_cast<std::int32_t>(readers_->size());
  num_wanting_snapshots_ = count([](const Entry& each) { return each.wants_snapshots; });
  num_wanting_strains_ = count([](const Entry& each) { return each.wants_snapshots && each.wants_strains; });
}

void Channel::measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) {
  std::shared_ptr<const Readers> readers;
  {
    const std::lock_guard lock(mutex_);
    readers = readers_;
  }
  if (!measuring_.begin()) return;
  const std::size_t before = snapshot.measured.size();
  const std::size_t first = first_measured_;
  for (std::size_t i = 0; i < readers->size(); ++i) {
    const std::size_t at = (first + i) % readers->size();
    if (snapshot.measured.size() > before && !measuring_.may_continue()) {
      first_measured_ = at;
      break;
    }
    if (const auto reader = (*readers)[at].handle.lock()) reader->measure(sheet, snapshot);
  }
  if (snapshot.measured.size() > before) measuring_.end();
}

void Channel::publish(std::shared_ptr<const sheet::Snapshot> snapshot) {
  std::shared_ptr<const Readers> readers;
  {
    const std::lock_guard lock(mutex_);
    if (!newest_ || !looks_the_same(*newest_, *snapshot)) ++revision_;
    newest_ = std::move(snapshot);
    ++newest_publication_;
    readers = readers_;
  }
  for (const Entry& each : *readers) {
    if (const auto reader = each.handle.lock()) reader->wake();
  }
}

void Channel::ended(sheet::SinkEnd reason) {
  std::shared_ptr<const Readers> readers;
  {
    const std::lock_guard lock(mutex_);
    if (end_) return;
    end_ = reason;
    readers = readers_;
  }
  const auto why = end_reason(reason);
  for (const Entry& each : *readers) {
    if (const auto reader = each.handle.lock()) reader->end(why);
  }
}

Channel::Newest Channel::newest() const {
  const std::lock_guard lock(mutex_);
  return {newest_publication_, revision_, newest_};
}

bool Channel::has_ended() const {
  const std::lock_guard lock(mutex_);
  return end_.has_value();
}

EncodeCounters Channel::counters() const {
  const std::lock_guard lock(frames_mutex_);
  return history_.counters();
}

std::string Channel::epoch_of(std::uint64_t sheet_serial) const {
  return instance_ + '-' + std::to_string(sheet_serial);
}

std::optional<std::uint64_t> Channel::serial_of(const std::string& epoch) const {
  const std::lock_guard lock(mutex_);
  KERF_CHECK(newest_ != nullptr, "an epoch is asked for before the first snapshot");
  const std::uint64_t serial = newest_->stats.sheet_serial;
  if (epoch != epoch_of(serial)) return std::nullopt;
  return serial;
}

std::optional<FramePick> Channel::pick(const Viewed& viewed, std::optional<std::uint64_t> reader) {
  const std::lock_guard frames_lock(frames_mutex_);
  std::shared_ptr<const sheet::Snapshot> newest;
  std::int64_t publication = 0;
  {
    // Read while frames_mutex_ is held, so that the history receives publications in order.
    const std::lock_guard lock(mutex_);
    newest = newest_;
    publication = newest_publication_;
  }
  KERF_CHECK(newest != nullptr, "a frame is taken before the first snapshot");
  std::vector<double> values;
  if (reader) {
    const auto found = std::find_if(newest->measured.begin(), newest->measured.end(),
                                    [&](const sheet::Measured& each) { return each.reader == *reader; });
    if (found == newest->measured.end()) return std::nullopt;
    values = found->values;
  }
  const std::int64_t encoded_before = history_.counters().bodies();
  FramePick pick = history_.pick(publication, *newest, viewed);
  pick.values = std::move(values);
  if (shared_counters_) {
    shared_counters_->encoded += history_.counters().bodies() - encoded_before;
    ++shared_counters_->sent;
  }
  return pick;
}

std::optional<Nanoseconds> Channel::next_values_at() const {
  {
    const std::lock_guard lock(mutex_);
    const sheet::RunStats& stats = newest_->stats;
    if (!stats.paused && !stats.sleeping && !stats.failed) return std::nullopt;
  }
  return measuring_.rests_until();
}

}  // namespace kerf::stream
