#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

#include "server/base/result.h"
#include "server/service/host/journal.h"

namespace kerf::store {

struct Removal {
  std::int64_t sheet = 0;
  std::vector<host::StoredRequest> requests;
};

struct StateRemoval {
  std::int64_t sheet = 0;
  std::string name;
};

// A change that waits to be written, all of it or nothing.
struct Change {
  std::variant<host::NewStoredSheet, host::JournalEntry, Removal, StateRemoval> what;
  host::Journal::Durable durable;
};

struct StateChange {
  host::StoredState state;
  host::Journal::Durable durable;
};

// Bounds what is not yet durable: beyond them WriteQueue::check_room() refuses.
struct QueueLimits {
  std::size_t sheet_changes = 64;
  std::size_t sheet_bytes = std::size_t{4} << 20U;
  std::size_t changes = 4096;
  std::size_t bytes = std::size_t{64} << 20U;
  std::chrono::nanoseconds wait = std::chrono::seconds(1);  // of the oldest
};

// Counts what is given and not yet durable.
struct Waiting {
  std::size_t changes = 0;
  std::size_t bytes = 0;
};

// Hands changes, states, marks and tasks from all threads to the thread of a store. Thread-safe.
class WriteQueue {
 public:
  using Now = std::function<std::chrono::nanoseconds()>;
  // All that waited at one time.
  struct Taken {
    std::vector<Change> changes;
    std::map<std::int64_t, std::int64_t> marks;  // ticks by sheet
    std::vector<StateChange> states;             // Given after the changes before them.
    std::vector<std::function<void()>> tasks;
    std::uint64_t num_given = 0;  // changes and calls of mark()
    bool is_stopping = false;
  };

  WriteQueue(QueueLimits limits, Now now) : limits_(limits), now_(std::move(now)) {}

  void push(Change change);
  void push(StateChange change);
  void push(std::function<void()> task);
  // An entry that is pushed later takes the mark of its sheet back to its own tick, if that is lower.
  void mark(const std::vector<host::SheetMark>& marks);
  [[nodiscard]] Status check_room(std::int64_t sheet) const;
  [[nodiscard]] Waiting waiting() const;

  // Returns all that waits. If that is nothing, waits for up to `patience`, or without end if there is none.
  Taken take(std::optional<std::chrono::nanoseconds> patience);
  // Gives back the room that these changes took: they are durable.
  void give_room(const std::vector<Change>& changes);
  // Their callbacks have been called. Ends wait_until_done() of those who gave them.
  void count_done(std::uint64_t num_given, std::uint64_t num_states);
  // Waits until all that was given so far is done. Returns the error of fail() if that comes first.
  Status wait_until_done();
  // The same for at most this time. Returns false after an error, or if it was too short.
  bool wait_until_done(std::chrono::milliseconds limit);
  void set_full(bool is_full) { is_full_ = is_full; }
  [[nodiscard]] bool is_full() const { return is_full_; }
  void fail(const std::string& message);
  void stop();
  [[nodiscard]] bool is_stopping() const { return is_stopping_; }

 private:
  [[nodiscard]] bool has_work() const;

  const QueueLimits limits_;
  const Now now_;
  std::atomic<bool> is_full_ = false;
  std::atomic<bool> is_stopping_ = false;

  mutable std::mutex mutex_;
  std::condition_variable given_;
  std::condition_variable done_;
  Taken next_;
  std::unordered_map<std::int64_t, Waiting> waiting_;  // by sheet, given and not durable
  Waiting all_;
  std::deque<std::chrono::nanoseconds> since_;  // when each of them was given
  std::uint64_t num_given_ = 0, num_done_ = 0;
  std::uint64_t num_states_ = 0, num_states_done_ = 0;
  std::optional<std::string> failure_;
};

}  // namespace kerf::store
