#include "server/service/host/command_queue.h"

#include <algorithm>
#include <utility>
#include <variant>

namespace kerf::host {

CommandQueue::CommandQueue(std::int32_t max_queued, std::int32_t max_scheduled, MetricsBoard& board)
    : max_queued_(max_queued), max_scheduled_(max_scheduled), board_(board) {}

Status CommandQueue::push(scene::Command command, Callback<CommandResult>& done, Nanoseconds now,
                          RequestName<CommandResult> request, bool is_of_stream) {
  const std::lock_guard lock(mutex_);
  if (queued_.size() >= static_cast<std::size_t>(max_queued_)) {
    return resource_exhausted("QUEUE_FULL", "the sheet has " + std::to_string(max_queued_) +
                                                " commands waiting, its limit; try again after a tick");
  }
  push_locked({std::move(command), std::move(done), now, {}, false, std::move(request), is_of_stream});
  return Nothing{};
}

void CommandQueue::push_release(std::string grab_id, Nanoseconds now) {
  const std::lock_guard lock(mutex_);
  push_locked({scene::Release{std::move(grab_id)}, [](const auto&) {}, now});
}

void CommandQueue::push_locked(PendingCommand pending) {
  board_.update([](HostMetrics& m) { ++m.queued_commands; });
  const scene::Command& command = pending.command;
  if (std::holds_alternative<scene::UndoCut>(command) || std::holds_alternative<scene::Reset>(command)) {
    has_revert_ = true;
  }
  queued_.push_back(std::move(pending));
}

std::vector<PendingCommand> CommandQueue::take_queued() {
  std::vector<PendingCommand> taken;
  const std::lock_guard lock(mutex_);
  taken.swap(queued_);
  has_revert_ = false;
  if (!taken.empty()) {
    const auto count = static_cast<std::int32_t>(taken.size());
    board_.update([&](HostMetrics& m) { m.queued_commands -= count; });
  }
  return taken;
}

Result<std::int64_t> CommandQueue::schedule(scene::Command command, std::int64_t at_tick, std::int64_t tick) {
  if (at_tick <= tick) {
    return failed_precondition("TICK_PAST",
                               "at_tick is " + std::to_string(at_tick) + "; the sheet has already reached tick " +
                                   std::to_string(tick) + ": give a later one",
                               "at_tick");
  }
  if (scheduled_.size() >= static_cast<std::size_t>(max_scheduled_)) {
    return resource_exhausted("TOO_MANY_SCHEDULED",
                              "the sheet has " + std::to_string(max_scheduled_) +
                                  " commands waiting for their tick, its limit; try again when one is done",
                              "at_tick");
  }
  const auto after =
      std::upper_bound(scheduled_.begin(), scheduled_.end(), at_tick,
                       [](std::int64_t wanted, const ScheduledCommand& each) { return wanted < each.id.at_tick; });
  scheduled_.insert(after, {{at_tick, ++num_scheduled_}, std::move(command)});
  return num_scheduled_;
}

Result<ScheduledCommand> CommandQueue::cancel(std::int64_t number) {
  if (number < 1 || number > num_scheduled_) {
    return not_found("SCHEDULED_CUTS_NOT_FOUND",
                     "this sheet has no scheduled call with number " + std::to_string(number));
  }
  const auto found = std::find_if(scheduled_.begin(), scheduled_.end(),
                                  [number](const ScheduledCommand& each) { return each.id.number == number; });
  if (found == scheduled_.end()) {
    return failed_precondition(
        "SCHEDULED_CUTS_SETTLED",
        "call " + std::to_string(number) +
            " is no longer waiting: it was applied, refused or cancelled; undo reverts its cuts");
  }
  ScheduledCommand cancelled = std::move(*found);
  scheduled_.erase(found);
  return cancelled;
}

void CommandQueue::replace_scheduled(std::vector<ScheduledCommand> scheduled, std::int64_t last_number) {
  scheduled_ = std::move(scheduled);
  num_scheduled_ = std::max(num_scheduled_, last_number);
}

std::vector<PendingCommand> CommandQueue::pop_due(std::int64_t tick) {
  std::vector<PendingCommand> due;
  auto next = scheduled_.begin();
  for (; next != scheduled_.end() && next->id.at_tick <= tick; ++next) {
    due.push_back({std::move(next->command), {}, Nanoseconds{0}, next->id});
  }
  scheduled_.erase(scheduled_.begin(), next);
  return due;
}

}  // namespace kerf::host
