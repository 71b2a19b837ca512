#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/service/host/command_result.h"
#include "server/service/host/journal.h"
#include "server/service/host/sheet_event.h"

namespace kerf::host {

// Numbers the changes of one sheet, gives them to the Journal, and holds back what must wait until they are durable.
// Without a Journal everything is durable at once. For one thread at a time.
class SheetJournal {
 public:
  using Encode = std::function<std::string(const SheetEvent&)>;
  enum class Kind { kChange, kRestore, kNamed };
  using Report = std::function<void(Kind kind, std::int64_t number)>;
  // Receives errors instead of success if the sheet ends before its changes are durable.
  using Release = std::function<void(const Status&)>;

  SheetJournal() = default;
  // `sheet`: number of the sheet in the store. `last_seq`: number of its last durable entry, or kNotStored.
  // `durable`: called on a thread of the journal with the number of each thing that is durable. It must post a call of
  // the function for its kind to the sheet's strand.
  SheetJournal(Journal& journal, std::int64_t sheet, std::int64_t last_seq, Encode encode, Report durable);

  static constexpr std::int64_t kNotStored = -1;

  [[nodiscard]] bool is_on() const { return journal_ != nullptr; }
  [[nodiscard]] std::int64_t sheet() const { return sheet_; }
  [[nodiscard]] std::int64_t last_seq() const { return last_; }

  // Stores the sheet, before its first entry. Sets the number of `sheet`.
  void create(NewStoredSheet sheet);
  // Stores a change of the sheet, which is at `tick` with this hash.
  void write(const SheetEvent& event, std::int64_t tick, std::uint64_t state_hash, std::vector<StoredRequest> requests);
  // Returns the request with its answer, or nothing if it has no name or there is no journal.
  template <typename T>
  [[nodiscard]] std::vector<StoredRequest> answered(const RequestName<T>& request, const T& answer) const {
    if (!is_on() || !request) return {};
    return {{request->key, request->body_hash, request->encode(answer)}};
  }
  // Stores the state that the sheet is in, between two changes. `done`: called on a thread of the journal.
  void save(StoredState state, Journal::Durable done);
  // Stores that the sheet continues from `state`: the change is durable once the state is, and later ones not before.
  void write_restore(std::int64_t tick, std::uint64_t state_hash, StoredState state,
                     std::vector<StoredRequest> requests);
  // Stores the state that the sheet is in under a name, or removes the states of a name. `release` is called once that
  // is durable.
  void save_named(StoredState state, Release release);
  void remove_named(const std::string& name, Release release);
  // Calls `release` once all that save_named() and remove_named() were given so far is durable; at once if it is.
  void when_named_durable(Release release);
  // Deletes the sheet from the store; nothing may be written after it.
  void remove();
  // Calls `release` once all changes so far are durable, after those of earlier calls; at once if they are.
  void when_durable(Release release);
  // Calls the releases of all changes up to `seq`, or up to the one before a restore whose state is not durable yet.
  void became_durable(std::int64_t seq);
  // Calls the releases that waited for the state of the restore with this number.
  void restore_became_durable(std::int64_t seq);
  // Calls the release of save_named() or remove_named() with this number.
  void named_became_durable(std::int64_t number);
  // Passes `error` to all that wait.
  void give_up(const Error& error);

  // True if what viewers see of the sheet now must be held back.
  [[nodiscard]] bool holds_back() const { return durable_ < last_edit_; }
  [[nodiscard]] std::int64_t last_edit() const { return last_edit_; }
  // True if every change is durable, and every release was called.
  [[nodiscard]] bool is_settled() const { return durable_ >= last_ && waiting_.empty(); }
  [[nodiscard]] std::int64_t durable() const { return durable_; }
  // Returns the error of Journal::check_room(); callable from any thread.
  [[nodiscard]] Status check_room() const;

 private:
  struct Waiting {
    std::int64_t seq;
    Release release;
  };

  [[nodiscard]] Journal::Durable report(Kind kind, std::int64_t number) const;

  Journal* journal_ = nullptr;
  std::int64_t sheet_ = 0;
  Encode encode_;
  Report report_;
  std::int64_t last_ = 0;       // Number of the last change that was written; creation is 0.
  std::int64_t last_edit_ = 0;  // Number of the last one that viewers must not see before it is durable.
  std::int64_t durable_ = 0;
  std::int64_t written_ = 0;  // Number of the last change that is durable in the store, restores aside.
  std::int64_t last_named_ = 0;
  std::map<std::int64_t, Release> named_;  // By the numbers of save_named() and remove_named().
  std::deque<Waiting> waiting_named_;      // In order; `seq` is a number of `named_`.
  std::deque<std::int64_t> restores_;      // Numbers of restores whose states are not durable yet.
  std::deque<Waiting> waiting_;            // In order of their numbers.
};

}  // namespace kerf::host
