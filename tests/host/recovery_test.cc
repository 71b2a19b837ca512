// Sheets that are made again from their journal.
#include "server/service/host/stored_run.h"

#include "server/base/random.h"
#include "tests/host/fake_journal.h"
#include "tests/host/fixture.h"
#include "tests/support/trials.h"

namespace kerf::host {
namespace {

class RecoveryTest : public HostTest {
 protected:
  RecoveryTest() { begin(with_journal(journal_)); }
  ~RecoveryTest() override { host_.reset(); }  // before the journal

  void begin(HostOptions options) { host_ = std::make_unique<Host>(std::move(options), clock_, entropy_); }
  // Lets the journal get the sheet's state after each tick.
  void save_always() {
    HostOptions options = with_journal(journal_);
    options.max_unsaved_cpu = 0ns;
    begin(std::move(options));
  }

  // Makes the sheet of `journal` in a host of its own, on a clock of its own.
  struct Again {
    test::ManualClock clock;
    SeededEntropy entropy{2};
    FakeJournal journal;
    std::unique_ptr<Host> host;
    RecoveredSheet recovered;
    std::vector<std::string> heard;  // Numbers of scheduled commands, and "-" for others.

    explicit Again(const StoredRun& run) {
      host = std::make_unique<Host>(with_journal(journal), clock, entropy);
      host->set_command_listener(
          [this](const std::string&, const scene::Command&, const Result<CommandResult>&, const ScheduleId& id) {
            heard.push_back(id.number > 0 ? std::to_string(id.number) : "-");
          });
      Answers<RecoveredSheet> answers;
      host->recover(run, answers.callback());
      host->wait_idle();
      if (!answers.at(0).ok()) ADD_FAILURE() << answers.at(0).error().message;
      recovered = answers.at(0).value();
      EXPECT_EQ(clock.num_timers(), 1U) << "a recovered sheet ticks before it is let run";  // that of the marks
      host->start_recovered();
      host->wait_idle();
    }
    ~Again() { host->stop(); }
    // It may have made the tick that is due as it begins.
    SheetStatus step_to(std::int64_t tick) {
      Answers<SheetStatus> answers;
      host->pause(recovered.status.id, answers.callback());
      host->wait_idle();
      if (answers.at(0)->tick == tick) return *answers.at(0);
      host->step(recovered.status.id, tick - answers.at(0)->tick, answers.callback());
      host->wait_idle();
      EXPECT_EQ(answers.reason(1), "done") << "from tick " << answers.at(0)->tick << " to " << tick;
      return answers.at(1).ok() ? *answers.at(1) : SheetStatus();
    }
  };
  std::unique_ptr<Again> crash() {
    host_->wait_idle();
    return std::make_unique<Again>(journal_.run_of(journal_.sheets().begin()->second));
  }
  SheetStatus step(std::int64_t ticks) {
    Answers<SheetStatus> answers;
    host_->pause("a", answers.callback());
    host_->wait_idle();
    host_->step("a", ticks, answers.callback());
    host_->wait_idle();
    return answers.at(1).value();
  }

  FakeJournal journal_;
};

TEST_F(RecoveryTest, ASheetContinuesWithItsCutsItsScheduleAndItsRunState) {
  create("a", small_sheet());
  Answers<SheetStatus> statuses;
  Answers<std::int64_t> scheduled;
  host_->set_speed("a", 0.5, statuses.callback());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.5}, {0.6, 0.5})).ok());
  host_->schedule("a", scenes::line_cut({0.3, -0.1}, {0.3, 0.4}), 6, scheduled.callback());
  host_->schedule("a", scenes::line_cut({0.7, -0.1}, {0.7, 0.4}), 90, scheduled.callback());
  run_for(20 * kTick);
  const std::unique_ptr<Again> again = crash();
  const SheetStatus& status = again->recovered.status;
  EXPECT_FALSE(again->recovered.differs_at);
  EXPECT_TRUE(again->recovered.is_changed);
  EXPECT_EQ(status.run_state, RunState::kRunning);
  EXPECT_EQ(status.stats.speed, 0.5);
  EXPECT_EQ(again->heard, (std::vector<std::string>{"-", "1"}));
  Answers<std::vector<ScheduledCommand>> waiting;
  again->host->scheduled("a", waiting.callback());
  again->host->wait_idle();
  ASSERT_EQ(waiting.at(0)->size(), 1U);
  EXPECT_EQ(waiting.at(0)->at(0).id.number, 2);

  const SheetStatus live = step(100);
  const SheetStatus same = again->step_to(live.tick);
  EXPECT_EQ(same.tick, live.tick);
  EXPECT_EQ(same.state_hash, live.state_hash);
  EXPECT_EQ(same.num_vertices, live.num_vertices);
}

TEST_F(RecoveryTest, ASheetIsSteppedUpToItsMark) {
  create("a", small_sheet());
  run_for(130 * kTick);  // Marks come each second: at 50 and 100 ticks.
  const std::unique_ptr<Again> again = crash();
  EXPECT_FALSE(again->recovered.is_changed);
  EXPECT_GE(again->recovered.status.tick, 99);
  EXPECT_LE(again->recovered.status.tick, 101);
}

TEST_F(RecoveryTest, AStepOfAPausedSheetIsNotLost) {
  create("a", small_sheet(), true);
  const SheetStatus stepped = step(37);
  const std::unique_ptr<Again> again = crash();
  EXPECT_EQ(again->recovered.status.tick, 37);
  EXPECT_EQ(again->recovered.status.run_state, RunState::kPaused);
  EXPECT_EQ(again->recovered.status.state_hash, stepped.state_hash);
}

scene::Command grab(const char* id, mesh::VertexId vertex) {
  return scene::Grab{id, vertex, Eigen::Vector3d(0.5, 0.5, 0.3), 0.0};
}

// Returns the ids of the grabs of the sheet "a".
std::vector<std::string> grabs_of(Host& host) {
  std::vector<std::string> ids;
  host.inspect(
      "a",
      [&](const sheet::Sheet& sheet) {
        for (const sheet::GrabState& grab : sheet.grabs()) ids.push_back(grab.grab_id);
      },
      [](const auto&) {});
  host.wait_idle();
  return ids;
}

TEST_F(RecoveryTest, GrabsOfStreamsAreReleasedAndOthersAreKept) {
  for (const bool is_saved : {false, true}) {
    SCOPED_TRACE(is_saved);
    if (is_saved) save_always();
    create("a", small_sheet());
    const auto ignore = [](const auto&) {};
    host_->submit("a", grab("again", 2), ignore, nullptr, true);
    run_for(3 * kTick);
    host_->submit("a", scene::Reset{}, ignore);
    host_->submit("a", grab("again", 2), ignore);
    host_->submit("a", grab("hand", 3), ignore, nullptr, true);
    host_->submit("a", grab("script", 5), ignore);
    host_->submit("a", grab("gone", 7), ignore, nullptr, true);
    run_for(3 * kTick);
    host_->release_grab("a", "gone");
    run_for(3 * kTick);
    const std::unique_ptr<Again> again = crash();
    again->clock.move_to(again->clock.now() + 3 * kTick);
    EXPECT_EQ(grabs_of(*again->host), (std::vector<std::string>{"again", "script"}));
    const std::vector<JournalEntry> entries = again->journal.sheets().begin()->second.entries;
    ASSERT_EQ(entries.size(), 1U) << "the release is a change that a later restart repeats";
    const auto change = std::get<TickEvent>(again->journal.decode(entries[0]));
    EXPECT_EQ(std::get<scene::Release>(change.commands.at(0)).grab_id, "hand");
    Answers<Nothing> deleted;
    host_->delete_sheet("a", deleted.callback());
    host_->wait_idle();
  }
}

TEST_F(RecoveryTest, ARestoredStateHasNoHandsOfStreams) {
  create("a", small_sheet());
  const auto ignore = [](const auto&) {};
  host_->submit("a", grab("hand", 3), ignore, nullptr, true);
  host_->submit("a", grab("script", 5), ignore);
  run_for(3 * kTick);
  host_->save_state("a", "s", false, ignore);
  run_for(3 * kTick);
  host_->release_grab("a", "hand");
  run_for(3 * kTick);
  host_->restore_state("a", "s", ignore);
  host_->wait_idle();
  run_for(3 * kTick);
  EXPECT_EQ(grabs_of(*host_), std::vector<std::string>{"script"});
}

TEST_F(RecoveryTest, ASheetThatSleptSleeps) {
  create("a", at_50_hz(scenes::lying_on_floor(6)));
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  const std::unique_ptr<Again> again = crash();
  EXPECT_EQ(again->recovered.status.run_state, RunState::kSleeping);
  EXPECT_EQ(again->recovered.status.tick, status("a").tick);
}

TEST_F(RecoveryTest, AHashThatDiffersIsReported) {
  create("a", small_sheet());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.5}, {0.6, 0.5})).ok());
  StoredRun run = journal_.run_of(journal_.sheets().begin()->second);
  run.changes.at(0).state_hash ^= 1U;
  const Again again(run);
  EXPECT_EQ(again.recovered.differs_at, run.changes.at(0).tick);
  EXPECT_EQ(again.host->statuses({"a"}).at(0).resimulated_from_tick, run.changes.at(0).tick);
}

scene::Command random_command(SeededRandom& random) {
  const auto at = [&] { return Eigen::Vector2d(random.uniform(-0.1, 1.1), random.uniform(-0.1, 1.1)); };
  switch (random.below(8)) {
    case 0:
      return scene::UndoCut{};
    case 1:
      return scene::RedoCut{};
    case 2:
      return scene::Grab{"x", static_cast<mesh::VertexId>(random.below(20)), Eigen::Vector3d(0.5, 0.5, 0.3), 0.0};
    case 3:
      return scene::Release{"x"};
    case 4:
      return random.below(4) == 0 ? scene::Command(scene::Reset{})
                                  : scene::Command(scene::SetGravity{{0.0, 0.0, -3.0}});
    default:
      return scenes::line_cut(at(), at());
  }
}

TEST_F(RecoveryTest, ASheetIsMadeFromItsLastStateAndTheChangesAfterIt) {
  save_always();
  create("a", small_sheet());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.5}, {0.6, 0.5})).ok());
  run_for(5 * kTick);
  journal_.hold_states();
  ASSERT_TRUE(submit("a", scenes::line_cut({0.3, -0.1}, {0.3, 0.4})).ok());
  run_for(5 * kTick);
  const StoredRun run = journal_.run_of(journal_.sheets().begin()->second);
  ASSERT_TRUE(run.state);
  EXPECT_EQ(run.changes.size(), 1U);
  Again again(run);
  EXPECT_FALSE(again.recovered.differs_at);
  EXPECT_EQ(again.heard.size(), 1U) << "the cut before is in the attachment";
  const SheetStatus live = step(30);
  EXPECT_EQ(again.step_to(live.tick).state_hash, live.state_hash);
}

TEST_F(RecoveryTest, ARestoreIsShownOnceItsStateIsDurable) {
  create("a", small_sheet());
  Answers<SavedStateStatus> saved;
  host_->save_state("a", "before", false, saved.callback());
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.5}, {0.6, 0.5})).ok());
  const std::int32_t cut = status("a").num_vertices;
  journal_.hold_states();
  Answers<SheetStatus> restored;
  host_->restore_state("a", "before", restored.callback());
  run_for(5 * kTick);
  EXPECT_EQ(restored.count(), 0U);
  EXPECT_EQ(host_->statuses({"a"}).at(0).num_vertices, cut);
  journal_.let_go();
  host_->wait_idle();
  ASSERT_EQ(restored.reason(0), "done");
  EXPECT_LT(restored.at(0)->num_vertices, cut);
  const std::unique_ptr<Again> again = crash();
  EXPECT_LT(again->recovered.status.num_vertices, cut);
  Answers<std::vector<SavedStateStatus>> named;
  again->host->states("a", named.callback());
  again->host->wait_idle();
  ASSERT_EQ(named.at(0)->size(), 1U) << "named states outlive the server";
  EXPECT_EQ(named.at(0)->at(0).id, "before");
  const SheetStatus live = step(30);
  EXPECT_EQ(again->step_to(live.tick).state_hash, live.state_hash);
}

TEST_F(RecoveryTest, RandomRunsContinueExactly) {
  const std::uint64_t end = test::first_seed() + static_cast<std::uint64_t>(test::num_trials({2, 8, 200}));
  for (std::uint64_t seed = test::first_seed(); seed < end; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SeededRandom random(seed);
    if (seed % 3 == 0) save_always();
    create("a", random.below(2) == 0 ? small_sheet() : at_50_hz(scenes::draped_over_sphere(7)));
    const auto ignore = [](const auto&) {};
    for (int i = 0; i < 25; ++i) {
      run_for(static_cast<std::int64_t>(random.below(6)) * kTick);
      const SheetStatus now = status("a");
      switch (random.below(8)) {
        case 0:
          host_->pause("a", ignore);
          break;
        case 1:
          host_->schedule("a", random_command(random), now.tick + 1 + static_cast<std::int64_t>(random.below(9)),
                          ignore);
          break;
        case 2:
          host_->cancel("a", 1 + static_cast<std::int64_t>(random.below(5)), ignore);
          break;
        case 3:
          host_->save_state("a", "s", true, ignore);
          break;
        case 4:
          if (seed % 2 == 0) host_->restore_state("a", "s", ignore);
          break;
        default:
          host_->submit("a", random_command(random), ignore);
      }
      if (random.below(3) == 0) host_->resume("a", ignore);
    }
    run_for(2 * kTick);
    const std::unique_ptr<Again> again = crash();
    EXPECT_FALSE(again->recovered.differs_at);
    const SheetStatus live = step(40);
    const SheetStatus same = again->step_to(live.tick);
    EXPECT_EQ(same.tick, live.tick);
    EXPECT_EQ(same.state_hash, live.state_hash);
    Answers<Nothing> deleted;
    host_->delete_sheet("a", deleted.callback());
    host_->wait_idle();
  }
}

}  // namespace
}  // namespace kerf::host
