#include "server/service/host/sheet_journal.h"

#include <algorithm>
#include <utility>

namespace kerf::host {

SheetJournal::SheetJournal(Journal& journal, std::int64_t sheet, std::int64_t last_seq, Encode encode, Report durable)
    : journal_(&journal),
      sheet_(sheet),
      encode_(std::move(encode)),
      report_(std::move(durable)),
      last_(last_seq),
      last_edit_(std::max<std::int64_t>(last_seq, 0)),
      durable_(last_seq),
      written_(last_seq) {}

Journal::Durable SheetJournal::report(Kind kind, std::int64_t number) const {
  return [report = report_, kind, number] { report(kind, number); };
}

void SheetJournal::create(NewStoredSheet sheet) {
  sheet.sheet = sheet_;
  last_edit_ = ++last_;
  journal_->create(std::move(sheet), report(Kind::kChange, last_));
}

void SheetJournal::write(const SheetEvent& event, std::int64_t tick, std::uint64_t state_hash,
                         std::vector<StoredRequest> requests) {
  if (!is_on()) return;
  JournalEntry entry{sheet_, last_ + 1, tick, state_hash, encode_(event), std::move(requests)};
  ++last_;
  if (is_edit(event)) last_edit_ = last_;
  journal_->append(std::move(entry), report(Kind::kChange, last_));
}

void SheetJournal::save(StoredState state, Journal::Durable done) {
  state.sheet = sheet_;
  state.seq = last_;
  journal_->save(std::move(state), std::move(done));
}

void SheetJournal::write_restore(std::int64_t tick, std::uint64_t state_hash, StoredState state,
                                 std::vector<StoredRequest> requests) {
  if (!is_on()) return;
  restores_.push_back(last_ + 1);
  write(RestoreEvent{}, tick, state_hash, std::move(requests));
  save(std::move(state), report(Kind::kRestore, last_));
}

void SheetJournal::save_named(StoredState state, Release release) {
  named_.emplace(++last_named_, std::move(release));
  save(std::move(state), report(Kind::kNamed, last_named_));
}

void SheetJournal::remove_named(const std::string& name, Release release) {
  named_.emplace(++last_named_, std::move(release));
  journal_->remove_state(sheet_, name, report(Kind::kNamed, last_named_));
}

void SheetJournal::remove() {
  if (!is_on()) return;
  last_edit_ = ++last_;
  journal_->remove(sheet_, {}, report(Kind::kChange, last_));
}

void SheetJournal::when_durable(Release release) {
  if (durable_ >= last_ && waiting_.empty()) return release(Nothing{});
  waiting_.push_back({last_, std::move(release)});
}

void SheetJournal::became_durable(std::int64_t seq) {
  written_ = seq;
  durable_ = restores_.empty() ? written_ : std::min(written_, restores_.front() - 1);
  while (!waiting_.empty() && waiting_.front().seq <= durable_) {
    const Release release = std::move(waiting_.front().release);
    waiting_.pop_front();
    release(Nothing{});
  }
}

void SheetJournal::restore_became_durable(std::int64_t seq) {
  std::erase(restores_, seq);
  became_durable(written_);
}

void SheetJournal::when_named_durable(Release release) {
  if (named_.empty()) return release(Nothing{});
  waiting_named_.push_back({last_named_, std::move(release)});
}

void SheetJournal::named_became_durable(std::int64_t number) {
  const auto found = named_.find(number);
  if (found == named_.end()) return;
  const Release release = std::move(found->second);
  named_.erase(found);
  release(Nothing{});
  while (!waiting_named_.empty() && (named_.empty() || named_.begin()->first > waiting_named_.front().seq)) {
    const Release next = std::move(waiting_named_.front().release);
    waiting_named_.pop_front();
    next(Nothing{});
  }
}

void SheetJournal::give_up(const Error& error) {
  std::deque<Waiting> waiting;
  waiting.swap(waiting_);
  for (Waiting& each : waiting) each.release(error);
  std::map<std::int64_t, Release> named;
  named.swap(named_);
  for (auto& [number, release] : named) release(error);
  std::deque<Waiting> waiting_named;
  waiting_named.swap(waiting_named_);
  for (Waiting& each : waiting_named) each.release(error);
}

Status SheetJournal::check_room() const {
  return is_on() ? journal_->check_room(sheet_) : Status(Nothing{});
}

}  // namespace kerf::host
