// Commands that have a tick of their own.
#include "server/service/host/host.h"

#include <algorithm>
#include <atomic>
#include <future>

#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

TEST_F(HostTest, ACommandWithATickIsDoneAtTheStartOfItInTheOrderOfTheCalls) {
  create("a", small_sheet());
  std::vector<std::string> told;
  host_->set_command_listener([&](const std::string& id, const scene::Command& command,
                                  const Result<CommandResult>& result, const ScheduleId& schedule_id) {
    const auto* released = std::get_if<scene::Release>(&command);
    told.push_back(id + " " + (released != nullptr ? released->grab_id : "other") + " " +
                   std::to_string(schedule_id.at_tick) + "#" + std::to_string(schedule_id.number) + " " +
                   (result.ok() ? std::to_string(result->reply.tick) : result.error().reason));
  });
  Answers<std::int64_t> answers;
  host_->schedule("a", scene::Grab{"x", 0, std::nullopt, 0.0}, 4, answers.callback());
  host_->schedule("a", scene::Release{"x"}, 4, answers.callback());
  host_->schedule("a", scene::Release{"x"}, 4, answers.callback());
  host_->schedule("a", scene::SetPins{}, 3, answers.callback());
  host_->schedule("a", scene::SetPins{}, 0, answers.callback());
  host_->schedule("nobody", scene::SetPins{}, 9, answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 6U);
  std::vector<std::string> reasons;
  for (std::size_t i = 0; i < answers.count(); ++i) reasons.push_back(answers.reason(i));
  std::sort(reasons.begin(), reasons.end());
  EXPECT_EQ(reasons, (std::vector<std::string>{"SHEET_NOT_FOUND", "TICK_PAST", "done", "done", "done", "done"}));
  Answers<std::vector<ScheduledCommand>> waiting;
  host_->scheduled("a", waiting.callback());
  host_->wait_idle();
  const std::vector<ScheduledCommand> commands = waiting.at(0).value();
  ASSERT_EQ(commands.size(), 4U);
  EXPECT_EQ(commands[0].id.at_tick, 3);
  EXPECT_EQ(commands[0].id.number, 4);
  EXPECT_TRUE(std::holds_alternative<scene::Grab>(commands[1].command));
  run_for(6 * kTick);
  EXPECT_EQ(told, (std::vector<std::string>{"a other 3#4 3", "a other 4#1 4", "a x 4#2 4", "a x 4#3 GRAB_NOT_FOUND"}));
  EXPECT_EQ(host_->metrics().commands_refused, 3);
}

TEST_F(HostTest, ASheetWithACommandToComeDoesNotSleep) {
  create("a", at_50_hz(scenes::lying_on_floor(6)));
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  const std::int64_t tick = status("a").tick;
  Answers<std::int64_t> answers;
  host_->schedule("a", scenes::line_cut({-0.1, 0.4}, {1.1, 0.6}), tick + 200, answers.callback());
  host_->wait_idle();
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  run_for(190 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  EXPECT_EQ(status("a").pieces, 1);
  run_for(20 * kTick);
  EXPECT_EQ(status("a").pieces, 2);
  run_for(400 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kSleeping);
}

TEST_F(HostTest, ACommandThatWaitsIsTakenBack) {
  create("a", at_50_hz(scenes::lying_on_floor(6)));
  std::vector<std::int64_t> told;
  host_->set_command_listener([&](const auto&, const auto&, const auto&, const ScheduleId& schedule_id) {
    told.push_back(schedule_id.number);
  });
  Answers<std::int64_t> answers;
  for (const double y : {0.3, 0.5, 0.7}) {
    host_->schedule("a", scenes::line_cut({-0.1, y}, {1.1, y}), 600, answers.callback());
  }
  host_->schedule("a", scene::SetPins{}, 3, answers.callback());
  run_for(5 * kTick);
  EXPECT_EQ(answers.at(2).value(), 3);
  Answers<ScheduledCommand> cancelled;
  for (const std::int64_t number : {2, 2, 4, 0, 5}) host_->cancel("a", number, cancelled.callback());
  host_->cancel("nobody", 1, cancelled.callback());
  host_->wait_idle();
  ASSERT_EQ(cancelled.count(), 6U);
  std::vector<std::string> reasons;
  for (std::size_t i = 0; i < cancelled.count(); ++i) reasons.push_back(cancelled.reason(i));
  std::sort(reasons.begin(), reasons.end());
  EXPECT_EQ(reasons,
            (std::vector<std::string>{"SCHEDULED_CUTS_NOT_FOUND", "SCHEDULED_CUTS_NOT_FOUND", "SCHEDULED_CUTS_SETTLED",
                                      "SCHEDULED_CUTS_SETTLED", "SHEET_NOT_FOUND", "done"}));
  Answers<std::vector<ScheduledCommand>> waiting;
  host_->scheduled("a", waiting.callback());
  host_->wait_idle();
  ASSERT_EQ(waiting.at(0)->size(), 2U);
  EXPECT_EQ(waiting.at(0)->back().id.number, 3);
  // Others keep their tick; without any, the sheet falls asleep.
  run_for(600 * kTick);
  EXPECT_EQ(status("a").pieces, 3);
  EXPECT_EQ(told, (std::vector<std::int64_t>{4, 1, 3}));
  host_->schedule("a", scene::SetPins{}, status("a").tick + 100'000, answers.callback());
  run_for(400 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  host_->cancel("a", 5, cancelled.callback());
  run_for(2 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kSleeping);
}

TEST_F(HostTest, CommandsWithATickAreReplayed) {
  auto recorder = std::make_shared<sheet::Recorder>();
  HostOptions options;
  options.make_recording = [&](const std::string&) { return recorder; };
  host_->stop();
  host_ = std::make_unique<Host>(std::move(options), clock_, entropy_);
  create("a", small_sheet());
  Answers<std::int64_t> answers;
  host_->schedule("a", scene::CutBatch{scenes::three_cuts()}, 5, answers.callback());
  host_->schedule("a", scenes::circle_cut({0.5, 0.5}, 0.1), 6, answers.callback());
  host_->schedule("a", scene::UndoCut{}, 8, answers.callback());
  run_for(2 * kTick);
  Answers<ScheduledCommand> cancelled;
  host_->cancel("a", 2, cancelled.callback());
  run_for(10 * kTick);
  ASSERT_TRUE(cancelled.at(0).ok());
  ASSERT_EQ(status("a").topology_version, 3);
  host_->stop();
  const Result<sheet::ReplayReport> report = sheet::replay(recorder->recording());
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->divergence);
  EXPECT_GE(report->ticks, 12);
}

}  // namespace
}  // namespace kerf::host
