#include "server/app/kept_sheets.h"

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "server/service/durable/stored_runs.h"
#include "server/service/host/host.h"
#include "server/service/store/sqlite_store.h"

namespace kerf::app {

namespace {

constexpr const char* kWhatToDo =
    "; it stays kept and its name is free: restore a backup that has it whole, or delete it (kerf store info)";

std::string name_of(const store::StoredSheet& stored) {
  return "the kept sheet \"" + stored.id + "\"";
}

// Recovers sheets side by side. The host answers on its threads, and the thread that waits takes the results.
class Recoveries {
 public:
  explicit Recoveries(host::Host& host) : host_(host) {}

  struct Done {
    const store::StoredSheet* stored;
    durable::Beginning beginning;
    Result<host::RecoveredSheet> result;
  };
  void start(const store::StoredSheet& stored, durable::Beginning beginning, host::StoredRun run) {
    ++num_running_;
    host_.recover(std::move(run), [answers = answers_, &stored, beginning](Result<host::RecoveredSheet> result) {
      const std::lock_guard lock(answers->mutex);
      answers->done.push_back({&stored, beginning, std::move(result)});
      answers->has_come.notify_one();
    });
  }
  // Waits for one of those that were started.
  Done wait() {
    std::unique_lock lock(answers_->mutex);
    answers_->has_come.wait(lock, [this] { return !answers_->done.empty(); });
    Done done = std::move(answers_->done.front());
    answers_->done.pop_front();
    --num_running_;
    return done;
  }
  [[nodiscard]] std::size_t num_running() const { return num_running_; }

 private:
  struct Answers {
    std::mutex mutex;
    std::condition_variable has_come;
    std::deque<Done> done;
  };

  host::Host& host_;
  std::size_t num_running_ = 0;
  std::shared_ptr<Answers> answers_ = std::make_shared<Answers>();
};

class KeptSheets {
 public:
  KeptSheets(store::SqliteStore& store, host::Host& host, const std::set<std::string>& left_out,
             const std::function<void(std::string_view line)>& note)
      : store_(store),
        note_(note),
        left_out_(left_out),
        recoveries_(host),
        num_at_once_(2 * static_cast<std::size_t>(host.options().workers)) {}

  Result<KeptSheetsFound> recover() {
    KERF_TRY_ASSIGN(const std::vector<store::StoredSheet> sheets, store_.sheets());
    Status status = Nothing{};
    for (const store::StoredSheet& stored : sheets) {
      while (status.ok() && recoveries_.num_running() >= num_at_once_) status = finish(recoveries_.wait());
      if (status.ok()) status = start(stored);
      if (!status.ok()) break;
    }
    while (recoveries_.num_running() > 0) {  // They refer to `sheets`.
      const Recoveries::Done done = recoveries_.wait();
      if (status.ok()) status = finish(done);
    }
    KERF_TRY(status);
    return std::move(found_);
  }

 private:
  Status start(const store::StoredSheet& stored) {
    if (left_out_.contains(stored.id) && !stored.is_quarantined && !stored.is_damaged) {
      found_.left_out.push_back(stored.sheet);
      return Nothing{};
    }
    if (stored.is_quarantined) {
      note_(name_of(stored) + " is set aside: " + stored.reason + kWhatToDo);
      return Nothing{};
    }
    Result<host::StoredRun> run = durable::read_run(store_, stored);
    if (!run.ok() && run.error().code == ErrorCode::kDataLoss) {
      KERF_TRY(store_.quarantine(stored.sheet, run.error().message));
      note_(name_of(stored) + " is damaged and set aside: " + run.error().message + kWhatToDo);
      return Nothing{};
    }
    KERF_TRY(run);
    KERF_TRY(note_past(stored));
    KERF_TRY_ASSIGN(const std::vector<store::DamagedState> damaged, store_.set_damaged_states_aside(stored.sheet));
    for (const store::DamagedState& state : damaged) {
      note_(name_of(stored) + " continues without a state: " + state.reason +
            (state.kept_file.empty() ? "" : "; it is now \"" + state.kept_file + "\""));
    }
    recoveries_.start(stored, durable::Beginning::kNewestState, std::move(*run));
    return Nothing{};
  }

  // Says which changes before the newest state are damaged: the sheet does not need them, and cannot be repeated from
  // its beginning.
  Status note_past(const store::StoredSheet& stored) {
    KERF_TRY_ASSIGN(const std::vector<std::string> faults, store_.journal_faults(stored));
    for (const std::string& fault : faults) {
      note_(name_of(stored) + " continues, and cannot be repeated from its beginning: " + fault);
    }
    return Nothing{};
  }

  Status finish(const Recoveries::Done& done) {
    const store::StoredSheet& stored = *done.stored;
    if (done.result.ok()) {
      if (done.result->differs_at) {
        note_(name_of(stored) + " differs from what it was, from tick " + std::to_string(*done.result->differs_at) +
              " on: it was computed again, by another build or processor");
      }
      if (done.result->is_changed) found_.changed.insert(stored.id);
      return Nothing{};
    }
    const Error& error = done.result.error();
    // A state that this build cannot load is not needed if the store has the whole run.
    if (error.reason.starts_with("SAVED_SHEET") && done.beginning == durable::Beginning::kNewestState) {
      Result<host::StoredRun> run = durable::read_run(store_, stored, durable::Beginning::kScene);
      if (run.ok()) {
        recoveries_.start(stored, durable::Beginning::kScene, std::move(*run));
        return Nothing{};
      }
    }
    note_(name_of(stored) + " is not started, and stays kept: " + error.message);
    return Nothing{};
  }

  store::SqliteStore& store_;
  const std::function<void(std::string_view line)>& note_;
  const std::set<std::string>& left_out_;
  Recoveries recoveries_;
  const std::size_t num_at_once_;  // Enough to keep all threads busy; each takes the memory of a stored run.
  KeptSheetsFound found_;
};

}  // namespace

Result<KeptSheetsFound> recover_sheets(store::SqliteStore& store, host::Host& host,
                                       const std::set<std::string>& left_out,
                                       const std::function<void(std::string_view line)>& note) {
  return KeptSheets(store, host, left_out, note).recover();
}

}  // namespace kerf::app
