#include "server/service/host/snapshot_sinks.h"

#include <algorithm>

namespace kerf::host {

bool SnapshotSinks::remove(const std::shared_ptr<sheet::SnapshotSink>& sink) {
  const auto found = std::find(sinks_.begin(), sinks_.end(), sink);
  if (found == sinks_.end()) return false;
  sinks_.erase(found);
  return true;
}

bool SnapshotSinks::contains(const std::shared_ptr<sheet::SnapshotSink>& sink) const {
  return std::find(sinks_.begin(), sinks_.end(), sink) != sinks_.end();
}

std::int32_t SnapshotSinks::num_viewers() const {
  std::int32_t count = 0;
  for (const auto& sink : sinks_) count += sink->num_viewers();
  return count;
}

bool SnapshotSinks::want_snapshot() const {
  return std::any_of(sinks_.begin(), sinks_.end(), [](const auto& sink) { return sink->wants_snapshot(); });
}

bool SnapshotSinks::want_strains() const {
  return std::any_of(sinks_.begin(), sinks_.end(),
                     [](const auto& sink) { return sink->wants_snapshot() && sink->wants_strains(); });
}

void SnapshotSinks::measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) const {
  for (const auto& sink : sinks_) {
    if (sink->wants_snapshot()) sink->measure(sheet, snapshot);
  }
}

void SnapshotSinks::publish(const std::shared_ptr<const sheet::Snapshot>& snapshot) const {
  for (const auto& sink : sinks_) {
    if (sink->wants_snapshot()) sink->publish(snapshot);
  }
}

}  // namespace kerf::host
