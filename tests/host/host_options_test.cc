#include <atomic>
#include <new>

#include "tests/host/fixture.h"
#include "tests/support/failing_integrator.h"

// Hosts with limits, with sheets that fail, and with recordings.
namespace kerf::host {
namespace {

class SmallHostTest : public HostTest {
 protected:
  static HostOptions limits() {
    HostOptions options;
    options.max_sheets = 2;
    options.max_vertices_per_sheet = 25;
    options.max_queued_commands = 1;
    return options;
  }
  SmallHostTest() : HostTest(limits()) {}
};

TEST_F(SmallHostTest, LimitsOnSheetsVerticesAndCommands) {
  Answers<SheetStatus> answers;
  host_->create_sheet("big", scenes::hanging(6), false, answers.callback());
  EXPECT_EQ(answers.reason(0), "TOO_MANY_VERTICES");
  scene::SheetConfig obj = small_sheet();
  obj.pins.clear();
  std::string text;
  for (int i = 0; i < 26; ++i) text += "v " + std::to_string(i) + " " + std::to_string(i % 2) + " 0\n";
  for (int i = 1; i < 25; ++i) {
    const int b = i % 2 == 1 ? i + 1 : i + 2;
    const int c = i % 2 == 1 ? i + 2 : i + 1;
    text += "f " + std::to_string(i) + " " + std::to_string(c) + " " + std::to_string(b) + "\n";
  }
  obj.mesh = scene::ObjSource{text};
  host_->create_sheet("obj", obj, false, answers.callback());
  host_->wait_idle();
  EXPECT_EQ(answers.reason(1), "TOO_MANY_VERTICES");  // known only once it is built
  create("a", small_sheet());
  create("b", small_sheet());
  host_->create_sheet("c", small_sheet(), false, answers.callback());
  EXPECT_EQ(answers.reason(2), "TOO_MANY_SHEETS");
  Answers<CommandResult> commands;
  host_->submit("a", scene::Reset{}, commands.callback());
  host_->submit("a", scene::Reset{}, commands.callback());
  EXPECT_EQ(commands.reason(0), "QUEUE_FULL");
  host_->submit("b", scene::Reset{}, commands.callback());  // each sheet has its own
  run_for(kTick);
  EXPECT_EQ(commands.count(), 3U);
}

TEST_F(SmallHostTest, CutsKeepTheLimitOnVertices) {
  create("a", at_50_hz(scenes::hanging(3)), true);
  const std::optional<std::uint64_t> before = status("a").state_hash;
  const Result<CommandResult> refused = submit("a", scenes::circle_cut({0.5, 0.5}, 0.3));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_VERTICES");
  EXPECT_EQ(status("a").state_hash, before);
  EXPECT_EQ(status("a").topology_version, 1);
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.5}, {1.1, 0.5})).ok());
  EXPECT_LE(status("a").num_vertices, 25);
}

class BudgetHostTest : public HostTest {
 protected:
  static constexpr std::int64_t kLimit = 50;

  static HostOptions budget() {
    HostOptions options;
    options.workers = 1;
    options.max_total_vertices = kLimit;
    return options;
  }
  explicit BudgetHostTest(HostOptions options = budget()) : HostTest(std::move(options)) {}

  std::string try_to_create(const std::string& id, scene::SheetConfig config) {
    Answers<SheetStatus> answers;
    host_->create_sheet(id, std::move(config), true, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  }
  std::string try_to_create(const std::string& id, int vertices_a_side) {
    return try_to_create(id, at_50_hz(scenes::hanging(vertices_a_side)));
  }
  void remove(const std::string& id) {
    host_->delete_sheet(id, [](const Result<Nothing>& deleted) { EXPECT_TRUE(deleted.ok()); });
    host_->wait_idle();
  }
  // Returns a disk, whose number of vertices is unknown before it is built.
  static scene::SheetConfig outlined_sheet(double edge_length) {
    scene::SheetConfig config = small_sheet();
    config.pins.clear();
    scene::OutlineSource outline;
    outline.boundary = cut::Circle{{0.5, 0.5}, 0.5};
    outline.edge_length = edge_length;
    config.mesh = outline;
    return config;
  }
};

TEST_F(BudgetHostTest, AsManyVerticesAsTheLimitAndNotOneMore) {
  EXPECT_EQ(try_to_create("a", 5), "done");
  EXPECT_EQ(try_to_create("b", 5), "done") << "50 of 50";
  Answers<SheetStatus> refused;
  host_->create_sheet("c", scenes::hanging(2), false, refused.callback());
  ASSERT_EQ(refused.count(), 1U) << "at once";
  EXPECT_EQ(refused.at(0).error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.reason(0), "TOO_MANY_VERTICES_IN_ALL");
  EXPECT_NE(refused.at(0).error().message.find("may have 50 vertices and already have 50"), std::string::npos)
      << refused.at(0).error().message;
  remove("b");
  host_->create_sheet("c", scenes::hanging(6), true, refused.callback());
  EXPECT_EQ(refused.reason(1), "TOO_MANY_VERTICES_IN_ALL") << "36 where 25 are left";
  EXPECT_EQ(try_to_create("c", 5), "done");
}

TEST_F(BudgetHostTest, AReplayCountsAsAnyOtherSheet) {
  Answers<SheetStatus> answers;
  host_->replay("a", {small_sheet(), {}}, true, answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.reason(0), "done");
  EXPECT_EQ(try_to_create("b", 5), "done");
  host_->replay("c", {small_sheet(), {}}, true, answers.callback());
  EXPECT_EQ(answers.reason(1), "TOO_MANY_VERTICES_IN_ALL");
}

TEST_F(BudgetHostTest, ASheetThatIsNotMadeTakesNothing) {
  scene::SheetConfig bad = small_sheet();
  bad.tick_rate_hz = -1.0;
  for (int i = 0; i < 3; ++i) EXPECT_NE(try_to_create("a", bad), "TOO_MANY_VERTICES_IN_ALL");
  bad.mesh = scene::GridSource{30'000, 30'000, 1.0, 1.0};
  EXPECT_NE(try_to_create("a", bad), "TOO_MANY_VERTICES_IN_ALL") << "more than any sheet may have, whatever there is";
  EXPECT_EQ(try_to_create("A!", 5), "SHEET_ID");
  EXPECT_EQ(try_to_create("a", 5), "done");
  EXPECT_EQ(try_to_create("a", 5), "SHEET_EXISTS");
  EXPECT_EQ(try_to_create("b", 5), "done");
}

TEST_F(BudgetHostTest, OfWhatDeclaresNoSizeIsRefusedWhenItIsBuilt) {
  EXPECT_EQ(try_to_create("a", outlined_sheet(0.05)), "TOO_MANY_VERTICES_IN_ALL");
  EXPECT_TRUE(host_->list().empty());
  EXPECT_EQ(host_->metrics().sheets, 0);
  EXPECT_EQ(try_to_create("a", outlined_sheet(0.35)), "done") << "its name is free again";
  const int has = status("a").num_vertices;
  ASSERT_GT(has, 9);
  ASSERT_LE(has, 25);
  EXPECT_EQ(try_to_create("b", 5), "done");
  EXPECT_EQ(try_to_create("c", 5), "TOO_MANY_VERTICES_IN_ALL") << "it counts with what it has";
  remove("a");
  EXPECT_EQ(try_to_create("c", 5), "done");
  Answers<SheetStatus> full;
  host_->create_sheet("d", outlined_sheet(0.35), true, full.callback());
  ASSERT_EQ(full.count(), 1U) << "where nothing is left it is not even built";
  EXPECT_EQ(full.reason(0), "TOO_MANY_VERTICES_IN_ALL");
}

TEST_F(BudgetHostTest, WhatCutsAddCountsAndIsNotRefused) {
  create("a", small_sheet(), true);
  create("b", small_sheet(), true);
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.45}, {1.1, 0.55})).ok());
  ASSERT_GT(status("a").num_vertices, 25);
  remove("b");
  EXPECT_EQ(try_to_create("b", 5), "TOO_MANY_VERTICES_IN_ALL");
  ASSERT_TRUE(submit("a", scene::UndoCut{}).ok());
  EXPECT_EQ(try_to_create("b", 5), "done") << "an undo gives them back";
}

// Sheets are built once it is open, the first of them without memory where it is poor.
struct Site {
  std::atomic<bool> open{false};
  std::atomic<bool> poor{false};
};

class BuildingHostTest : public BudgetHostTest {
 protected:
  static HostOptions with(const std::shared_ptr<Site>& site) {
    HostOptions options = budget();
    options.make_integrator = [site](const fem::IntegratorOptions& integrator) {
      site->open.wait(false);
      if (site->poor.exchange(false)) throw std::bad_alloc();
      return fem::make_integrator(integrator);
    };
    return options;
  }
  explicit BuildingHostTest(std::shared_ptr<Site> site = std::make_shared<Site>())
      : BudgetHostTest(with(site)), site_(std::move(site)) {}
  void open() {
    site_->open = true;
    site_->open.notify_all();
  }
  std::shared_ptr<Site> site_;
};

TEST_F(BuildingHostTest, WhatIsBeingBuiltCounts) {
  Answers<SheetStatus> answers;
  host_->create_sheet("a", small_sheet(), true, answers.callback());
  host_->create_sheet("b", small_sheet(), true, answers.callback());
  host_->create_sheet("c", small_sheet(), true, answers.callback());
  EXPECT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.reason(0), "TOO_MANY_VERTICES_IN_ALL");
  open();
  host_->wait_idle();
  EXPECT_EQ(host_->list(), (std::vector<std::string>{"a", "b"}));
}

TEST_F(BuildingHostTest, ASheetForWhichThereIsNoMemoryIsRefusedAndTheHostGoesOn) {
  site_->poor = true;
  open();
  Answers<SheetStatus> answers;
  host_->create_sheet("a", small_sheet(), true, answers.callback());
  host_->wait_idle();
  EXPECT_EQ(answers.at(0).error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(answers.reason(0), "OUT_OF_MEMORY");
  EXPECT_EQ(try_to_create("a", 5), "done");
  EXPECT_EQ(try_to_create("b", 5), "done");
}

class FailingHostTest : public HostTest {
 protected:
  static HostOptions failing() {
    HostOptions options;
    options.make_integrator = scenes::make_failing_integrator;
    return options;
  }
  FailingHostTest() : HostTest(failing()) {}
};

TEST_F(FailingHostTest, AFailingSheetFreezesAloneAndAResetStartsItAgain) {
  create("a", small_sheet());
  create("b", small_sheet());
  run_for(3 * kTick);
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, scenes::kGivesUp}}).ok());
  run_for(10 * kTick);
  const SheetStatus frozen = status("a");
  EXPECT_EQ(frozen.run_state, RunState::kFailed);
  EXPECT_TRUE(frozen.stats.failed);
  EXPECT_EQ(frozen.tick, 4 + 3);
  EXPECT_EQ(clock_.num_timers(), 1U);  // that of b
  EXPECT_EQ(host_->metrics().failed_ticks, 3);
  EXPECT_EQ(host_->metrics().flagged_ticks[3], 3) << fem::kStepFlagNames[3];
  EXPECT_EQ(frozen.flagged_ticks, host_->metrics().flagged_ticks) << "those of the one that failed";
  EXPECT_EQ(status("b").flagged_ticks, fem::FlagCounts{});
  EXPECT_EQ(host_->metrics().failed_sheets, 1);
  EXPECT_EQ(status("b").tick, 16);
  EXPECT_EQ(submit("a", scenes::line_cut({-0.1, 0.4}, {1.1, 0.4}))->reply.cut->report.pieces, 2);
  Answers<SheetStatus> stepped;
  host_->pause("a", stepped.callback());
  host_->step("a", 1, stepped.callback());
  host_->resume("a", stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.reason(1), "SHEET_FROZEN");
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  EXPECT_GT(status("a").tick, frozen.tick);
  EXPECT_EQ(status("a").flagged_ticks[3], 3) << "kept through a reset";
}

TEST_F(FailingHostTest, AStepCallEndsWhereTheSheetFreezes) {
  create("a", small_sheet(), true);
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, scenes::kWritesNonsense}}).ok());
  Answers<SheetStatus> stepped;
  host_->step("a", 100, stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(stepped.reason(0), "SHEET_FROZEN");
  EXPECT_EQ(status("a").tick, 3);
}

class RecordingHostTest : public HostTest {
 protected:
  static HostOptions recording(const std::shared_ptr<sheet::Recorder>& recorder) {
    HostOptions options;
    options.make_recording = [recorder](const std::string& id) { return id == "a" ? recorder : nullptr; };
    return options;
  }
  explicit RecordingHostTest(std::shared_ptr<sheet::Recorder> recorder = std::make_shared<sheet::Recorder>())
      : HostTest(recording(recorder)), recorder_(std::move(recorder)) {}
  std::shared_ptr<sheet::Recorder> recorder_;
};

TEST_F(FailingHostTest, ASheetThatFreezesIsRecordedInOrder) {
  const auto recorder = std::make_shared<sheet::Recorder>();
  HostOptions options = failing();
  options.make_recording = [recorder](const std::string&) { return recorder; };
  host_ = std::make_unique<Host>(std::move(options), clock_, entropy_);
  create("a", small_sheet());
  run_for(3 * kTick);
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 0, scenes::kGivesUp}}).ok());
  run_for(10 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kFailed);
  ASSERT_TRUE(submit("a", scenes::line_cut({-0.1, 0.4}, {1.1, 0.4})).ok());
  Answers<SheetStatus> stepped;
  host_->pause("a", stepped.callback());
  host_->step("a", 1, stepped.callback());
  host_->resume("a", stepped.callback());
  run_for(3 * kTick);
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  run_for(3 * kTick);
  host_->stop();
  const Status order = sheet::check_order(recorder->recording().entries);
  EXPECT_TRUE(order.ok()) << order.error().message;
  EXPECT_GT(recorder->recording().entries.back().tick, 7) << "the reset let it go on";
}

TEST_F(RecordingHostTest, WhatWasServedReplaysBitForBit) {
  create("a", at_50_hz(scenes::hanging(8)));
  create("b", small_sheet());
  run_for(5 * kTick);
  ASSERT_TRUE(submit("a", scenes::line_cut({0.2, 0.5}, {0.8, 0.4})).ok());
  ASSERT_TRUE(submit("a", scene::SetGravity{{0, 1, -2}}).ok());
  Answers<SheetStatus> done;
  host_->pause("a", done.callback());
  ASSERT_TRUE(submit("a", scenes::circle_cut({0.5, 0.7}, 0.1)).ok());
  host_->step("a", 7, done.callback());
  host_->resume("a", done.callback());
  run_for(5 * kTick);
  host_->resume("a", done.callback());
  run_for(5 * kTick);
  ASSERT_TRUE(submit("a", scene::Reset{}).ok());
  run_for(5 * kTick);
  const std::int64_t tick = status("a").tick;
  host_->stop();
  const Result<sheet::ReplayReport> report = sheet::replay(recorder_->recording());
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_EQ(report->ticks, tick);
}

}  // namespace
}  // namespace kerf::host
