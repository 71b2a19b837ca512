#include "server/service/store/store_thread.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

bool met_full_disk(const Status& status) {
  return !status.ok() && (status.error().reason == "STORAGE_FULL" || status.error().reason == "DISK_FULL");
}

// Adds what was given later. An entry takes the mark of its sheet back to its own tick, as in WriteQueue::push().
void add_to(WriteQueue::Taken& batch, WriteQueue::Taken& later) {
  for (const Change& change : later.changes) {
    const auto* const entry = std::get_if<host::JournalEntry>(&change.what);
    const auto mark = entry == nullptr ? batch.marks.end() : batch.marks.find(entry->sheet);
    if (mark != batch.marks.end()) mark->second = std::min(mark->second, entry->tick);
  }
  std::move(later.changes.begin(), later.changes.end(), std::back_inserter(batch.changes));
  for (const auto& [sheet, tick] : later.marks) batch.marks[sheet] = tick;
  batch.num_given += later.num_given;
}

}  // namespace

StoreThread::StoreThread(const StoreOptions& options, Files& files, WriteQueue& queue, std::unique_ptr<Tables> tables)
    : options_(options), files_(files), queue_(queue), tables_(std::move(tables)) {}

Status StoreThread::make_reserve() {
  if (has_reserve_ || options_.reserve_bytes == 0) return Nothing{};
  const std::string path = reserve_path(options_.folder);
  const Result<std::int64_t> found = files_.size(path);
  if (!found.ok() || *found < options_.reserve_bytes) KERF_TRY(files_.reserve(path, options_.reserve_bytes));
  has_reserve_ = true;
  return Nothing{};
}

bool StoreThread::give_up_reserve() {
  return std::exchange(has_reserve_, false) && files_.remove(reserve_path(options_.folder)).ok();
}

void StoreThread::run() {
  while (true) {
    const std::vector<std::function<void()>> tasks = take();
    if (queue_.is_stopping()) return;
    waits_for_room_ = false;
    if (!has_failed_) commit();
    for (const auto& task : tasks) task();
    if (!has_failed_ && batch_.num_given == 0) advance_files();
    if (!has_failed_ && queue_.is_full()) leave_full_disk();
  }
}

std::optional<std::chrono::nanoseconds> StoreThread::patience() const {
  if (has_failed_) return std::nullopt;
  if (waits_for_room_) return options_.retry_delay;
  if (state_ || !states_.empty() || !backups_.empty() || !obsolete_files_.empty()) return std::chrono::nanoseconds(0);
  return queue_.is_full() ? std::optional(options_.retry_delay) : std::nullopt;
}

std::vector<std::function<void()>> StoreThread::take() {
  WriteQueue::Taken taken = queue_.take(patience());
  if (has_failed_) return std::move(taken.tasks);
  add_to(batch_, taken);
  std::move(taken.states.begin(), taken.states.end(), std::back_inserter(states_));
  return std::move(taken.tasks);
}

void StoreThread::commit() {
  if (batch_.num_given == 0) return;
  if (!batch_.changes.empty() || !batch_.marks.empty()) {
    const auto write = [this] { return tables_->commit(batch_.changes, batch_.marks, options_.unix_us()); };
    Status written = write();
    if (met_full_disk(written) && give_up_reserve()) {
      queue_.set_full(true);
      written = write();
    }
    if (!is_done(written)) return;
  }
  const WriteQueue::Taken done = std::exchange(batch_, WriteQueue::Taken{});
  queue_.give_room(done.changes);
  for (const Change& change : done.changes) {
    if (queue_.is_stopping()) return;
    if (change.durable) change.durable();
  }
  queue_.count_done(done.num_given, 0);
  if (!is_done(tables_->checkpoint())) return;
  if (tables_->has_many_new_requests()) (void)is_done(tables_->prune(options_.unix_us()));
}

// A backup copies the files of states, so these stay as they are until it is done.
void StoreThread::advance_files() {
  for (std::string& name : tables_->take_obsolete_files()) obsolete_files_.push_back(std::move(name));
  if (!backups_.empty()) {
    advance_backup();
    return;
  }
  if (!obsolete_files_.empty()) remove_obsolete_files();
  if (!state_ && !states_.empty()) begin_state();
  if (state_) advance_state();
}

void StoreThread::begin_state() {
  try {
    state_.emplace(files_, options_.folder, states_.front(), tables_->next_state_number());
    states_.pop_front();
  } catch (const std::bad_alloc&) {
    waits_for_room_ = true;  // Tries once more after a while.
  }
}

void StoreThread::advance_backup() {
  const Result<bool> is_last = backups_.front()->advance();
  if (is_last.ok() && !*is_last) return;
  const std::unique_ptr<BackupJob> job = std::move(backups_.front());
  backups_.pop_front();
  job->call_done(is_last.ok() ? Status(Nothing{}) : Status(is_last.error()));
}

void StoreThread::advance_state() {
  if (!is_state_written_) {
    const Result<bool> is_last = state_->advance();
    if (!is_last.ok()) {
      is_state_blocked_ = true;
      (void)is_done(is_last.error());
      state_->restart();
      return;
    }
    is_state_written_ = *is_last;
    if (!is_state_written_) return;
  }
  if (!is_done(tables_->add_state(state_->info()))) return;
  const StateJob done = std::move(*state_);
  state_.reset();
  is_state_written_ = false;
  is_state_blocked_ = false;
  if (queue_.is_stopping()) return;
  done.call_durable();
  queue_.count_done(0, 1);
  (void)is_done(tables_->checkpoint());
}

// Errors do not matter: the next opening of the store removes what no row names.
void StoreThread::remove_obsolete_files() {
  for (const std::string& name : std::exchange(obsolete_files_, {})) {
    (void)files_.remove(states_path(options_.folder) + "/" + name);
  }
}

void StoreThread::leave_full_disk() {
  if (batch_.num_given > 0 || is_state_blocked_) return;
  const Status reserved = make_reserve();
  if (reserved.ok()) {
    queue_.set_full(false);
  } else {
    (void)is_done(reserved);
  }
}

bool StoreThread::is_done(const Status& status) {
  if (status.ok()) return true;
  if (met_full_disk(status)) {
    queue_.set_full(true);
    waits_for_room_ = true;
  } else {
    fail(status.error());
  }
  return false;
}

void StoreThread::fail(const Error& error) {
  if (std::exchange(has_failed_, true)) return;
  // The next opening moves the log into the database, from what is on the disk then.
  sqlite3_db_config(tables_->database().handle(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  while (!backups_.empty()) {
    backups_.front()->call_done(error);
    backups_.pop_front();
  }
  if (options_.failed) options_.failed(error.reason + ": " + error.message);
  queue_.fail(error.message);
}

}  // namespace kerf::store
