#include <atomic>
#include <functional>
#include <memory>
#include <new>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "tests/host/fixture.h"
#include "tests/support/failing_integrator.h"

// Sheets that find no memory, or whose clients have left, and the sheets beside them.
namespace kerf::host {
namespace {

// Follows no edit where it is poor.
class PoorIntegrator : public scenes::FailingIntegrator {
 public:
  PoorIntegrator(const fem::IntegratorOptions& options, std::shared_ptr<std::atomic<bool>> poor)
      : FailingIntegrator(options), poor_(std::move(poor)) {}
  void rebuild(const fem::Model& model) override {
    if (*poor_) throw std::bad_alloc();
    FailingIntegrator::rebuild(model);
  }

 private:
  std::shared_ptr<std::atomic<bool>> poor_;
};

class HostMemoryTest : public HostTest {
 protected:
  HostMemoryTest() : HostMemoryTest(std::make_shared<std::atomic<bool>>(false)) {}

  std::shared_ptr<std::atomic<bool>> poor_;

 private:
  static HostOptions with(const std::shared_ptr<std::atomic<bool>>& poor) {
    HostOptions options;
    options.make_integrator = [poor](const fem::IntegratorOptions& wanted) {
      return std::make_unique<PoorIntegrator>(wanted, poor);
    };
    return options;
  }
  explicit HostMemoryTest(const std::shared_ptr<std::atomic<bool>>& poor) : HostTest(with(poor)), poor_(poor) {}
};

TEST_F(HostMemoryTest, ATickThatFindsNoneFreezesItsSheetAsItWasAndNoOther) {
  create("a", small_sheet());
  create("b", small_sheet());
  create("control", small_sheet());
  run_for(3 * kTick);
  const SheetStatus before = status("a");
  Answers<CommandResult> done;
  host_->submit("a", scene::SetGravity{{0, 0, scenes::kRunsShort}}, done.callback());
  run_for(5 * kTick);
  EXPECT_EQ(done.reason(0), "done") << "the command itself was done";
  const SheetStatus frozen = status("a");
  EXPECT_EQ(frozen.run_state, RunState::kFailed);
  EXPECT_EQ(frozen.tick, before.tick);
  EXPECT_EQ(host_->metrics().short_ticks, 1);
  EXPECT_EQ(host_->metrics().failed_ticks, 0);
  EXPECT_EQ(status("b").tick, before.tick + 5);
  EXPECT_EQ(status("b").state_hash, status("control").state_hash);
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.4}, {1.1, 0.4})).ok()) << "it can be cut, and";
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  EXPECT_EQ(status("a").run_state, RunState::kRunning) << "begun again";
  EXPECT_GT(status("a").tick, frozen.tick);
}

TEST_F(HostMemoryTest, AChangeThatFindsNoneEndsItsSheetAlone) {
  create("a", small_sheet());
  create("b", small_sheet());
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> added;
  host_->add_sink("a", sink, added.callback());
  run_for(3 * kTick);
  *poor_ = true;
  Answers<CommandResult> done;
  host_->submit("a", scene::Reset{}, done.callback());
  host_->submit("a", scenes::line_cut({-0.1, 0.4}, {1.1, 0.4}), done.callback());
  run_for(5 * kTick);
  ASSERT_EQ(done.count(), 2U) << "both are answered";
  EXPECT_EQ(done.reason(0), "OUT_OF_MEMORY");
  EXPECT_EQ(done.reason(1), "OUT_OF_MEMORY");
  EXPECT_EQ(sink->ends(), std::vector<sheet::SinkEnd>{sheet::SinkEnd::kSheetLost});
  EXPECT_EQ(host_->list(), std::vector<std::string>{"b"});
  EXPECT_EQ(host_->metrics().lost_sheets, 1);
  EXPECT_EQ(host_->metrics().sheets, 1);
  EXPECT_EQ(status("b").tick, 1 + 3 + 5);
  *poor_ = false;
  EXPECT_EQ(create("a", small_sheet()).id, "a") << "its name is free";
}

TEST_F(HostMemoryTest, WorkOnAPausedSheetThatFindsNoneIsAnsweredToo) {
  create("a", small_sheet(), true);
  *poor_ = true;
  Answers<CommandResult> done;
  host_->submit("a", scene::Reset{}, done.callback());
  host_->wait_idle();
  EXPECT_EQ(done.reason(0), "OUT_OF_MEMORY");
  EXPECT_TRUE(host_->list().empty());
  Answers<SheetStatus> asked;
  host_->status("a", asked.callback());
  EXPECT_EQ(asked.reason(0), "SHEET_NOT_FOUND");
}

class PoorSink : public RecordingSnapshots {
 public:
  void ended(sheet::SinkEnd /*reason*/) override { throw std::bad_alloc(); }
};

TEST_F(HostMemoryTest, ADeletionThatFindsNoneForOneTellsTheOthersAndFreesTheName) {
  create("a", small_sheet());
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> added;
  host_->add_sink("a", std::make_shared<PoorSink>(), added.callback());
  host_->add_sink("a", sink, added.callback());
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback(), [] { throw std::bad_alloc(); });
  host_->wait_idle();
  EXPECT_EQ(deleted.reason(0), "OUT_OF_MEMORY");
  EXPECT_EQ(sink->ends(), std::vector<sheet::SinkEnd>{sheet::SinkEnd::kSheetDeleted});
  EXPECT_EQ(host_->metrics().sheets, 0);
  EXPECT_EQ(create("a", small_sheet()).id, "a");
}

// A host whose sheets call this while they are built.
class CreationTest : public HostTest {
 protected:
  CreationTest() : CreationTest(std::make_shared<std::function<void()>>([] {})) {}

  static scene::SheetConfig large_sheet() { return at_50_hz(scenes::hanging(40)); }

  std::shared_ptr<std::function<void()>> meanwhile_;

 private:
  static HostOptions with(const std::shared_ptr<std::function<void()>>& meanwhile) {
    HostOptions options;
    options.make_integrator = [meanwhile](const fem::IntegratorOptions& wanted) {
      (*meanwhile)();
      return fem::make_integrator(wanted);
    };
    return options;
  }
  explicit CreationTest(const std::shared_ptr<std::function<void()>>& meanwhile)
      : HostTest(with(meanwhile)), meanwhile_(meanwhile) {}
};

TEST_F(CreationTest, ASheetThatNobodyWaitsForAnyMoreIsNotMade) {
  std::stop_source left;
  *meanwhile_ = [&] { left.request_stop(); };
  Answers<SheetStatus> answers;
  host_->create_sheet("a", large_sheet(), false, answers.callback(), left.get_token());
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "CREATION_ABANDONED");
  EXPECT_EQ(host_->metrics().sheets, 0);
  EXPECT_EQ(host_->metrics().worker_need, 0);
  bool got_far = false;
  *meanwhile_ = [&] { got_far = true; };
  host_->create_sheet("a", large_sheet(), false, answers.callback(), left.get_token());
  host_->wait_idle();
  EXPECT_EQ(answers.reason(1), "CREATION_ABANDONED");
  EXPECT_FALSE(got_far) << "its mesh was not made whole";
  EXPECT_EQ(create("a", large_sheet()).num_vertices, 1600) << "its name is free";
}

TEST_F(CreationTest, AStopEndsWhatIsBeingBuilt) {
  std::atomic<bool> began = false;
  *meanwhile_ = [&] {
    began = true;
    Answers<SheetStatus> probes;
    do {
      host_->create_sheet("probe", small_sheet(), true, probes.callback());
    } while (probes.count() == 0 || probes.reason(probes.count() - 1) != "HOST_STOPPING");
  };
  Answers<SheetStatus> answers;
  host_->create_sheet("a", large_sheet(), false, answers.callback());
  while (!began) std::this_thread::yield();
  host_->stop();
  EXPECT_TRUE(host_->has_closed_sheets());
  ASSERT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.reason(0), "HOST_STOPPING");
}

}  // namespace
}  // namespace kerf::host
