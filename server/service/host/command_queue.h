#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/service/host/clock.h"
#include "server/service/host/command_result.h"
#include "server/service/host/metrics_board.h"

namespace kerf::host {

// Holds a command that waits for a tick, or that a tick is doing.
struct PendingCommand {
  scene::Command command;
  Callback<CommandResult> done;  // Empty if the listener gets the outcome instead.
  Nanoseconds queued_at{0};      // Time of push(); 0 for a command that was never queued.
  ScheduleId schedule_id{};      // Zeros for a command that was never scheduled.
  bool is_repeat = false;        // A Reset by the sheet itself, to repeat its scene.
  RequestName<CommandResult> request{};
  bool is_of_stream = false;  // See Host::submit().
};

// Holds the waiting commands of one sheet. Queued commands wait for the next tick boundary, scheduled ones for a given
// tick.
//
// Invariants:
//   1. At most `max_queued` commands are queued, not counting those of push_release(), and at most `max_scheduled` are
//      scheduled.
//   2. HostMetrics::queued_commands counts the queued ones.
//   3. has_revert() is true exactly while an UndoCut or Reset is queued.
//   4. Scheduled commands are sorted by tick, and within a tick by number. Numbers are 1, 2, ... and never used twice.
//
// Functions for queued commands are thread-safe. Those for scheduled commands are for one thread at a time.
class CommandQueue {
 public:
  // `max_queued`, `max_scheduled`: >= 1. `board` must outlive this.
  CommandQueue(std::int32_t max_queued, std::int32_t max_scheduled, MetricsBoard& board);

  // Queues a command at time `now`. If the queue is full, returns kResourceExhausted QUEUE_FULL and leaves `done`
  // unmoved, so that the caller can still call it.
  Status push(scene::Command command, Callback<CommandResult>& done, Nanoseconds now,
              RequestName<CommandResult> request = nullptr, bool is_of_stream = false);
  // Queues a Release of a grab even if the queue is full. Neither a caller nor the listener gets its outcome.
  void push_release(std::string grab_id, Nanoseconds now);
  // Removes all queued commands and returns them in the order they came.
  std::vector<PendingCommand> take_queued();
  // True if an UndoCut or Reset is queued: it will discard the result of the tick in progress.
  [[nodiscard]] bool has_revert() const { return has_revert_; }

  // Schedules a command for `at_tick` and returns its number. `tick`: the last tick that the sheet has done.
  // kFailedPrecondition TICK_PAST unless at_tick > tick; kResourceExhausted TOO_MANY_SCHEDULED.
  Result<std::int64_t> schedule(scene::Command command, std::int64_t at_tick, std::int64_t tick);
  // Removes a scheduled command and returns it. kNotFound SCHEDULED_CUTS_NOT_FOUND for a number that schedule() never
  // returned; kFailedPrecondition SCHEDULED_CUTS_SETTLED for a command that no longer waits.
  Result<ScheduledCommand> cancel(std::int64_t number);
  // Removes the commands scheduled for `tick` or before it and returns them in order.
  std::vector<PendingCommand> pop_due(std::int64_t tick);
  [[nodiscard]] const std::vector<ScheduledCommand>& scheduled() const { return scheduled_; }
  // Returns the last number that schedule() has returned; 0: none.
  [[nodiscard]] std::int64_t last_number() const { return num_scheduled_; }
  // Replaces the scheduled commands by those that waited in this queue earlier, when its last number was `last_number`.
  // Numbers given since then are not given again.
  void replace_scheduled(std::vector<ScheduledCommand> scheduled, std::int64_t last_number);

 private:
  void push_locked(PendingCommand pending);  // mutex_ held

  const std::int32_t max_queued_;
  const std::int32_t max_scheduled_;
  MetricsBoard& board_;
  std::mutex mutex_;
  std::vector<PendingCommand> queued_;   // guarded by mutex_
  std::atomic<bool> has_revert_{false};  // Written with mutex_ held.
  std::vector<ScheduledCommand> scheduled_;
  std::int64_t num_scheduled_ = 0;  // Commands scheduled so far, and so the last number returned.
};

}  // namespace kerf::host
