#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "kerf/v1/cuts.pb.h"

namespace kerf::api {

// The applied cuts of every sheet since its last reset by number, and the last scheduled ones that were refused. Those
// undone are set aside until they are made again or a new cut is applied; those before a reset, for its undo. Bounded:
// of a sheet whose cuts take more than kMaxBytes the oldest are forgotten. Thread-safe.
class CutJournal {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20;     // serialised, a sheet
  static constexpr std::size_t kMaxPageBytes = std::size_t{2} << 20;  // serialised; gRPC clients take 4 MiB a message
  static constexpr std::size_t kMaxRefused = 64;                      // a sheet
  static constexpr std::size_t kMaxRefusedBytes = std::size_t{1} << 20;  // serialised, a sheet; one may be larger

  // `beginning`: see sheet::CommandReply.
  void add(const std::string& sheet, std::int64_t beginning, std::int64_t number, v1::Cut cut, v1::CutResult result);
  void undo(const std::string& sheet, const std::vector<std::int64_t>& numbers);
  // Of the sheet once cuts were made again.
  struct Redone {
    std::int64_t tick = 0;
    std::int32_t topology_version = 0;
    std::string state_hash;  // as in v1::CutResult
  };
  void redo(const std::string& sheet, const std::vector<std::int64_t>& numbers, const Redone& redone);
  // A reset has led to a new beginning; what was refused before is forgotten.
  void reset(const std::string& sheet, std::int64_t beginning);
  // A reset was undone, or done again: those cuts are there that were made since `beginning`.
  void go_to(const std::string& sheet, std::int64_t beginning);
  void refuse(const std::string& sheet, v1::ScheduledCuts cuts);
  void forget(const std::string& sheet);

  // At most `count` entries with a number above `after`, and of more than one at most kMaxPageBytes, oldest first;
  // `last`: the number of the last one; `more`: there are others behind it.
  struct Page {
    std::vector<v1::ListCutsResponse::Entry> entries;
    std::int64_t last = 0;
    bool more = false;
  };
  Page page(const std::string& sheet, std::int64_t after, std::size_t count) const;
  std::vector<v1::ScheduledCuts> refused(const std::string& sheet) const;

 private:
  struct Item {
    v1::ListCutsResponse::Entry entry;
    std::int64_t beginning = 0;
    bool undone = false;
  };
  struct Log {
    std::map<std::int64_t, Item> items;
    std::int64_t beginning = 0;
    std::size_t bytes = 0;
    std::deque<v1::ScheduledCuts> refused;
    std::size_t refused_bytes = 0;
  };

  // Forgets what only a redo could bring back, which a change has ruled out.
  static void drop_undone(Log& log);

  mutable std::mutex mutex_;
  std::map<std::string, Log> logs_;
};

}  // namespace kerf::api
