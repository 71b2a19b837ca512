#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/v1/cuts.pb.h"

namespace kerf::api {

// Lists, for every sheet, the cuts applied since its last reset, by number, and the latest scheduled cuts that were
// refused. Undone cuts are hidden until they are redone; they are dropped when a new cut is applied. Cuts made before a
// reset are hidden, and listed again if the reset is undone. The oldest cuts of a sheet are forgotten beyond kMaxBytes.
// Thread-safe.
class CutJournal {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20;  // Limit on serialised cuts, per sheet.
  // Limit on the serialised entries of a page, because gRPC clients take 4 MiB per message.
  static constexpr std::size_t kMaxPageBytes = std::size_t{2} << 20;
  static constexpr std::size_t kMaxRefused = 64;  // Per sheet.
  // Limit on serialised refused cuts, per sheet. The latest one is kept even if it is larger.
  static constexpr std::size_t kMaxRefusedBytes = std::size_t{1} << 20;

  // Adds an applied cut. `beginning`: number of the scene's run in which it was made, see scene::CommandReply.
  void add(const std::string& sheet, std::int64_t beginning, std::int64_t number, v1::Cut cut, v1::CutResult result);
  void undo(const std::string& sheet, const std::vector<std::int64_t>& numbers);
  // Describes the sheet after a redo.
  struct Redone {
    std::int64_t tick = 0;
    std::int32_t topology_version = 0;
    std::string state_hash;  // As in v1::CutResult.
  };
  void redo(const std::string& sheet, const std::vector<std::int64_t>& numbers, const Redone& redone);
  // Records a reset, which begins a new list; forgets earlier refusals.
  void reset(const std::string& sheet, std::int64_t beginning);
  // Records that a reset was undone or redone: the cuts made since `beginning` are current again.
  void go_to(const std::string& sheet, std::int64_t beginning);
  // Lists scheduled cuts that were refused.
  void refuse(const std::string& sheet, v1::ScheduledCuts cuts);
  // Returns all that is known of a sheet, for restore() of a journal of the same build; empty if nothing is.
  std::string save(const std::string& sheet) const;
  // Replaces all that is known of a sheet by what save() returned.
  void restore(const std::string& sheet, std::string_view saved);
  // Forgets all of a sheet that is being deleted.
  void forget(const std::string& sheet);

  // Holds at most `count` entries with numbers above `after`, oldest first. If there are several, they take at most
  // kMaxPageBytes together. `last`: number of the last entry here; `more`: the sheet has further entries.
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

  // Reads or writes a log, see server/base/fields.h.
  template <class Visitor, class AnyLog>
  static void visit_log(Visitor& visitor, AnyLog& log);
  // Forgets undone cuts that no redo can bring back any more.
  static void drop_undone(Log& log);

  mutable std::mutex mutex_;
  std::map<std::string, Log> logs_;
};

}  // namespace kerf::api
