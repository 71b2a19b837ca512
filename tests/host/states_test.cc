// Saved states of sheets: a sheet goes back to one, and continues from there bit for bit.
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tests/host/states_fixture.h"
#include "tests/support/failing_integrator.h"

namespace kerf::host {
namespace {

TEST_F(StatesTest, ASheetContinuesFromASavedStateBitForBit) {
  create("a", small_sheet());
  ASSERT_TRUE(submit("a", scenes::line_cut({0.3, -0.1}, {0.35, 0.6})).ok());
  pause("a");
  const Hashes then = hashes("a");
  const SavedStateStatus saved = save("a", "before").value();
  EXPECT_EQ(saved.id, "before");
  EXPECT_EQ(saved.tick, then.tick);
  EXPECT_EQ(saved.state_hash, then.state);
  EXPECT_EQ(saved.continuation_hash, then.continuation);
  EXPECT_GT(saved.num_bytes, 1000);
  const std::vector<Hashes> first = play("a");
  const SheetStatus back = restore("a", "before").value();
  EXPECT_EQ(back.tick, then.tick);
  EXPECT_EQ(hashes("a"), then);
  EXPECT_EQ(play("a"), first);
  ASSERT_TRUE(restore("a", "before").ok()) << "a state can be restored any number of times";
  EXPECT_EQ(play("a"), first);
}

TEST_F(StatesTest, ASheetThatTouchesItselfContinuesBitForBit) {
  scene::SheetConfig config = at_50_hz(scenes::hanging(9));
  config.self_contact.is_on = true;
  create("a", std::move(config));
  ASSERT_TRUE(submit("a", scene::SetGravity{{3.0, 0.0, 9.0}}).ok());
  ASSERT_TRUE(submit("a", scenes::line_cut({0.3, -0.1}, {0.35, 0.6})).ok());
  run_for(12 * kTick);
  pause("a");
  ASSERT_TRUE(save("a", "folded").ok());
  const std::vector<Hashes> first = play("a");
  ASSERT_TRUE(restore("a", "folded").ok());
  EXPECT_EQ(play("a"), first);
}

TEST_F(StatesTest, WaitingCommandsComeBackAndKeepTheirNumbers) {
  create("a", small_sheet());
  EXPECT_EQ(schedule("a", scenes::line_cut({-0.1, 0.31}, {1.1, 0.62}), 10), 1);
  EXPECT_EQ(schedule("a", scenes::line_cut({0.31, -0.1}, {0.62, 1.1}), 20), 2);
  run_for(12 * kTick);
  ASSERT_TRUE(save("a", "between").ok()) << "the first cut is made, the second one waits";
  EXPECT_EQ(schedule("a", scenes::circle_cut({0.5, 0.5}, 0.2), 15), 3);
  run_for(20 * kTick);
  ASSERT_TRUE(restore("a", "between").ok());
  Answers<std::vector<ScheduledCommand>> waiting;
  host_->scheduled("a", waiting.callback());
  host_->wait_idle();
  ASSERT_EQ(waiting.at(0).value().size(), 1U) << "what was scheduled later is gone";
  EXPECT_EQ(waiting.at(0).value()[0].id.number, 2);
  EXPECT_EQ(schedule("a", scene::SetPins{}, 1000), 4) << "a number is given once";
  run_for(20 * kTick);
  create("b", small_sheet());
  schedule("b", scenes::line_cut({-0.1, 0.31}, {1.1, 0.62}), 10);
  schedule("b", scenes::line_cut({0.31, -0.1}, {0.62, 1.1}), 20);
  run_for(15 * kTick);
  const auto steps_to = [&](const std::string& id, std::int64_t tick) {
    pause(id);
    step(id, tick - hashes(id).tick);
    return hashes(id);
  };
  EXPECT_EQ(steps_to("a", 200), steps_to("b", 200)) << "as a sheet that never went back";
}

TEST_F(StatesTest, PauseAndSpeedStayAndASleepingSheetWakes) {
  create("a", at_50_hz(scenes::lying_on_floor(6)));
  run_for(10 * kTick);
  ASSERT_TRUE(save("a", "awake").ok());
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  ASSERT_TRUE(save("a", "asleep").ok());
  const Hashes rest = hashes("a");
  EXPECT_EQ(restore("a", "awake").value().run_state, RunState::kRunning);
  run_for(3 * kTick);
  EXPECT_EQ(hashes("a").tick, states("a")[0].tick + 4) << "the first tick is due at once";
  run_for(400 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kSleeping);
  EXPECT_EQ(hashes("a"), rest) << "it comes to rest at the same tick";
  ASSERT_TRUE(restore("a", "asleep").ok());
  run_for(3 * kTick);
  EXPECT_EQ(status("a").run_state, RunState::kSleeping) << "after a tick that finds it at rest";

  Answers<SheetStatus> answers;
  host_->set_speed("a", 2.0, answers.callback());
  pause("a");
  EXPECT_EQ(restore("a", "awake").value().run_state, RunState::kPaused);
  run_for(10 * kTick);
  EXPECT_EQ(hashes("a").tick, states("a")[0].tick);
  EXPECT_EQ(status("a").stats.speed, 2.0);
}

class FrozenStatesTest : public StatesTest {
 protected:
  static HostOptions failing() {
    HostOptions options;
    options.make_integrator = [](const fem::IntegratorOptions& wanted) {
      return std::make_unique<scenes::FailingIntegrator>(wanted);
    };
    return options;
  }
  FrozenStatesTest() : StatesTest(failing()) {}
};

TEST_F(FrozenStatesTest, AFrozenSheetRunsAgainFromASoundState) {
  create("a", small_sheet());
  run_for(5 * kTick);
  ASSERT_TRUE(save("a", "sound").ok());
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, scenes::kRunsShort}}).ok());
  run_for(5 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kFailed);
  ASSERT_TRUE(save("a", "frozen").ok()) << "a frozen sheet can be saved, too";
  EXPECT_EQ(restore("a", "sound").value().run_state, RunState::kRunning);
  const std::int64_t tick = status("a").tick;
  run_for(5 * kTick);
  EXPECT_EQ(status("a").tick, tick + 5);
  EXPECT_EQ(restore("a", "frozen").value().run_state, RunState::kFailed);
}

TEST_F(StatesTest, CountsAndChangesGoBack) {
  create("a", small_sheet());
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  ASSERT_TRUE(save("a", "one", false, "the caller's bytes").ok());
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.31}, {1.1, 0.62})).ok());
  const SheetStatus before = status("a");
  ASSERT_EQ(before.stats.resets, 2);
  const std::int64_t cuts = host_->metrics().cuts;
  const SheetStatus after = restore("a", "one").value();
  EXPECT_EQ(after.stats.resets, 1);
  EXPECT_EQ(after.pieces, 1);
  EXPECT_EQ(attachments_, (std::vector<std::string>{"", "the caller's bytes"}));
  EXPECT_GT(after.stats.settings_version, before.stats.settings_version) << "so that viewers ask for the settings";
  EXPECT_NE(after.stats.sheet_serial, before.stats.sheet_serial);
  run_for(5 * kTick);
  EXPECT_EQ(host_->metrics().cuts, cuts) << "counters of the server never fall";
}

TEST_F(StatesTest, ViewersGetTheRestoredSheetAtOnceEvenIfItIsPaused) {
  create("a", small_sheet(), true);
  ASSERT_TRUE(save("a", "flat").ok());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.31}, {1.1, 0.62})).ok());
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> added;
  host_->add_sink("a", sink, added.callback());
  host_->wait_idle();
  ASSERT_EQ(sink->snapshots().size(), 1U);
  ASSERT_TRUE(restore("a", "flat").ok());
  ASSERT_EQ(sink->snapshots().size(), 2U);
  EXPECT_EQ(sink->snapshots()[1]->topology->num_pieces, 1);
  EXPECT_EQ(host_->statuses({"a"})[0].pieces, 1);
}

TEST_F(StatesTest, ASheetThatPlaysOrIsSteppedRefuses) {
  create("a", small_sheet(), true);
  ASSERT_TRUE(save("a", "one").ok());
  std::vector<std::string> reasons;
  Answers<SheetStatus> stepped;
  host_->step("a", 1000, stepped.callback());
  Answers<SavedStateStatus> saved;
  host_->save_state("a", "two", false, saved.callback());
  host_->wait_idle();
  EXPECT_EQ(saved.reason(0), "STEPPING");
  sheet::Recorder recorder;
  recorder.start(small_sheet());
  sheet::Sheet sheet = sheet::Sheet::create(small_sheet()).value();
  for (int i = 0; i < 50; ++i) {
    sheet.step({});
    recorder.append({sheet.tick(), {}, sheet.state_hash()});
  }
  Answers<SheetStatus> made;
  host_->replay("r", recorder.recording(), false, made.callback());
  host_->wait_idle();
  EXPECT_EQ(save("r", "one").error().reason, "REPLAYING");
  run_for(60 * kTick);
  EXPECT_TRUE(save("r", "one").ok()) << "once the recording has ended";
}

// Integrators of loaded sheets find no memory while `poor` is set.
class PoorStatesTest : public StatesTest {
 protected:
  PoorStatesTest() : PoorStatesTest(std::make_shared<std::atomic<bool>>(false)) {}
  std::shared_ptr<std::atomic<bool>> poor_;

 private:
  static HostOptions options_with(const std::shared_ptr<std::atomic<bool>>& poor) {
    HostOptions options;
    options.make_integrator = [poor](const fem::IntegratorOptions& wanted) {
      if (*poor) throw std::bad_alloc();
      return fem::make_integrator(wanted);
    };
    return options;
  }
  explicit PoorStatesTest(const std::shared_ptr<std::atomic<bool>>& poor)
      : StatesTest(options_with(poor)), poor_(poor) {}
};

TEST_F(PoorStatesTest, ARestoreThatFindsNoMemoryLosesNothing) {
  create("a", small_sheet());
  create("control", small_sheet());
  run_for(5 * kTick);
  const std::int64_t tick = save("a", "one").value().tick;
  run_for(5 * kTick);
  *poor_ = true;
  EXPECT_EQ(restore("a", "one").error().reason, "OUT_OF_MEMORY");
  *poor_ = false;
  run_for(5 * kTick);
  EXPECT_EQ(hashes("a"), hashes("control"));
  EXPECT_EQ(restore("a", "one").value().tick, tick);
}

TEST_F(StatesTest, RecordingsInMemoryAreThoseOfTheRunAndTheOneOnDiskEnds) {
  struct Ends : sheet::Recorder {
    void end_early(const std::string& why) override { ends.push_back(why); }
    std::vector<std::string> ends;
  };
  const auto on_disk = std::make_shared<Ends>();
  HostOptions options;
  options.make_recording = [&](const std::string&) { return on_disk; };
  options.encode_tick = [](const sheet::RecordedTick& entry) {
    return std::to_string(entry.tick) + std::string(entry.commands.size(), '!') + " ";
  };
  host_ = std::make_unique<Host>(std::move(options), clock_, entropy_);
  const auto kept = [this] {
    Answers<KeptRun> run;
    host_->recording("a", run.callback());
    host_->wait_idle();
    return run.at(0).value().entries;
  };
  create("a", small_sheet());
  run_for(3 * kTick);
  ASSERT_TRUE(submit("a", scene::SetPins{}).ok());
  pause("a");
  const std::string run = kept();
  ASSERT_TRUE(save("a", "one").ok());
  const std::size_t entries = on_disk->recording().entries.size();
  ASSERT_TRUE(submit("a", scene::SetPins{}).ok());
  ASSERT_NE(kept(), run);
  const std::size_t more = on_disk->recording().entries.size();
  ASSERT_GT(more, entries);
  ASSERT_TRUE(restore("a", "one").ok());
  EXPECT_EQ(kept(), run);
  step("a", 5);
  EXPECT_EQ(on_disk->recording().entries.size(), more);
  ASSERT_EQ(on_disk->ends.size(), 1U);
  ASSERT_TRUE(restore("a", "one").ok());
  EXPECT_EQ(on_disk->ends.size(), 1U) << "it ends once";
}

}  // namespace
}  // namespace kerf::host
