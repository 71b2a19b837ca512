#include "client/load/cut_tracker.h"

#include <algorithm>

namespace kerf::load {

void CutTracker::watch(std::size_t sheet) {
  const std::lock_guard lock(mutex_);
  sheets_[sheet];
}

void CutTracker::unwatch(std::size_t sheet) {
  const std::lock_guard lock(mutex_);
  sheets_.erase(sheet);
}

void CutTracker::frame(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds decoded) {
  const std::lock_guard lock(mutex_);
  const auto found = sheets_.find(sheet);
  if (found == sheets_.end()) return;
  Sheet& watched = found->second;
  const Frame frame{tick, topology_version, decoded};
  watched.frames.push_back(frame);
  if (watched.frames.size() > kFrames) watched.frames.pop_front();
  std::erase_if(watched.waiting, [&](const Cut& cut) {
    if (cut.tick > tick) return false;
    seen(cut, frame);
    return true;
  });
}

std::optional<std::int64_t> CutTracker::newest_tick(std::size_t sheet) const {
  const std::lock_guard lock(mutex_);
  const auto found = sheets_.find(sheet);
  if (found == sheets_.end() || found->second.frames.empty()) return std::nullopt;
  return found->second.frames.back().tick;
}

void CutTracker::applied(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds intended) {
  const std::lock_guard lock(mutex_);
  const auto watched = sheets_.find(sheet);
  if (watched == sheets_.end()) return;
  const Cut cut{tick, topology_version, intended};
  const std::deque<Frame>& frames = watched->second.frames;
  const auto first =
      std::find_if(frames.begin(), frames.end(), [&](const Frame& frame) { return frame.tick >= cut.tick; });
  if (first == frames.end()) {
    watched->second.waiting.push_back(cut);
  } else {
    seen(cut, *first);
  }
}

void CutTracker::seen(const Cut& cut, const Frame& frame) {
  recorder_.cuts([&](CutTotals& totals) {
    totals.seen_us.add(microseconds(frame.decoded - cut.intended));
    if (frame.topology_version < cut.topology_version) ++totals.seen_without;
  });
}

std::int64_t CutTracker::num_waiting() const {
  const std::lock_guard lock(mutex_);
  std::int64_t waiting = 0;
  for (const auto& [index, sheet] : sheets_) waiting += static_cast<std::int64_t>(sheet.waiting.size());
  return waiting;
}

void CutTracker::finish() {
  const std::int64_t unseen = num_waiting();
  const std::lock_guard lock(mutex_);
  for (auto& [index, sheet] : sheets_) sheet.waiting.clear();
  recorder_.cuts([&](CutTotals& totals) { totals.unseen += unseen; });
}

}  // namespace kerf::load
