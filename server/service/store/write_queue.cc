#include "server/service/store/write_queue.h"

#include <algorithm>
#include <utility>

#include "server/base/overloaded.h"

namespace kerf::store {
namespace {

std::size_t bytes_of(const std::vector<host::StoredRequest>& requests) {
  std::size_t bytes = 0;
  for (const host::StoredRequest& request : requests) bytes += request.key.size() + request.reply.size();
  return bytes;
}

struct SheetBytes {
  std::int64_t sheet;
  std::size_t bytes;
};

SheetBytes sheet_bytes(const Change& change) {
  return std::visit(Overloaded{[](const host::NewStoredSheet& made) {
                                 return SheetBytes{made.sheet, made.scene.size() + bytes_of(made.requests)};
                               },
                               [](const host::JournalEntry& entry) {
                                 return SheetBytes{entry.sheet, entry.content.size() + bytes_of(entry.requests)};
                               },
                               [](const Removal& removal) {
                                 return SheetBytes{removal.sheet, bytes_of(removal.requests)};
                               },
                               [](const StateRemoval& removal) {
                                 return SheetBytes{removal.sheet, removal.name.size()};
                               }},
                    change.what);
}

Error stalled(const std::string& what) {
  return unavailable("STORAGE_STALLED", what + "; try again soon. If this lasts, look at the disk of the store");
}

}  // namespace

void WriteQueue::push(Change change) {
  const std::lock_guard lock(mutex_);
  const SheetBytes size = sheet_bytes(change);
  for (Waiting* const room : {&waiting_[size.sheet], &all_}) {
    room->changes += 1;
    room->bytes += size.bytes;
  }
  if (const auto* const entry = std::get_if<host::JournalEntry>(&change.what)) {
    const auto mark = next_.marks.find(entry->sheet);
    if (mark != next_.marks.end()) mark->second = std::min(mark->second, entry->tick);
  }
  since_.push_back(now_());
  next_.changes.push_back(std::move(change));
  ++next_.num_given;
  ++num_given_;
  given_.notify_one();
}

void WriteQueue::push(StateChange change) {
  const std::lock_guard lock(mutex_);
  next_.states.push_back(std::move(change));
  ++num_states_;
  given_.notify_one();
}

void WriteQueue::push(std::function<void()> task) {
  const std::lock_guard lock(mutex_);
  next_.tasks.push_back(std::move(task));
  given_.notify_one();
}

void WriteQueue::mark(const std::vector<host::SheetMark>& marks) {
  const std::lock_guard lock(mutex_);
  for (const host::SheetMark& mark : marks) next_.marks[mark.sheet] = mark.tick;
  ++next_.num_given;
  ++num_given_;
  given_.notify_one();
}

Status WriteQueue::check_room(std::int64_t sheet) const {
  const std::lock_guard lock(mutex_);
  if (failure_) return unavailable("STORAGE_FAILED", *failure_);
  if (is_full_) {
    return resource_exhausted("STORAGE_FULL",
                              "the disk of the store is full: delete sheets or other files; it is tried "
                              "again each second");
  }
  const auto found = waiting_.find(sheet);
  const Waiting own = found == waiting_.end() ? Waiting{} : found->second;
  if (own.changes >= limits_.sheet_changes || own.bytes >= limits_.sheet_bytes) {
    return stalled(std::to_string(own.changes) + " changes of the sheet with " + std::to_string(own.bytes) +
                   " bytes wait to be written; " + std::to_string(limits_.sheet_changes) + " or " +
                   std::to_string(limits_.sheet_bytes) + " bytes are the limit");
  }
  if (all_.changes >= limits_.changes || all_.bytes >= limits_.bytes) {
    return stalled(std::to_string(all_.changes) + " changes with " + std::to_string(all_.bytes) +
                   " bytes wait to be written; " + std::to_string(limits_.changes) + " or " +
                   std::to_string(limits_.bytes) + " bytes are the limit");
  }
  if (!since_.empty() && now_() - since_.front() > limits_.wait) {
    return stalled(
        "a change has waited to be written for " +
        std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(now_() - since_.front()).count()) + " ms");
  }
  return Nothing{};
}

Waiting WriteQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return all_;
}

bool WriteQueue::has_work() const {
  return is_stopping_ || next_.num_given > 0 || !next_.states.empty() || !next_.tasks.empty();
}

WriteQueue::Taken WriteQueue::take(std::optional<std::chrono::nanoseconds> patience) {
  std::unique_lock lock(mutex_);
  const auto is_ready = [this] { return has_work(); };
  if (patience) {
    given_.wait_for(lock, *patience, is_ready);
  } else {
    given_.wait(lock, is_ready);
  }
  Taken taken = std::exchange(next_, Taken{});
  taken.is_stopping = is_stopping_;
  return taken;
}

void WriteQueue::give_room(const std::vector<Change>& changes) {
  const std::lock_guard lock(mutex_);
  for (const Change& change : changes) {
    const SheetBytes size = sheet_bytes(change);
    const auto own = waiting_.find(size.sheet);
    for (Waiting* const room : {&own->second, &all_}) {
      room->changes -= 1;
      room->bytes -= size.bytes;
    }
    if (own->second.changes == 0) waiting_.erase(own);
    since_.pop_front();
  }
}

void WriteQueue::count_done(std::uint64_t num_given, std::uint64_t num_states) {
  const std::lock_guard lock(mutex_);
  num_done_ += num_given;
  num_states_done_ += num_states;
  done_.notify_all();
}

Status WriteQueue::wait_until_done() {
  std::unique_lock lock(mutex_);
  const std::uint64_t given = num_given_;
  const std::uint64_t states = num_states_;
  done_.wait(lock, [&] { return failure_ || (num_done_ >= given && num_states_done_ >= states); });
  if (failure_) return unavailable("STORAGE_FAILED", *failure_);
  return Nothing{};
}

bool WriteQueue::wait_until_done(std::chrono::milliseconds limit) {
  std::unique_lock lock(mutex_);
  const std::uint64_t given = num_given_;
  const std::uint64_t states = num_states_;
  const auto is_done = [&] { return failure_ || (num_done_ >= given && num_states_done_ >= states); };
  return done_.wait_for(lock, limit, is_done) && !failure_;
}

void WriteQueue::fail(const std::string& message) {
  const std::lock_guard lock(mutex_);
  failure_ = message;
  done_.notify_all();
}

void WriteQueue::stop() {
  const std::lock_guard lock(mutex_);
  is_stopping_ = true;
  given_.notify_one();
}

}  // namespace kerf::store
