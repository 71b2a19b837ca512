#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "server/core/sheet/snapshot.h"

namespace kerf::host {

// Holds the sinks of one sheet in the order in which they came. For one thread at a time.
class SnapshotSinks {
 public:
  void add(std::shared_ptr<sheet::SnapshotSink> sink) { sinks_.push_back(std::move(sink)); }
  // Returns false if it was not added.
  bool remove(const std::shared_ptr<sheet::SnapshotSink>& sink);
  [[nodiscard]] bool is_empty() const { return sinks_.empty(); }
  [[nodiscard]] bool contains(const std::shared_ptr<sheet::SnapshotSink>& sink) const;
  // Returns the number of viewers that all sinks together feed.
  [[nodiscard]] std::int32_t num_viewers() const;

  [[nodiscard]] bool want_snapshot() const;
  // True if a sink that wants a snapshot wants its strains.
  [[nodiscard]] bool want_strains() const;
  // Has the sinks that want a snapshot measure the sheet that it shows.
  void measure(const sheet::Sheet& sheet, sheet::Snapshot& snapshot) const;
  // Passes a snapshot to the sinks that want one.
  void publish(const std::shared_ptr<const sheet::Snapshot>& snapshot) const;
  // Removes all sinks and returns them.
  std::vector<std::shared_ptr<sheet::SnapshotSink>> take() { return std::exchange(sinks_, {}); }

 private:
  std::vector<std::shared_ptr<sheet::SnapshotSink>> sinks_;
};

}  // namespace kerf::host
