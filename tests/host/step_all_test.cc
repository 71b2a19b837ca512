// Host::step_all(): several sheets are checked, then stepped side by side.
#include <future>
#include <map>
#include <mutex>

#include "server/service/host/host.h"
#include "server/service/host/step_group.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

// Notes the sheets that it is shown; refuses those of a list.
class Visitor : public StepVisitor {
 public:
  Status check(std::size_t number, const sheet::Sheet& sheet) override {
    const std::lock_guard lock(mutex);
    checked[number] = sheet.tick();
    if (number == refuses) return invalid_argument("NOT_THIS", "not this one");
    return Nothing{};
  }
  Status check_all() override { return all; }
  void look(std::size_t number, const sheet::Sheet& sheet, const Status& ended) override {
    const std::lock_guard lock(mutex);
    ticks[number] = sheet.tick();
    if (!ended.ok()) failures[number] = ended.error().reason;
  }

  std::mutex mutex;
  std::size_t refuses = 99;
  Status all = Nothing{};
  std::map<std::size_t, std::int64_t> checked;
  std::map<std::size_t, std::int64_t> ticks;
  std::map<std::size_t, std::string> failures;
};

class StepAllTest : public HostTest {
 protected:
  using Ticks = std::map<std::size_t, std::int64_t>;

  // Returns "done", or the reason and the field of the refusal.
  std::string step_all(const std::vector<std::string>& ids, std::int64_t ticks, const std::stop_token& stop = {}) {
    Answers<Nothing> answers;
    host_->step_all(ids, ticks, visitor_, answers.callback(), stop);
    host_->wait_idle();
    EXPECT_EQ(answers.count(), 1U) << "answered once";
    const Result<Nothing> answer = answers.at(0);
    return answer.ok() ? "done" : answer.error().reason + " " + answer.error().field;
  }
  std::vector<std::int64_t> ticks_of(const std::vector<std::string>& ids) {
    std::vector<std::int64_t> ticks;
    for (const std::string& id : ids) ticks.push_back(status(id).tick);
    return ticks;
  }
  // Holds the strand of a sheet until the returned promise is set.
  std::promise<void> hold(const std::string& id) {
    std::promise<void> promise;
    host_->inspect(
        id, [held = promise.get_future().share()](const sheet::Sheet&) { held.wait(); }, [](const Status&) {});
    return promise;
  }

  std::shared_ptr<Visitor> visitor_ = std::make_shared<Visitor>();
};

TEST_F(StepAllTest, StepsAllAndLooksAtEach) {
  for (const char* id : {"a", "b", "c"}) create(id, small_sheet(), true);
  EXPECT_EQ(step_all({"b"}, 2), "done");
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 2}}));
  visitor_ = std::make_shared<Visitor>();
  EXPECT_EQ(step_all({"c", "a", "b"}, 11), "done");
  EXPECT_EQ(visitor_->checked, (Ticks{{0, 0}, {1, 0}, {2, 2}}));
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 11}, {1, 11}, {2, 13}}));
  EXPECT_TRUE(visitor_->failures.empty());
  EXPECT_EQ(ticks_of({"a", "b", "c"}), (std::vector<std::int64_t>{11, 13, 11}));
}

TEST_F(StepAllTest, OneThatCannotBeSteppedLeavesAllAsTheyWere) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  create("runs", small_sheet(), false);
  EXPECT_EQ(step_all({"a", "b"}, 0), "OUT_OF_RANGE ticks");
  EXPECT_EQ(step_all({"a", "gone", "b"}, 5), "SHEET_NOT_FOUND names[1]");
  EXPECT_EQ(step_all({"a", "b", "runs"}, 5), "NOT_PAUSED names[2]");
  visitor_->refuses = 1;
  EXPECT_EQ(step_all({"a", "b"}, 5), "NOT_THIS names[1]");
  visitor_->refuses = 0;
  EXPECT_EQ(step_all({"b"}, 5), "NOT_THIS names[0]");
  visitor_->refuses = 99;
  visitor_->all = resource_exhausted("TOO_MUCH", "too much", "states");
  EXPECT_EQ(step_all({"a", "b"}, 5), "TOO_MUCH states");
  EXPECT_TRUE(visitor_->ticks.empty());
  EXPECT_EQ(ticks_of({"a", "b"}), (std::vector<std::int64_t>{0, 0}));
  visitor_->all = Nothing{};
  EXPECT_EQ(step_all({"a", "b"}, 5), "done") << "none is kept reserved";
}

TEST_F(StepAllTest, NobodyElseStepsOrResumesASheetThatWaitsForOthers) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  std::promise<void> held = hold("b");
  Answers<Nothing> answers;
  host_->step_all({"a", "b"}, 5, visitor_, answers.callback());
  Answers<SheetStatus> others;
  Answers<CommandResult> gravity;
  host_->step("a", 1, others.callback());
  host_->resume("a", others.callback());
  host_->submit("a", scene::SetGravity{Eigen::Vector3d(0.0, 0.0, -1.0)}, gravity.callback());
  while (others.count() < 2) {
  }
  EXPECT_EQ(others.reason(0), "STEPPING");
  EXPECT_EQ(others.reason(1), "STEPPING");
  EXPECT_EQ(gravity.count(), 0U) << "its tick has not come";
  held.set_value();
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "done");
  EXPECT_EQ(gravity.at(0)->reply.tick, 1) << "in the first tick";
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 5}, {1, 5}}));
}

TEST_F(StepAllTest, APauseEndsTheCallOfItsSheetAlone) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  std::promise<void> held = hold("b");
  Answers<Nothing> answers;
  host_->step_all({"a", "b"}, 5, visitor_, answers.callback());
  Answers<SheetStatus> paused;
  host_->pause("a", paused.callback());
  while (paused.count() < 1) {
  }
  Answers<SheetStatus> stepped;
  host_->step("a", 1, stepped.callback());
  while (stepped.count() < 1) {
  }
  EXPECT_EQ(stepped.reason(0), "done") << "it is not reserved any more";
  held.set_value();
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "done");
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 0}, {1, 5}}));
  EXPECT_EQ(ticks_of({"a", "b"}), (std::vector<std::int64_t>{1, 5}));
}

TEST_F(StepAllTest, ADeletedSheetSaysSoAndTheOthersAreStepped) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  std::promise<void> held = hold("b");
  Answers<Nothing> answers;
  host_->step_all({"a", "b"}, 5, visitor_, answers.callback());
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback());
  while (deleted.count() < 1) {
  }
  held.set_value();
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "done");
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 0}, {1, 5}}));
  EXPECT_EQ(visitor_->failures, (std::map<std::size_t, std::string>{{0, "SHEET_DELETED"}}));
}

TEST_F(StepAllTest, StopsAfterATickThatNobodyWaitsFor) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  std::stop_source source;
  source.request_stop();
  EXPECT_EQ(step_all({"a", "b"}, 100'000, source.get_token()), "done");
  EXPECT_EQ(visitor_->ticks, (Ticks{{0, 0}, {1, 0}}));
}

TEST_F(StepAllTest, TheHostsEndEndsTheCall) {
  for (const char* id : {"a", "b"}) create(id, small_sheet(), true);
  Answers<Nothing> answers;
  host_->step_all({"a", "b"}, 100'000, visitor_, answers.callback());
  host_->stop();
  ASSERT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.reason(0), "HOST_STOPPING");
}

}  // namespace
}  // namespace kerf::host
