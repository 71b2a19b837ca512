// Host::step(): ticks of a paused sheet by hand, and what ends them early.
#include <algorithm>
#include <atomic>
#include <future>

#include "server/service/host/host.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

TEST_F(HostTest, StepRunsExactlySoManyTicksOfAPausedSheet) {
  create("a", small_sheet(), true);
  EXPECT_EQ(status("a").tick, 0);
  Answers<SheetStatus> stepped;
  host_->step("a", 37, stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.at(0)->tick, 37);
  EXPECT_EQ(stepped.at(0)->run_state, RunState::kPaused);
  host_->step("a", 0, stepped.callback());
  host_->step("a", 100'001, stepped.callback());
  EXPECT_EQ(stepped.reason(1), "OUT_OF_RANGE");
  EXPECT_EQ(stepped.at(2).error().field, "ticks");
  host_->step("nobody", 1, stepped.callback());
  EXPECT_EQ(stepped.reason(3), "SHEET_NOT_FOUND");
  host_->resume("a", stepped.callback());
  host_->step("a", 1, stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.reason(5), "NOT_PAUSED");
}

TEST_F(HostTest, OneStepCallAtATime) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> answers;
  Answers<SheetStatus> second;
  // The strand is held until all three calls wait on it: the first cannot be done before the others come.
  std::promise<void> all_posted;
  host_->inspect(
      "a", [posted = all_posted.get_future().share()](const sheet::Sheet&) { posted.wait(); }, [](const Status&) {});
  host_->step("a", 1000, answers.callback());
  host_->step("a", 1, second.callback());
  host_->resume("a", second.callback());
  all_posted.set_value();
  host_->wait_idle();
  EXPECT_EQ(answers.at(0)->tick, 1000);
  ASSERT_EQ(second.count(), 2U);
  EXPECT_EQ(second.reason(0), "STEPPING");
  EXPECT_EQ(second.reason(1), "STEPPING");
}

TEST_F(HostTest, PauseEndsAStepCall) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> stepped;
  Answers<SheetStatus> paused;
  Answers<SheetStatus> next;
  std::promise<void> all_posted;
  host_->inspect(
      "a", [posted = all_posted.get_future().share()](const sheet::Sheet&) { posted.wait(); }, [](const Status&) {});
  host_->step("a", 100'000, stepped.callback());
  host_->pause("a", paused.callback());
  host_->step("a", 10, next.callback());
  all_posted.set_value();
  host_->wait_idle();
  ASSERT_EQ(stepped.count(), 1U);
  EXPECT_EQ(stepped.at(0)->tick, Host::kTicksPerTurn);
  EXPECT_EQ(stepped.at(0)->run_state, RunState::kPaused);
  EXPECT_EQ(paused.at(0)->tick, Host::kTicksPerTurn);
  EXPECT_EQ(next.at(0)->tick, Host::kTicksPerTurn + 10);
  EXPECT_EQ(status("a").tick, Host::kTicksPerTurn + 10);
}

// Asks for an end when it sees a certain tick.
class StopAtTick : public RecordingSnapshots {
 public:
  explicit StopAtTick(std::int64_t tick) : tick_(tick) {}
  void publish(std::shared_ptr<const sheet::Snapshot> snapshot) override {
    if (snapshot->tick == tick_) source_.request_stop();
    RecordingSnapshots::publish(std::move(snapshot));
  }
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  const std::int64_t tick_;
  std::stop_source source_;
};

TEST_F(HostTest, AStepCallEndsWhenItIsNotWantedAnyMore) {
  create("a", small_sheet(), true);
  const auto sink = std::make_shared<StopAtTick>(6);
  Answers<Nothing> added;
  host_->add_sink("a", sink, added.callback());
  Answers<SheetStatus> stepped;
  host_->step("a", 100'000, stepped.callback(), sink->token());
  host_->wait_idle();
  ASSERT_EQ(stepped.count(), 1U);
  EXPECT_EQ(stepped.at(0)->tick, 6);
  host_->step("a", 100, stepped.callback(), sink->token());
  host_->wait_idle();
  EXPECT_EQ(stepped.at(1)->tick, 6) << "nobody wanted it from the start";
  host_->step("a", 1, stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.at(2)->tick, 7);
}

TEST_F(HostTest, ResetEndsAStepCall) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> stepped;
  Answers<CommandResult> reset;
  std::promise<void> all_posted;
  host_->inspect(
      "a", [posted = all_posted.get_future().share()](const sheet::Sheet&) { posted.wait(); }, [](const Status&) {});
  host_->step("a", 100'000, stepped.callback());
  host_->submit("a", scene::Reset{}, reset.callback());
  all_posted.set_value();
  host_->wait_idle();
  EXPECT_EQ(stepped.at(0)->tick, 1);
  EXPECT_EQ(reset.at(0)->reply.tick, 1);
  EXPECT_EQ(status("a").tick, 1);
}

TEST_F(HostTest, DeleteInTheMiddleOfAStepCall) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> stepped;
  Answers<Nothing> deleted;
  host_->step("a", 100'000, stepped.callback());
  host_->delete_sheet("a", deleted.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.reason(0), "SHEET_DELETED");
  EXPECT_EQ(deleted.reason(0), "done");
  EXPECT_LT(host_->metrics().ticks, 100'000);
}

}  // namespace
}  // namespace kerf::host
