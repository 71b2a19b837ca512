#pragma once

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/service/host/host_options.h"
#include "server/service/host/journal.h"
#include "server/service/host/stored_run.h"

namespace kerf::host {

// A journal in memory. While it is held, nothing becomes durable.
class FakeJournal : public Journal {
 public:
  std::int64_t new_sheet_number() override {
    const std::lock_guard lock(mutex_);
    return ++last_sheet_;
  }
  void create(NewStoredSheet sheet, Durable durable) override {
    add(
        [this, sheet = std::move(sheet)] {
          for (const StoredRequest& each : sheet.requests) requests_[each.key] = each;
          sheets_[sheet.sheet].made = sheet;
        },
        std::move(durable));
  }
  void append(JournalEntry entry, Durable durable) override {
    add(
        [this, entry = std::move(entry)] {
          for (const StoredRequest& each : entry.requests) requests_[each.key] = each;
          Kept& kept = sheets_[entry.sheet];
          kept.entries.push_back(entry);
          kept.mark_tick = std::min(kept.mark_tick, entry.tick);  // A restore may have gone back.
        },
        std::move(durable));
  }
  void remove(std::int64_t sheet, std::vector<StoredRequest> /*requests*/, Durable durable) override {
    add([this, sheet] { sheets_.erase(sheet); }, std::move(durable));
  }
  void save(StoredState state, Durable durable) override {
    state.content = state.encode();
    add([this, state = std::move(state)] { sheets_[state.sheet].states[state.name] = state; }, std::move(durable),
        true);
  }
  void remove_state(std::int64_t sheet, std::string name, Durable durable) override {
    add([this, sheet, name = std::move(name)] { sheets_[sheet].states.erase(name); }, std::move(durable));
  }
  void mark(std::vector<SheetMark> marks) override {
    const std::lock_guard lock(mutex_);
    for (const SheetMark& each : marks) {
      if (sheets_.contains(each.sheet)) sheets_[each.sheet].mark_tick = each.tick;
    }
  }
  [[nodiscard]] Status check_room(std::int64_t /*sheet*/) const override {
    const std::lock_guard lock(mutex_);
    return room_;
  }
  bool flush(std::chrono::milliseconds /*limit*/) override { return !is_held(); }

  void hold() {
    const std::lock_guard lock(mutex_);
    is_held_ = true;
  }
  // The same for states alone.
  void hold_states() {
    const std::lock_guard lock(mutex_);
    holds_states_ = true;
  }
  // Makes durable what waits, and everything to come.
  void let_go() {
    std::vector<Durable> durable;
    {
      const std::lock_guard lock(mutex_);
      is_held_ = false;
      holds_states_ = false;
      for (const auto& [write, done] : waiting_) {
        write();
        durable.push_back(done);
      }
      waiting_.clear();
    }
    for (const Durable& done : durable) done();
  }
  void refuse(Status room) {
    const std::lock_guard lock(mutex_);
    room_ = std::move(room);
  }

  struct Kept {
    NewStoredSheet made;
    std::vector<JournalEntry> entries;
    std::map<std::string, StoredState> states;  // The latest of each name.
    std::int64_t mark_tick = 0;
  };
  [[nodiscard]] std::map<std::int64_t, Kept> sheets() const {
    const std::lock_guard lock(mutex_);
    return sheets_;
  }
  [[nodiscard]] std::map<std::string, StoredRequest> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

  // Encode and decode by numbers of a list, so that the host's tests need no messages.
  std::string encode(const SheetEvent& event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
    return std::to_string(events_.size() - 1);
  }
  std::string encode_scene(const scene::SheetConfig& config) {
    const std::lock_guard lock(mutex_);
    scenes_.push_back(config);
    return std::to_string(scenes_.size() - 1);
  }
  [[nodiscard]] SheetEvent decode(const JournalEntry& entry) const {
    const std::lock_guard lock(mutex_);
    return events_.at(std::stoul(entry.content));
  }
  std::string encode_state(const SavedState& state) {
    const std::lock_guard lock(mutex_);
    saved_.push_back(state);
    return std::to_string(saved_.size() - 1);
  }
  [[nodiscard]] StoredRun run_of(const Kept& kept) const {
    StoredRun run;
    run.sheet = kept.made.sheet;
    run.id = kept.made.id;
    run.created_unix_us = kept.made.created_unix_us;
    run.config = scenes_.at(std::stoul(kept.made.scene));
    run.mark_tick = kept.mark_tick;
    for (const auto& [name, state] : kept.states) {
      const SavedState& saved = saved_.at(std::stoul(state.content));
      if (!name.empty()) {
        run.named.push_back(saved);
      } else {
        run.state = saved;
        run.last_seq = state.seq;
      }
    }
    for (const JournalEntry& entry : kept.entries) {
      if (entry.seq <= run.last_seq) continue;
      run.changes.push_back({entry.tick, entry.state_hash, decode(entry)});
      run.last_seq = entry.seq;
    }
    return run;
  }

 private:
  [[nodiscard]] bool is_held() const {
    const std::lock_guard lock(mutex_);
    return is_held_;
  }
  void add(std::function<void()> write, Durable durable, bool is_state = false) {
    {
      const std::lock_guard lock(mutex_);
      if (is_held_ || (is_state && holds_states_))
        return waiting_.emplace_back(std::move(write), std::move(durable)), void();
      write();
    }
    durable();
  }

  mutable std::mutex mutex_;
  bool is_held_ = false;
  bool holds_states_ = false;
  Status room_ = Nothing{};
  std::int64_t last_sheet_ = 0;
  std::map<std::int64_t, Kept> sheets_;
  std::map<std::string, StoredRequest> requests_;
  std::vector<std::pair<std::function<void()>, Durable>> waiting_;
  std::vector<SheetEvent> events_;
  std::vector<scene::SheetConfig> scenes_;
  std::vector<SavedState> saved_;
};

// A host whose changes go to a FakeJournal.
inline HostOptions with_journal(FakeJournal& journal) {
  HostOptions options;
  options.journal = &journal;
  options.encode_event = [&journal](const SheetEvent& event) { return journal.encode(event); };
  options.encode_scene = [&journal](const scene::SheetConfig& config) { return journal.encode_scene(config); };
  options.encode_state = [&journal](const SavedState& state) { return journal.encode_state(state); };
  options.encode_tick = [](const sheet::RecordedTick& tick) { return std::to_string(tick.tick) + " "; };
  return options;
}

}  // namespace kerf::host
