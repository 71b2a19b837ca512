#include "server/service/host/command_queue.h"

#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

class CommandQueueTest : public testing::Test {
 protected:
  // Queues a command; returns the reason of a refusal, or "".
  std::string push(scene::Command command) {
    Callback<CommandResult> done = [this](const auto&) { ++answers_; };
    const Status pushed = queue_.push(std::move(command), done, 5ms);
    EXPECT_EQ(done == nullptr, pushed.ok()) << "the callback is moved exactly if the command is queued";
    return pushed.ok() ? "" : pushed.error().reason;
  }
  [[nodiscard]] std::int32_t counted() const { return board_.read().queued_commands; }
  [[nodiscard]] std::vector<std::int64_t> waiting() const {
    std::vector<std::int64_t> numbers;
    for (const ScheduledCommand& each : queue_.scheduled()) numbers.push_back(each.id.number);
    return numbers;
  }

  MetricsBoard board_;
  CommandQueue queue_{2, 3, board_};
  int answers_ = 0;
};

TEST_F(CommandQueueTest, GivesBackWhatWasQueuedInOrder) {
  EXPECT_EQ(push(scene::SetGravity{}), "");
  EXPECT_EQ(push(scene::Reset{}), "");
  EXPECT_EQ(counted(), 2);
  const std::vector<PendingCommand> taken = queue_.take_queued();
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<scene::SetGravity>(taken[0].command));
  EXPECT_TRUE(std::holds_alternative<scene::Reset>(taken[1].command));
  EXPECT_EQ(taken[0].queued_at, Nanoseconds(5ms));
  EXPECT_EQ(taken[0].schedule_id.number, 0);
  EXPECT_EQ(counted(), 0);
  EXPECT_TRUE(queue_.take_queued().empty());
  EXPECT_EQ(answers_, 0);
}

TEST_F(CommandQueueTest, RefusesMoreThanItsLimitButTakesEveryRelease) {
  EXPECT_EQ(push(scene::SetGravity{}), "");
  EXPECT_EQ(push(scene::SetGravity{}), "");
  EXPECT_EQ(push(scene::SetGravity{}), "QUEUE_FULL");
  queue_.push_release("hand", 6ms);
  EXPECT_EQ(counted(), 3);
  const std::vector<PendingCommand> taken = queue_.take_queued();
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_EQ(std::get<scene::Release>(taken[2].command).grab_id, "hand");
  taken[2].done(Error{});  // A release has a callback too, which does nothing.
  EXPECT_EQ(push(scene::SetGravity{}), "");
}

TEST_F(CommandQueueTest, SaysWhetherACommandTakesBackTheTickInProgress) {
  push(scene::SetGravity{});
  EXPECT_FALSE(queue_.has_revert());
  push(scene::UndoCut{});
  EXPECT_TRUE(queue_.has_revert());
  (void)queue_.take_queued();
  EXPECT_FALSE(queue_.has_revert());
  push(scene::Reset{});
  EXPECT_TRUE(queue_.has_revert());
}

TEST_F(CommandQueueTest, PopsScheduledCommandsByTickThenByNumber) {
  EXPECT_EQ(queue_.schedule(scene::SetGravity{}, 9, 0).value(), 1);
  EXPECT_EQ(queue_.schedule(scene::Reset{}, 4, 0).value(), 2);
  EXPECT_EQ(queue_.schedule(scene::UndoCut{}, 4, 0).value(), 3);
  EXPECT_EQ(waiting(), (std::vector<std::int64_t>{2, 3, 1}));
  EXPECT_EQ(counted(), 0);
  EXPECT_TRUE(queue_.pop_due(3).empty());
  const std::vector<PendingCommand> due = queue_.pop_due(5);
  ASSERT_EQ(due.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<scene::Reset>(due[0].command));
  EXPECT_EQ(due[0].schedule_id.number, 2);
  EXPECT_EQ(due[1].schedule_id.at_tick, 4);
  EXPECT_FALSE(due[1].done);
  EXPECT_EQ(waiting(), std::vector<std::int64_t>{1});
  EXPECT_FALSE(queue_.has_revert()) << "scheduled commands interrupt no tick";
}

TEST_F(CommandQueueTest, SchedulesOnlyAheadAndUpToItsLimit) {
  EXPECT_EQ(queue_.schedule(scene::SetGravity{}, 7, 7).error().reason, "TICK_PAST");
  for (std::int64_t i = 1; i <= 3; ++i) EXPECT_EQ(queue_.schedule(scene::SetGravity{}, 8, 7).value(), i);
  const Error full = queue_.schedule(scene::SetGravity{}, 8, 7).error();
  EXPECT_EQ(full.reason, "TOO_MANY_SCHEDULED");
  EXPECT_EQ(full.field, "at_tick");
}

TEST_F(CommandQueueTest, CancelsEachCommandOnce) {
  ASSERT_TRUE(queue_.schedule(scene::SetGravity{}, 8, 0).ok());
  ASSERT_TRUE(queue_.schedule(scene::Reset{}, 9, 0).ok());
  const Result<ScheduledCommand> cancelled = queue_.cancel(2);
  ASSERT_TRUE(cancelled.ok());
  EXPECT_EQ(cancelled->id.at_tick, 9);
  EXPECT_TRUE(std::holds_alternative<scene::Reset>(cancelled->command));
  EXPECT_EQ(queue_.cancel(2).error().reason, "SCHEDULED_CUTS_SETTLED");
  EXPECT_EQ(queue_.cancel(3).error().reason, "SCHEDULED_CUTS_NOT_FOUND");
  EXPECT_EQ(queue_.cancel(0).error().reason, "SCHEDULED_CUTS_NOT_FOUND");
  EXPECT_EQ(queue_.schedule(scene::SetGravity{}, 9, 0).value(), 3) << "numbers are never used twice";
}

TEST_F(CommandQueueTest, CommandsOfEarlierComeBackAndTheirNumbersAreNotGivenAgain) {
  ASSERT_TRUE(queue_.schedule(scene::Reset{}, 8, 0).ok());
  const std::vector<ScheduledCommand> earlier = queue_.scheduled();
  ASSERT_EQ(queue_.last_number(), 1);
  ASSERT_TRUE(queue_.schedule(scene::SetGravity{}, 9, 0).ok());
  queue_.replace_scheduled(earlier, 1);
  EXPECT_EQ(waiting(), std::vector<std::int64_t>{1});
  EXPECT_EQ(queue_.last_number(), 2);
  EXPECT_EQ(queue_.cancel(2).error().reason, "SCHEDULED_CUTS_SETTLED");
  queue_.replace_scheduled(earlier, 7);
  EXPECT_EQ(queue_.schedule(scene::SetGravity{}, 9, 0).value(), 8);
}

}  // namespace
}  // namespace kerf::host
