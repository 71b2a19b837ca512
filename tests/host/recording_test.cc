// The recordings that sheets keep, and sheets that play one.
#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "server/service/host/kept_recording.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

constexpr std::size_t kEntryBytes = 10;  // of every entry, whatever is in it

// Entries that a host has encoded, of one sheet.
using Entries = std::vector<sheet::RecordedTick>;

class KeepingHostTest : public HostTest {
 protected:
  static HostOptions keeping(const std::shared_ptr<Entries>& entries) {
    HostOptions options;
    options.encode_tick = [entries](const sheet::RecordedTick& entry) {
      entries->push_back(entry);
      return std::string(kEntryBytes, 'e');
    };
    options.max_recording_bytes = 40 * kEntryBytes;
    return options;
  }
  explicit KeepingHostTest(std::shared_ptr<Entries> entries = std::make_shared<Entries>())
      : HostTest(keeping(entries)), entries_(std::move(entries)) {}

  Result<KeptRun> recording(const std::string& id) {
    Answers<KeptRun> answers;
    host_->recording(id, answers.callback());
    host_->wait_idle();
    return answers.at(0);
  }
  // Returns the recording of sheet a, up to now.
  sheet::Recording taken() {
    const Result<KeptRun> run = recording("a");
    EXPECT_TRUE(run.ok());
    return {*run->config, *entries_};
  }
  SheetStatus replay(const std::string& id, sheet::Recording recorded, bool paused = false) {
    Answers<SheetStatus> answers;
    host_->replay(id, std::move(recorded), paused, answers.callback());
    host_->wait_idle();
    return answers.at(0).value();
  }

  // A cut, a pause with a punch and a step by hand, gravity, a reset; 78 ticks or so.
  void live() {
    create("a", at_50_hz(scenes::hanging(8)));
    run_for(5 * kTick);
    ASSERT_TRUE(submit("a", scenes::line_cut({0.2, 0.5}, {0.8, 0.4})).ok());
    run_for(3 * kTick);
    Answers<SheetStatus> done;
    host_->pause("a", done.callback());
    ASSERT_TRUE(submit("a", scenes::circle_cut({0.5, 0.7}, 0.1)).ok());
    ASSERT_FALSE(submit("a", scene::Drag{"nothing", {0, 0, 0}}).ok());
    host_->step("a", 60, done.callback());
    host_->resume("a", done.callback());
    run_for(3 * kTick);
    host_->resume("a", done.callback());
    run_for(3 * kTick);
    ASSERT_TRUE(submit("a", scene::SetGravity{{0, 1, -2}}).ok());
    ASSERT_TRUE(submit("a", scene::SetMaterial{fem::find_preset("silk").value(), std::nullopt}).ok());
    run_for(3 * kTick);
  }

  std::shared_ptr<Entries> entries_;
};

TEST_F(KeepingHostTest, ARunIsKeptByItsCommandsAndEvery64thTickAndReplaysBitForBit) {
  live();
  const sheet::Recording recorded = taken();
  const SheetStatus now = status("a");
  // A cut; the pause, before the punch; punch, bad drag; tick 64; gravity, material; now.
  EXPECT_EQ(recorded.entries.size(), 8U);
  EXPECT_EQ(recording("a")->entries.size(), 8 * kEntryBytes);
  const Result<sheet::ReplayReport> report = sheet::replay(recorded);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence);
  EXPECT_EQ(report->ticks, now.tick);
  EXPECT_EQ(recorded.entries.back().state_hash, now.state_hash);
}

TEST_F(KeepingHostTest, ASheetPlaysARecordingAndIsPausedAtItsEnd) {
  live();
  const sheet::Recording recorded = taken();
  const SheetStatus original = status("a");
  EXPECT_EQ(replay("b", recorded).replay->state, ReplayState::kPlaying);
  run_for(20 * kTick);
  const SheetStatus halfway = status("b");
  EXPECT_EQ(halfway.replay->state, ReplayState::kPlaying);
  EXPECT_EQ(halfway.replay->end_tick, original.tick);
  EXPECT_EQ(halfway.tick, 21);
  EXPECT_EQ(submit("b", scene::SetPins{}).error().reason, "REPLAYING");
  Answers<std::int64_t> scheduled;
  host_->schedule("b", scene::SetPins{}, 1000, scheduled.callback());
  host_->wait_idle();
  EXPECT_EQ(scheduled.reason(0), "REPLAYING");
  run_for(200 * kTick);
  const SheetStatus ended = status("b");
  EXPECT_EQ(ended.replay->state, ReplayState::kDone);
  EXPECT_EQ(ended.run_state, RunState::kPaused);
  EXPECT_EQ(ended.tick, original.tick);
  EXPECT_EQ(ended.state_hash, original.state_hash);
  EXPECT_EQ(ended.materials, original.materials);
  EXPECT_GT(ended.stats.settings_version, halfway.stats.settings_version);
  ASSERT_TRUE(submit("b", scene::Reset{}).ok()) << "anybody's from here on";
}

TEST_F(KeepingHostTest, APlayedRecordingIsPausedSteppedAndSpedUp) {
  live();
  const sheet::Recording recorded = taken();
  const SheetStatus original = status("a");
  replay("b", recorded, true);
  run_for(10 * kTick);
  EXPECT_EQ(status("b").tick, 0);
  Answers<SheetStatus> done;
  host_->step("b", 10, done.callback());
  host_->wait_idle();
  EXPECT_EQ(done.at(0)->tick, 10);
  host_->set_speed("b", 4.0, done.callback());
  host_->resume("b", done.callback());
  run_for(5 * kTick);
  EXPECT_EQ(status("b").tick, 10 + 21);
  host_->pause("b", done.callback());
  host_->step("b", 1000, done.callback());
  host_->wait_idle();
  EXPECT_EQ(done.at(4)->tick, original.tick) << "not beyond the recording";
  EXPECT_EQ(status("b").state_hash, original.state_hash);
  EXPECT_EQ(status("b").replay->state, ReplayState::kDone);
}

TEST_F(KeepingHostTest, AHashThatDiffersEndsTheReplayAndIsTold) {
  live();
  sheet::Recording recorded = taken();
  const std::size_t changed = 4;
  recorded.entries[changed].state_hash ^= 1;
  replay("b", recorded);
  run_for(200 * kTick);
  const SheetStatus ended = status("b");
  ASSERT_EQ(ended.replay->state, ReplayState::kDiverged);
  EXPECT_EQ(ended.replay->divergence->entry, changed);
  EXPECT_EQ(ended.replay->divergence->tick, recorded.entries[changed].tick);
  EXPECT_EQ(ended.replay->divergence->recorded_hash, recorded.entries[changed].state_hash);
  EXPECT_EQ(ended.replay->divergence->replayed_hash, recorded.entries[changed].state_hash ^ 1);
  EXPECT_EQ(ended.tick, recorded.entries[changed].tick);
  EXPECT_EQ(ended.run_state, RunState::kPaused);
}

TEST_F(KeepingHostTest, EntriesOutOfOrderAreRefusedAndLeaveNothing) {
  live();
  sheet::Recording recorded = taken();
  const auto refused = [&] {
    Answers<SheetStatus> answers;
    host_->replay("b", recorded, false, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  };
  recorded.entries.push_back({recorded.entries.back().tick + sheet::kMaxRecordedGap + 1, {}, 0});
  EXPECT_EQ(refused(), "RECORDING_ORDER");
  recorded.entries.back().tick = 1;
  EXPECT_EQ(refused(), "RECORDING_ORDER");
  EXPECT_EQ(host_->list(), std::vector<std::string>{"a"});
}

TEST_F(KeepingHostTest, AnEmptyRecordingIsDoneAtOnce) {
  const SheetStatus made = replay("b", {small_sheet(), {}});
  EXPECT_EQ(made.replay->state, ReplayState::kDone);
  EXPECT_EQ(made.run_state, RunState::kPaused);
  EXPECT_EQ(made.tick, 0);
}

TEST_F(KeepingHostTest, ARecordingThatOutgrowsItsLimitIsGivenUpAsAWhole) {
  create("a", small_sheet(), true);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, -1.0}}).ok());
  EXPECT_EQ(recording("a")->entries.size(), 40 * kEntryBytes) << "at the limit";
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, -1.0}}).ok());
  const Result<KeptRun> run = recording("a");
  ASSERT_FALSE(run.ok());
  EXPECT_EQ(run.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(run.error().reason, "RECORDING_TOO_LONG");
  EXPECT_NE(run.error().message.find("tick 0"), std::string::npos);
}

// A host with one worker that tells of every entry as soon as a sheet has done it, on the sheet's strand.
class EntriesHostTest : public HostTest {
 protected:
  static constexpr int kEntries = 20;  // of tick 0, and one of tick 1

  EntriesHostTest() : EntriesHostTest(std::make_shared<std::function<void()>>([] {})) {}

  // With `kEntries` of gravity before the first tick and one command after it.
  sheet::Recording recorded() {
    create("a", small_sheet(), true);
    sheet::Recording run{small_sheet(), {}};
    const auto note = [&](scene::Command command) {
      EXPECT_TRUE(submit("a", command).ok());
      const SheetStatus now = status("a");
      run.entries.push_back({now.tick, {std::move(command)}, *now.state_hash});
    };
    for (int i = 0; i < kEntries; ++i) note(scene::SetGravity{{0, 0, -1.0 - i}});
    Answers<SheetStatus> stepped;
    host_->step("a", 1, stepped.callback());
    host_->wait_idle();
    run.entries.push_back({1, {}, *stepped.at(0)->state_hash});
    for (int i = 0; i < kEntries; ++i) note(scene::SetGravity{{0, 1.0 + i, 0}});
    return run;
  }

  std::shared_ptr<std::function<void()>> done_;  // called after every entry; set while the host is idle

 private:
  explicit EntriesHostTest(const std::shared_ptr<std::function<void()>>& done) : HostTest(telling(done)), done_(done) {}

  static HostOptions telling(const std::shared_ptr<std::function<void()>>& done) {
    HostOptions options;
    options.workers = 1;
    options.long_work = 0ms;  // turns are counted, by one thread
    options.max_load = 0.0;
    options.encode_tick = [done](const sheet::RecordedTick&) {
      (*done)();
      return std::string("e");
    };
    return options;
  }
};

TEST_F(EntriesHostTest, AFewEntriesOfOneTickAreATurn) {
  const sheet::Recording run = recorded();
  for (const bool by_clock : {true, false}) {
    int in_a_row = 0;
    int most = 0;
    // Each entry asks another sheet for a turn, which it gets when this sheet's is over.
    *done_ = [&] {
      most = std::max(most, ++in_a_row);
      host_->inspect(
          "a", [&in_a_row](const sheet::Sheet&) { in_a_row = 0; }, [](const auto&) {});
    };
    Answers<SheetStatus> answers;
    host_->replay("b", run, !by_clock, answers.callback());
    host_->wait_idle();
    if (by_clock) {
      run_for(3 * kTick);
    } else {
      host_->step("b", 10, answers.callback());
    }
    host_->wait_idle();
    *done_ = [] {};
    const SheetStatus ended = status("b");
    EXPECT_EQ(ended.replay->state, ReplayState::kDone);
    EXPECT_EQ(ended.state_hash, run.entries.back().state_hash);
    EXPECT_EQ(ended.tick, 1);
    EXPECT_LE(most, 2 * Host::kEntriesPerTurn + 1) << "before a tick, the tick itself, after it";
    Answers<Nothing> gone;
    host_->delete_sheet("b", gone.callback());
    host_->wait_idle();
  }
}

TEST_F(EntriesHostTest, ASheetPausedWithinATickGoesOnWithTheRestOfIt) {
  const sheet::Recording run = recorded();
  Answers<SheetStatus> answers;
  bool paused = false;
  *done_ = [&] {
    if (!std::exchange(paused, true)) host_->pause("b", answers.callback());
  };
  host_->replay("b", run, false, answers.callback());
  run_for(3 * kTick);
  *done_ = [] {};
  EXPECT_EQ(status("b").replay->state, ReplayState::kPlaying);
  EXPECT_EQ(status("b").tick, 0);
  host_->step("b", 1, answers.callback());
  host_->wait_idle();
  const SheetStatus ended = status("b");
  EXPECT_EQ(ended.tick, 1) << "with all that was done before it and after it";
  EXPECT_EQ(ended.replay->state, ReplayState::kDone);
  EXPECT_EQ(ended.state_hash, run.entries.back().state_hash);
}

TEST_F(EntriesHostTest, AHostThatStopsPlaysNoMoreEntries) {
  const sheet::Recording run = recorded();
  std::atomic<int> done = 0;
  std::thread stopping;
  *done_ = [&] {
    if (++done > 1) return;
    stopping = std::thread([&] { host_->stop(); });
    while (!host_->list().empty()) std::this_thread::yield();  // until it has begun
  };
  Answers<SheetStatus> answers;
  host_->replay("b", run, false, answers.callback());
  clock_.move_to(clock_.now() + kTick);
  host_->wait_idle();
  clock_.move_to(clock_.now() + kTick);
  while (done == 0) std::this_thread::yield();
  host_->wait_idle();
  stopping.join();
  EXPECT_EQ(done, 1);
}

TEST_F(EntriesHostTest, TheEndOfASteppedReplayIsPublished) {
  const sheet::Recording run = recorded();
  Answers<SheetStatus> answers;
  host_->replay("b", run, true, answers.callback());
  host_->wait_idle();
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> added;
  host_->add_sink("b", sink, added.callback());
  host_->step("b", 10, answers.callback());
  host_->wait_idle();
  const SheetStatus ended = status("b");
  ASSERT_TRUE(answers.at(1).ok());
  ASSERT_EQ(ended.replay->state, ReplayState::kDone);
  EXPECT_EQ(sink->snapshots().back()->stats.settings_version, ended.stats.settings_version);
}

TEST_F(HostTest, WithoutAnEncoderNothingIsKept) {
  create("a", small_sheet());
  Answers<KeptRun> answers;
  host_->recording("a", answers.callback());
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "RECORDING_NOT_KEPT");
}

}  // namespace
}  // namespace kerf::host
