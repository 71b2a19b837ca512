#include "server/service/host/sheet_journal.h"

#include <algorithm>
#include <utility>

namespace kerf::host {

SheetJournal::SheetJournal(Journal& journal, std::int64_t sheet, std::int64_t last_seq, Encode encode,
                           std::function<void(std::int64_t)> durable)
    : journal_(&journal),
      sheet_(sheet),
      encode_(std::move(encode)),
      report_(std::move(durable)),
      last_(last_seq),
      last_edit_(std::max<std::int64_t>(last_seq, 0)),
      durable_(last_seq) {}

Journal::Durable SheetJournal::report(std::int64_t seq) const {
  return [report = report_, seq] { report(seq); };
}

void SheetJournal::create(NewStoredSheet sheet) {
  sheet.sheet = sheet_;
  last_edit_ = ++last_;
  journal_->create(std::move(sheet), report(last_));
}

void SheetJournal::write(const SheetEvent& event, std::int64_t tick, std::uint64_t state_hash,
                         std::vector<StoredRequest> requests) {
  if (!is_on()) return;
  JournalEntry entry{sheet_, last_ + 1, tick, state_hash, encode_(event), std::move(requests)};
  ++last_;
  if (is_edit(event)) last_edit_ = last_;
  journal_->append(std::move(entry), report(last_));
}

void SheetJournal::remove() {
  if (!is_on()) return;
  last_edit_ = ++last_;
  journal_->remove(sheet_, {}, report(last_));
}

void SheetJournal::when_durable(Release release) {
  if (durable_ >= last_ && waiting_.empty()) return release(Nothing{});
  waiting_.push_back({last_, std::move(release)});
}

void SheetJournal::became_durable(std::int64_t seq) {
  durable_ = seq;
  while (!waiting_.empty() && waiting_.front().seq <= durable_) {
    const Release release = std::move(waiting_.front().release);
    waiting_.pop_front();
    release(Nothing{});
  }
}

void SheetJournal::give_up(const Error& error) {
  std::deque<Waiting> waiting;
  waiting.swap(waiting_);
  for (Waiting& each : waiting) each.release(error);
}

Status SheetJournal::check_room() const {
  return is_on() ? journal_->check_room(sheet_) : Status(Nothing{});
}

}  // namespace kerf::host
