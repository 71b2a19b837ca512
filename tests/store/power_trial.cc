#include "tests/store/power_trial.h"

#include <algorithm>
#include <condition_variable>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "server/base/random.h"
#include "tests/store/lossy_vfs.h"
#include "tests/store/power_model.h"

namespace kerf::test {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

// Holds the store's thread in the last callback of a group until the next group is given. So each group is one
// transaction in every run.
class Gate {
 public:
  // Called by the callback.
  void hold() {
    std::unique_lock lock(mutex_);
    is_held_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return is_released_; });
    is_released_ = false;
    is_held_ = false;
  }
  void release() {
    const std::lock_guard lock(mutex_);
    if (!is_held_) return;
    is_released_ = true;
    changed_.notify_all();
  }
  void fail() {
    const std::lock_guard lock(mutex_);
    has_failed_ = true;
    changed_.notify_all();
  }
  // Waits until the thread is held by the next group. Returns false if the store has failed.
  bool wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return has_failed_ || (is_held_ && !is_released_); });
    return !has_failed_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_held_ = false, is_released_ = false, has_failed_ = false;
};

store::StoreOptions options_on(LossyDisk& disk, const LossyVfs& vfs, Gate& gate) {
  store::StoreOptions options;
  options.folder = "/store";
  options.files = &disk;
  options.vfs = vfs.name();
  options.reserve_bytes = 0;
  options.keep.sheet_bytes = 1500;
  options.now = [] { return std::chrono::nanoseconds(0); };
  options.unix_us = [] { return std::int64_t{1'700'000'000'000'000}; };
  options.failed = [&gate](const std::string&) { gate.fail(); };
  return options;
}

// Gives random changes to a store until all are done or power is off.
void work(store::SqliteStore& store, Gate& gate, PowerModel& model, SeededRandom& random) {
  // Removing a sheet that never was writes nothing.
  store.remove(0, {}, [&gate] { gate.hold(); });
  if (!gate.wait()) return;
  const std::uint64_t num_groups = 4 + random.below(8);
  for (std::uint64_t group = 0; group < num_groups; ++group) {
    const std::uint64_t size = 1 + random.below(6);
    for (std::uint64_t i = 0; i < size; ++i) {
      model.give_change(store, random, i + 1 == size ? [&gate] { gate.hold(); } : std::function<void()>());
    }
    gate.release();
    if (!gate.wait()) return;
  }
  gate.release();
  (void)store.wait_until_durable();
}

// Opens what is left and compares.
void recover(LossyDisk& disk, const LossyVfs& vfs, PowerModel& model) {
  const auto report = store::check_store("/store", disk, vfs.name());
  const bool is_made =
      report.ok() || (report.error().reason != "STORE_NOT_FOUND" && report.error().reason != "STORE_EMPTY" &&
                      report.error().reason != "STORE_DAMAGED");
  if (report.ok()) {
    for (const std::string& fault : report->faults) model.add_loss("check_store: " + fault);
  } else if (is_made || model.has_answers()) {
    model.add_loss("check_store: " + report.error().message);
  }
  Gate unused;
  const auto store = store::SqliteStore::open(options_on(disk, vfs, unused));
  if (!store.ok()) {
    model.add_loss("cannot be opened: " + store.error().message);
    return;
  }
  model.compare(**store);
}

}  // namespace

PowerRun run_power_trial(std::uint64_t seed, std::int64_t power_ends, PowerFault fault) {
  SeededRandom random(seed);
  SeededRandom losses(seed * 1'000'003 + static_cast<std::uint64_t>(power_ends));
  LossyDisk disk;
  const LossyVfs vfs(disk);
  if (fault == PowerFault::kNoFolderSync) disk.ignore_folder_syncs();
  if (fault == PowerFault::kNoLogSync) disk.ignore_log_syncs();
  PowerModel model;
  PowerRun run;
  for (int life = 0; life < 3 && model.losses().empty(); ++life) {
    const std::int64_t ends = life == 0 ? power_ends : static_cast<std::int64_t>(1 + losses.below(150));
    disk.lose_power_after(ends);
    {
      Gate gate;
      auto store = store::SqliteStore::open(options_on(disk, vfs, gate));
      if (store.ok()) work(**store, gate, model, random);
    }
    if (life == 0) run.num_operations = disk.num_operations();
    if (power_ends == kNever) break;
    disk.restart(losses);
    recover(disk, vfs, model);
  }
  run.num_answered = model.num_answered();
  run.losses = model.losses();
  return run;
}

}  // namespace kerf::test
