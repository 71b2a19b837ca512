#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "server/base/result.h"

namespace kerf::host {

// A request and its answer, stored with the change that it made.
struct StoredRequest {
  std::string key;  // The method, a space and the request_id; unique in a store.
  std::uint64_t body_hash = 0;
  std::string reply;  // The encoded answer.
};

// A sheet that is to be stored, before its first entry.
struct NewStoredSheet {
  std::int64_t sheet = 0;  // As returned by Journal::new_sheet_number().
  std::string id;
  std::string scene;                 // The scene that the sheet is made from, encoded.
  std::int64_t created_unix_us = 0;  // us since 1970
  std::vector<StoredRequest> requests;
};

// One change of a sheet: what a tick did, or what happened between two ticks.
struct JournalEntry {
  std::int64_t sheet = 0;
  std::int64_t seq = 0;          // 1, 2, ... for each sheet, without a gap.
  std::int64_t tick = 0;         // Sheet::tick() after the change; lower than before if a state is restored.
  std::uint64_t state_hash = 0;  // Sheet::state_hash() after the change.
  std::string content;           // The change, encoded.
  std::vector<StoredRequest> requests;
};

// A whole sheet as it was after the entry `seq`. It continues from there without the entries before.
struct StoredState {
  std::int64_t sheet = 0;
  std::int64_t seq = 0;  // Number of its last entry; 0: it has none.
  std::int64_t tick = 0;
  std::uint64_t engine = 0;  // See sheet::engine_hash().
  std::uint64_t state_hash = 0;
  std::uint64_t continuation_hash = 0;
  std::string name;     // Given by a user; empty: the store may delete it when it is old.
  std::string content;  // The state, encoded; empty if `encode` gives it.
  // Returns the content, once, on a thread of the journal.
  std::function<std::string()> encode;
};

// The tick that a sheet has reached, where it continues after a restart.
struct SheetMark {
  std::int64_t sheet = 0;
  std::int64_t tick = 0;
};

// Writes changes of sheets to a place where they survive the end of the process and loss of power. Functions return at
// once, from any thread, and write nothing themselves. Things are written in the order in which they are given, for
// each sheet; a callback is called once on a thread of the journal, in that order, and must not block. The callback of
// a state may come after those of later changes, as its file takes long. Callbacks of a journal that is destroyed are
// not called.
class Journal {
 public:
  using Durable = std::function<void()>;

  virtual ~Journal() = default;
  // Returns a number that no sheet of this store has ever had.
  virtual std::int64_t new_sheet_number() = 0;
  virtual void create(NewStoredSheet sheet, Durable durable) = 0;
  // Stores the entry and its requests in one transaction.
  virtual void append(JournalEntry entry, Durable durable) = 0;
  // Deletes a sheet with its entries and states. Its requests stay, with `requests`.
  virtual void remove(std::int64_t sheet, std::vector<StoredRequest> requests, Durable durable) = 0;
  // Stores a state in place of the one of its name; an unnamed one in place of that of its seq.
  virtual void save(StoredState state, Durable durable) = 0;
  // Removes the states of this name, which are durable.
  virtual void remove_state(std::int64_t sheet, std::string name, Durable durable) = 0;
  // Keeps the latest mark of each sheet. May be lost.
  virtual void mark(std::vector<SheetMark> marks) = 0;
  // Returns an error if no further change of the sheet can be taken now: kUnavailable STORAGE_STALLED if too much waits
  // to be written, or has waited for over a second; kResourceExhausted STORAGE_FULL if the disk is full.
  [[nodiscard]] virtual Status check_room(std::int64_t sheet) const = 0;
  // Blocks until everything given so far is durable and its callbacks have returned, at most for `limit`. Returns
  // false if that was too short.
  virtual bool flush(std::chrono::milliseconds limit) = 0;
};

}  // namespace kerf::host
