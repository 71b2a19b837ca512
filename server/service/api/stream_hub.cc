#include "server/service/api/stream_hub.h"

#include <utility>

namespace kerf::api {

void StreamHub::join(const std::string& sheet_id, const Subscribe& subscribe, Joined joined) {
  std::shared_ptr<stream::Channel> fresh;
  std::shared_ptr<stream::Channel> poorer;  // A channel whose newest snapshot lacks the strains wanted now.
  Result<std::shared_ptr<stream::Reader>> reader =
      unavailable("SERVER_STOPPING", "the server is stopping; try again later");
  {
    const std::lock_guard lock(mutex_);
    if (!stopped_) {
      Entry& entry = entries_[sheet_id];
      // Replaces an ended channel, which belonged to a deleted sheet of this name.
      if (!entry.channel || entry.channel->has_ended()) {
        fresh = std::make_shared<stream::Channel>(max_subscribers_, instance_, counters_,
                                                  [&clock = clock_] { return clock.now(); });
        entry = {fresh, false, {}};
      }
      const bool had_strains = entry.channel->wants_strains();
      reader = subscribe(entry.channel);
      if (reader.ok() && !entry.attached) {
        entry.waiting.push_back({*reader, std::move(joined)});
        joined = nullptr;  // Answered once the channel is attached.
      } else if (reader.ok() && !had_strains && entry.channel->wants_strains()) {
        poorer = entry.channel;
      }
    }
  }
  if (joined) joined(std::move(reader));
  if (fresh) attach(sheet_id, fresh);
  if (poorer) refresh(sheet_id, poorer);
}

void StreamHub::refresh(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel) {
  host_.refresh_sink(sheet_id, channel, [](const Status&) {});
}

// Captures `this`: the hub outlives the host's callbacks only with the core that owns it. Streams keep the core alive,
// and every Joined holds its stream.
void StreamHub::attach(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel) {
  host_.add_sink(sheet_id, channel,
                 [this, sheet_id, channel](const Status& status) { attached(sheet_id, channel, status); });
}

void StreamHub::attached(const std::string& sheet_id, const std::shared_ptr<stream::Channel>& channel,
                         const Status& status) {
  std::vector<Waiting> waiting;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(sheet_id);
    if (entry == entries_.end() || entry->second.channel != channel) return;
    waiting.swap(entry->second.waiting);
    entry->second.attached = status.ok();
    if (!status.ok()) entries_.erase(entry);
  }
  for (Waiting& each : waiting) {
    if (status.ok()) {
      each.joined(std::move(each.reader));
    } else {
      each.reader->leave();
      each.joined(status.error());
    }
  }
}

void StreamHub::leave(const std::string& sheet_id, stream::Reader& reader) {
  reader.leave();
  std::shared_ptr<stream::Channel> unused;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(sheet_id);
    if (entry == entries_.end() || entry->second.channel->num_subscribers() > 0) return;
    unused = std::move(entry->second.channel);
    entries_.erase(entry);
  }
  host_.remove_sink(sheet_id, unused, [](const Status&) {});
}

void StreamHub::stop() {
  std::vector<std::shared_ptr<stream::Channel>> channels;
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    for (const auto& [sheet_id, entry] : entries_) channels.push_back(entry.channel);
  }
  for (const auto& channel : channels) channel->ended(sheet::SinkEnd::kHostStopping);
}

}  // namespace kerf::api
