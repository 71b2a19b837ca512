#include "server/base/check.h"
#include "server/base/fields.h"
#include "server/service/api/cut_journal.h"

// Writes the log of a sheet as bytes and reads it.
namespace kerf::api {

namespace {

// Visits a message as its serialised bytes.
template <class Visitor, class Message>
void visit_message(Visitor& visitor, Message& message) {
  std::string bytes;
  if constexpr (!Visitor::kReads) bytes = message.SerializeAsString();
  visit(visitor, bytes);
  if constexpr (Visitor::kReads) message.ParseFromString(bytes);
}

}  // namespace

template <class Visitor, class AnyLog>
void CutJournal::visit_log(Visitor& visitor, AnyLog& log) {
  visit(visitor, log.beginning);
  std::size_t num_items = visitor.count(log.items.size(), 1);
  const auto visit_item = [&](auto& number, auto& item) {
    visit(visitor, number);
    visit(visitor, item.beginning);
    visit(visitor, item.undone);
    visit_message(visitor, item.entry);
  };
  std::size_t num_refused = 0;
  if constexpr (Visitor::kReads) {
    for (; num_items > 0 && !visitor.failed(); --num_items) {
      std::int64_t number = 0;
      Item item;
      visit_item(number, item);
      log.bytes += item.entry.ByteSizeLong();
      log.items.emplace(number, std::move(item));
    }
    num_refused = visitor.count(0, 1);
    for (; num_refused > 0 && !visitor.failed(); --num_refused) {
      visit_message(visitor, log.refused.emplace_back());
      log.refused_bytes += log.refused.back().ByteSizeLong();
    }
  } else {
    for (const auto& [number, item] : log.items) visit_item(number, item);
    visitor.count(log.refused.size(), 1);
    for (const v1::ScheduledCuts& refused : log.refused) visit_message(visitor, refused);
  }
}

std::string CutJournal::save(const std::string& sheet) const {
  const std::lock_guard lock(mutex_);
  const auto log = logs_.find(sheet);
  if (log == logs_.end()) return {};
  FieldWriter writer;
  visit_log(writer, log->second);
  return writer.bytes();
}

void CutJournal::restore(const std::string& sheet, std::string_view saved) {
  if (saved.empty()) return forget(sheet);
  Log log;
  FieldReader reader(saved);
  visit_log(reader, log);
  KERF_CHECK(reader.is_done(), "a log of cuts is read that save() did not write");
  const std::lock_guard lock(mutex_);
  logs_[sheet] = std::move(log);
}

}  // namespace kerf::api
