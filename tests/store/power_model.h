#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "server/base/random.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::test {

// Knows what a store was given and what it answered, and compares both with what it holds after a loss of power.
class PowerModel {
 public:
  // Gives a random change to the store. `then` is called by its callback, if that is called.
  void give_change(store::SqliteStore& store, SeededRandom& random, std::function<void()> then);
  // Compares, then takes what the store holds as the truth.
  void compare(store::SqliteStore& store);

  void add_loss(std::string loss) { losses_.push_back(std::move(loss)); }
  [[nodiscard]] const std::vector<std::string>& losses() const { return losses_; }
  [[nodiscard]] bool has_answers() const { return num_answered_ > 0; }
  [[nodiscard]] std::int64_t num_answered() const { return num_answered_; }

 private:
  struct GivenState {
    host::StoredState state;
    bool is_answered = false;
  };
  struct Sheet {
    std::string scene;
    bool is_created = false;  // answered
    bool is_removal_given = false;
    bool is_removed = false;        // answered
    std::int64_t num_answered = 0;  // entries
    std::vector<host::JournalEntry> entries;
    std::vector<GivenState> states;  // in order of their giving
    std::int64_t highest_mark = 0;
  };
  struct Request {
    std::string reply;
    std::int64_t sheet = 0;
    std::int64_t seq = 0;
    bool is_answered = false;
  };

  std::vector<host::StoredRequest> requests(SeededRandom& random, std::int64_t sheet, std::int64_t seq);
  std::function<void()> answered(std::vector<host::StoredRequest> requests, std::function<void(PowerModel&)> note,
                                 std::function<void()> then);
  void append(store::SqliteStore& store, SeededRandom& random, std::int64_t number, std::function<void()> then);
  void save(store::SqliteStore& store, SeededRandom& random, std::int64_t number, std::function<void()> then);
  void take_over(const std::map<std::int64_t, store::StoredSheet>& found);
  void compare_sheet(store::SqliteStore& store, const store::StoredSheet& found);
  void compare_states(store::SqliteStore& store, const store::StoredSheet& found);
  void compare_requests(store::SqliteStore& store, const std::map<std::int64_t, store::StoredSheet>& found);

  std::map<std::int64_t, Sheet> sheets_;
  std::map<std::string, Request> requests_;
  std::int64_t num_requests_ = 0;
  std::atomic<std::int64_t> num_answered_ = 0;
  std::vector<std::string> losses_;
};

}  // namespace kerf::test
