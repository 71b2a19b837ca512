#include "server/api/cut_journal.h"

#include <utility>

namespace kerf::api {

void CutJournal::add(const std::string& sheet, v1::Cut cut, v1::CutResult result) {
  v1::ListCutsResponse::Entry entry;
  *entry.mutable_cut() = std::move(cut);
  *entry.mutable_result() = std::move(result);
  const std::lock_guard lock(mutex_);
  Log& log = logs_[sheet];
  log.bytes += entry.ByteSizeLong();
  const std::int32_t version = entry.result().topology_version();
  log.entries.emplace(version, std::move(entry));
  while (log.bytes > kMaxBytes && log.entries.size() > 1) {
    log.bytes -= log.entries.begin()->second.ByteSizeLong();
    log.entries.erase(log.entries.begin());
  }
}

void CutJournal::forget(const std::string& sheet) {
  const std::lock_guard lock(mutex_);
  logs_.erase(sheet);
}

CutJournal::Page CutJournal::page(const std::string& sheet, std::int32_t after, std::size_t count) const {
  Page page;
  const std::lock_guard lock(mutex_);
  const auto log = logs_.find(sheet);
  if (log == logs_.end()) return page;
  std::size_t bytes = 0;
  for (auto entry = log->second.entries.upper_bound(after); entry != log->second.entries.end(); ++entry) {
    bytes += entry->second.ByteSizeLong();
    if (page.entries.size() == count || (!page.entries.empty() && bytes > kMaxPageBytes)) {
      page.more = true;
      break;
    }
    page.entries.push_back(entry->second);
  }
  return page;
}

}  // namespace kerf::api
