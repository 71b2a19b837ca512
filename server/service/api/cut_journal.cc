#include "server/service/api/cut_journal.h"

#include <utility>

namespace kerf::api {

void CutJournal::drop_undone(Log& log) {
  std::erase_if(log.items, [&log](const auto& each) {
    const bool drops = each.second.undone || each.second.beginning > log.beginning;
    if (drops) log.bytes -= each.second.entry.ByteSizeLong();
    return drops;
  });
}

void CutJournal::add(const std::string& sheet, std::int64_t beginning, std::int64_t number, v1::Cut cut,
                     v1::CutResult result) {
  Item item;
  item.beginning = beginning;
  *item.entry.mutable_cut() = std::move(cut);
  *item.entry.mutable_result() = std::move(result);
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  drop_undone(log);
  log.beginning = beginning;
  log.bytes += item.entry.ByteSizeLong();
  log.items.emplace(number, std::move(item));
  while (log.bytes > kMaxBytes && log.items.size() > 1) {
    log.bytes -= log.items.begin()->second.entry.ByteSizeLong();
    log.items.erase(log.items.begin());
  }
}

void CutJournal::undo(const std::string& sheet, const std::vector<std::int64_t>& numbers) {
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  for (const std::int64_t number : numbers) {
    const auto item = log.items.find(number);
    if (item != log.items.end()) item->second.undone = true;
  }
}

void CutJournal::redo(const std::string& sheet, const std::vector<std::int64_t>& numbers, const Redone& redone) {
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  for (const std::int64_t number : numbers) {
    const auto item = log.items.find(number);
    if (item == log.items.end()) continue;
    item->second.undone = false;
    v1::CutResult& known = *item->second.entry.mutable_result();
    log.bytes -= item->second.entry.ByteSizeLong();
    known.set_tick(redone.tick);
    known.set_topology_version(redone.topology_version);
    known.set_state_hash(redone.state_hash);
    log.bytes += item->second.entry.ByteSizeLong();
  }
}

void CutJournal::reset(const std::string& sheet, std::int64_t beginning) {
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  log.refused.clear();
  log.refused_bytes = 0;
  if (log.beginning == beginning) return;  // A scheduled cut of the same tick came first.
  drop_undone(log);
  log.beginning = beginning;
}

void CutJournal::go_to(const std::string& sheet, std::int64_t beginning) {
  const std::lock_guard lock(mutex_);
  logs_[sheet].beginning = beginning;
}

void CutJournal::refuse(const std::string& sheet, v1::ScheduledCuts cuts) {
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  log.refused_bytes += cuts.ByteSizeLong();
  log.refused.push_back(std::move(cuts));
  while (log.refused.size() > kMaxRefused || (log.refused_bytes > kMaxRefusedBytes && log.refused.size() > 1)) {
    log.refused_bytes -= log.refused.front().ByteSizeLong();
    log.refused.pop_front();
  }
}

void CutJournal::forget(const std::string& sheet) {
  const std::lock_guard lock(mutex_);
  logs_.erase(sheet);
}

CutJournal::Page CutJournal::page(const std::string& sheet, std::int64_t after, std::size_t count) const {
  Page page;
  const std::lock_guard lock(mutex_);
  const auto log = logs_.find(sheet);
  if (log == logs_.end()) return page;
  std::size_t bytes = 0;
  for (auto item = log->second.items.upper_bound(after); item != log->second.items.end(); ++item) {
    if (item->second.undone || item->second.beginning != log->second.beginning) continue;
    bytes += item->second.entry.ByteSizeLong();
    if (page.entries.size() == count || (!page.entries.empty() && bytes > kMaxPageBytes)) {
      page.more = true;
      break;
    }
    page.entries.push_back(item->second.entry);
    page.last = item->first;
  }
  return page;
}

std::vector<v1::ScheduledCuts> CutJournal::refused(const std::string& sheet) const {
  const std::lock_guard lock(mutex_);
  const auto log = logs_.find(sheet);
  if (log == logs_.end()) return {};
  return {log->second.refused.begin(), log->second.refused.end()};
}

}  // namespace kerf::api
