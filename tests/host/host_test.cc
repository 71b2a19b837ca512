#include "server/service/host/host.h"

#include <algorithm>
#include <atomic>
#include <future>

#include "server/core/mesh/triangle_mesh.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

TEST_F(HostTest, APausedSheetIsCutAtOnce) {
  create("a", at_50_hz(scenes::hanging(10)), true);
  Answers<CommandResult> answers;
  host_->submit("a", scenes::line_cut({-0.5, 0.5}, {1.5, 0.45}), answers.callback());
  host_->submit("a", scene::SetPins{}, answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 2U);
  EXPECT_EQ(answers.at(0)->reply.tick, 0);
  EXPECT_EQ(answers.at(0)->reply.cut->report.pieces, 2);
  EXPECT_EQ(status("a").tick, 0);
  EXPECT_EQ(status("a").pieces, 2);
  EXPECT_TRUE(status("a").pinned_vertices.empty());
  EXPECT_EQ(status("a").state_hash, answers.at(1)->reply.state_hash);
  EXPECT_EQ(host_->metrics().ticks, 0);
  EXPECT_EQ(host_->metrics().cuts, 1);
  EXPECT_EQ(host_->metrics().cut_duration.total, 1U);
}

TEST_F(HostTest, ARunningSheetIsCutAtTheNextTick) {
  create("a", at_50_hz(scenes::hanging(10)));
  Answers<CommandResult> answers;
  host_->submit("a", scenes::line_cut({-0.5, 0.5}, {1.5, 0.45}), answers.callback());
  host_->wait_idle();
  EXPECT_EQ(answers.count(), 0U);
  EXPECT_EQ(host_->metrics().queued_commands, 1);
  run_for(kTick);
  ASSERT_EQ(answers.count(), 1U);
  EXPECT_EQ(answers.at(0)->reply.tick, 2);
  EXPECT_NEAR(answers.at(0)->timings.queued_us, 20'000.0, 1.0);
  EXPECT_EQ(host_->metrics().queued_commands, 0);
}

TEST_F(HostTest, TheQueueIsBounded) {
  create("a", small_sheet());
  Answers<CommandResult> answers;
  for (int i = 0; i < 66; ++i) host_->submit("a", scene::SetGravity{{0, 0, -1.0}}, answers.callback());
  ASSERT_EQ(answers.count(), 2U);  // the 65th and 66th, at once
  EXPECT_EQ(answers.reason(0), "QUEUE_FULL");
  EXPECT_EQ(answers.at(1).error().code, ErrorCode::kResourceExhausted);
  run_for(kTick);
  EXPECT_EQ(answers.count(), 66U);
  EXPECT_EQ(answers.reason(65), "done");
  EXPECT_EQ(host_->metrics().commands, 64);
  EXPECT_EQ(host_->metrics().commands_refused, 2);
}

TEST_F(HostTest, AGrabIsReleasedThoughTheQueueIsFull) {
  create("a", small_sheet());
  ASSERT_TRUE(submit("a", scene::Grab{"hand", 0, std::nullopt, 0.0}).ok());
  Answers<CommandResult> answers;
  for (int i = 0; i < 65; ++i) host_->submit("a", scene::SetGravity{{0, 0, -1.0}}, answers.callback());
  ASSERT_EQ(answers.reason(0), "QUEUE_FULL");
  host_->release_grab("a", "hand");
  host_->release_grab("nobody", "hand");
  EXPECT_EQ(host_->metrics().queued_commands, 65);
  run_for(kTick);
  EXPECT_EQ(host_->metrics().queued_commands, 0);
  EXPECT_EQ(submit("a", scene::Release{"hand"}).error().reason, "GRAB_NOT_FOUND");
}

TEST_F(HostTest, AnUnknownSheetIsRefusedAtOnceAndWhatTheSheetRefusesAtTheTick) {
  create("a", small_sheet());
  Answers<CommandResult> answers;
  host_->submit("nobody", scene::Reset{}, answers.callback());
  EXPECT_EQ(answers.reason(0), "SHEET_NOT_FOUND");
  EXPECT_EQ(submit("a", scenes::circle_cut({0, 0}, -1.0)).error().reason, "RADIUS_NOT_POSITIVE");
  EXPECT_EQ(submit("a", scene::Release{"x"}).error().reason, "GRAB_NOT_FOUND");
  EXPECT_EQ(host_->metrics().commands_refused, 3);
}

TEST_F(HostTest, ASheetAtRestCostsNothingUntilTouched) {
  create("a", at_50_hz(scenes::lying_on_floor(6)));
  run_for(400 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  EXPECT_TRUE(status("a").stats.sleeping);
  EXPECT_EQ(clock_.num_timers(), 0U);
  const HostMetrics asleep = host_->metrics();
  EXPECT_EQ(asleep.sleeping_sheets, 1);
  EXPECT_EQ(asleep.running_sheets, 0);
  EXPECT_EQ(asleep.sleeps, 1);
  run_for(1000 * kTick);
  EXPECT_EQ(host_->metrics().ticks, asleep.ticks);
  EXPECT_EQ(host_->metrics().contact_phases, asleep.contact_phases);

  // A watcher sees it without waking it.
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> added;
  host_->add_sink("a", sink, added.callback());
  host_->wait_idle();
  ASSERT_EQ(sink->snapshots().size(), 1U);
  EXPECT_TRUE(sink->snapshots()[0]->stats.sleeping);
  EXPECT_EQ(host_->metrics().ticks, asleep.ticks);

  const Result<CommandResult> reply = submit("a", scene::Grab{"hand", 0, std::nullopt, 0.0});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(status("a").run_state, RunState::kRunning);
  EXPECT_EQ(status("a").stats.slipped_s, 0.0);
  EXPECT_LT(reply->timings.queued_us, 1.0);  // woken at once
  EXPECT_EQ(host_->metrics().ticks, asleep.ticks + 3);
}

// Two squares, one above the other on a floor.
scene::SheetConfig two_layers() {
  scene::ArraySource source;
  source.material_positions.resize(2, 8);
  source.material_positions << 0, 1, 1, 0, 2, 3, 3, 2, 0, 0, 1, 1, 0, 0, 1, 1;
  source.positions.resize(3, 8);
  source.positions << 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0;
  source.triangles.resize(3, 4);
  source.triangles << 0, 0, 4, 4, 1, 2, 5, 6, 2, 3, 6, 7;
  scene::SheetConfig config = scenes::lying_on_floor(4);
  const double thickness = config.material.thickness;
  for (Eigen::Index v = 0; v < 8; ++v) source.positions(2, v) = v < 4 ? 0.5 * thickness : 1.5 * thickness;
  config.mesh = source;
  config.self_contact.is_on = true;
  return config;
}

TEST_F(HostTest, LayersThatLieOnEachOtherCostNothingAsleep) {
  create("a", at_50_hz(two_layers()));
  run_for(50 * kTick);
  EXPECT_GT(host_->metrics().self_contact.contacts, 0);
  run_for(950 * kTick);
  ASSERT_EQ(status("a").run_state, RunState::kSleeping);
  const HostMetrics asleep = host_->metrics();
  run_for(1000 * kTick);
  EXPECT_EQ(host_->metrics().self_contact.phases, asleep.self_contact.phases);
  EXPECT_EQ(host_->metrics().ticks, asleep.ticks);
  ASSERT_TRUE(submit("a", scene::SetWind{{{1.0, 0.0, 0.0}, 1.2, 1.0}}).ok());
  EXPECT_GT(host_->metrics().self_contact.phases, asleep.self_contact.phases);
}

TEST_F(HostTest, UnwatchedNoSnapshotIsBuilt) {
  create("a", small_sheet());
  run_for(10 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, 0);
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> done;
  host_->add_sink("a", sink, done.callback());
  run_for(3 * kTick);
  EXPECT_EQ(sink->snapshots().size(), 4U);  // the present one, then one a tick
  EXPECT_EQ(host_->metrics().snapshots, 4);
  EXPECT_EQ(host_->metrics().sinks, 1);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(sink->snapshots()[i]->tick, sink->snapshots()[i - 1]->tick + 1);
  }
  sink->want(false);
  run_for(5 * kTick);
  EXPECT_EQ(host_->metrics().snapshots, 4);
  sink->want(true);
  host_->remove_sink("a", sink, done.callback());
  run_for(5 * kTick);
  EXPECT_EQ(sink->snapshots().size(), 4U);
  EXPECT_EQ(host_->metrics().sinks, 0);
  EXPECT_TRUE(sink->ends().empty());
}

TEST_F(HostTest, SinksOfOneSheetShareASnapshot) {
  create("a", small_sheet(), true);
  const auto first = std::make_shared<RecordingSnapshots>();
  const auto second = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> done;
  host_->add_sink("a", first, done.callback());
  host_->add_sink("a", second, done.callback());
  Answers<SheetStatus> stepped;
  host_->step("a", 1, stepped.callback());
  host_->wait_idle();
  ASSERT_EQ(first->snapshots().size(), 2U);
  EXPECT_EQ(first->snapshots().back(), second->snapshots().back());
}

TEST_F(HostTest, DeleteEndsSinksAndAnswersWhatWaits) {
  create("a", small_sheet());
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> done;
  host_->add_sink("a", sink, done.callback());
  Answers<CommandResult> waiting;
  host_->submit("a", scene::Reset{}, waiting.callback());
  host_->delete_sheet("a", done.callback());
  host_->wait_idle();
  EXPECT_EQ(done.count(), 2U);
  EXPECT_EQ(sink->ends(), std::vector<sheet::SinkEnd>{sheet::SinkEnd::kSheetDeleted});
  ASSERT_EQ(waiting.count(), 1U);
  EXPECT_EQ(waiting.reason(0), "SHEET_DELETED");
  EXPECT_EQ(waiting.at(0).error().code, ErrorCode::kAborted);
  EXPECT_TRUE(host_->list().empty());
  EXPECT_EQ(clock_.num_timers(), 1U) << "that which gives memory back";
  run_for(3s);
  EXPECT_EQ(clock_.num_timers(), 0U);
  const HostMetrics metrics = host_->metrics();
  EXPECT_EQ(metrics.sheets + metrics.running_sheets + metrics.sinks + metrics.queued_commands, 0);
  host_->delete_sheet("a", done.callback());
  EXPECT_EQ(done.reason(2), "SHEET_NOT_FOUND");
  EXPECT_EQ(create("a", small_sheet()).tick, 0);  // the name is free again
}

TEST_F(HostTest, ANameIsFreeOnceItsSheetIsClosed) {
  create("a", small_sheet(), true);
  std::promise<void> release;
  host_->inspect(
      "a", [released = release.get_future().share()](const sheet::Sheet&) { released.wait(); }, [](const Status&) {});
  Answers<Nothing> deleted;
  Answers<CommandResult> waiting;
  std::atomic<bool> closed = false;
  host_->submit("a", scene::Reset{}, waiting.callback());
  host_->delete_sheet("a", deleted.callback(), [&] { closed = waiting.count() == 1 && deleted.count() == 1; });
  Answers<SheetStatus> created;
  host_->create_sheet("a", small_sheet(), true, created.callback());
  EXPECT_EQ(created.reason(0), "SHEET_EXISTS");
  host_->delete_sheet("a", deleted.callback());
  EXPECT_EQ(deleted.reason(0), "SHEET_NOT_FOUND");
  EXPECT_TRUE(host_->list().empty());
  release.set_value();
  host_->wait_idle();
  EXPECT_EQ(deleted.reason(1), "done");
  EXPECT_TRUE(closed) << "after the last answer of the sheet, before its own";
  EXPECT_EQ(create("a", small_sheet()).id, "a");
}

TEST_F(HostTest, StopAnswersEverythingAndRefusesWhatComesAfter) {
  create("a", small_sheet());
  create("b", small_sheet(), true);
  const auto sink = std::make_shared<RecordingSnapshots>();
  Answers<Nothing> done;
  host_->add_sink("a", sink, done.callback());
  Answers<CommandResult> waiting;
  host_->submit("a", scene::Reset{}, waiting.callback());
  Answers<SheetStatus> stepped;
  host_->step("b", 100'000, stepped.callback());
  host_->create_sheet("c", small_sheet(), false, stepped.callback());
  host_->stop();
  host_->stop();
  EXPECT_EQ(waiting.reason(0), "HOST_STOPPING");
  EXPECT_EQ(sink->ends(), std::vector<sheet::SinkEnd>{sheet::SinkEnd::kHostStopping});
  ASSERT_EQ(stepped.count(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string reason = stepped.reason(i);  // building c may have been quicker than stop()
    EXPECT_TRUE(reason == "HOST_STOPPING" || reason == "done") << reason;
  }
  Answers<SheetStatus> after;
  host_->create_sheet("d", small_sheet(), false, after.callback());
  host_->status("a", after.callback());
  host_->pause("a", after.callback());
  host_->submit("a", scene::Reset{}, waiting.callback());
  ASSERT_EQ(after.count(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(after.at(i).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(waiting.at(1).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(host_->metrics().sheets, 0);
}

TEST_F(HostTest, NamesAreCheckedUniqueSortedAndMadeUpWhereNoneIsGiven) {
  create("b", small_sheet());
  create("a", small_sheet());
  Answers<SheetStatus> answers;
  host_->create_sheet("b", small_sheet(), false, answers.callback());
  EXPECT_EQ(answers.reason(0), "SHEET_EXISTS");
  host_->create_sheet("B", small_sheet(), false, answers.callback());
  EXPECT_EQ(answers.at(1).error().field, "sheet_id");
  scene::SheetConfig named = small_sheet();
  named.sheet_id = "from-config";
  EXPECT_EQ(create("", named).id, "from-config");
  const std::string made_up = create("", small_sheet()).id;
  EXPECT_TRUE(scene::is_valid_sheet_id(made_up)) << made_up;
  EXPECT_EQ(host_->list(), (std::vector<std::string>{"a", "b", "from-config", made_up}));
  const std::vector<SheetStatus> found = host_->statuses({"b", "nobody", "a"});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, "b");
  EXPECT_EQ(found[1].id, "a");
}

TEST_F(HostTest, ABadConfigLeavesNoTrace) {
  scene::SheetConfig config = small_sheet();
  config.gravity.x() = 2e4;
  Answers<SheetStatus> answers;
  host_->create_sheet("a", config, false, answers.callback());
  host_->wait_idle();
  EXPECT_EQ(answers.at(0).error().field, "gravity_mps2.x");
  EXPECT_TRUE(host_->list().empty());
  EXPECT_EQ(create("a", small_sheet()).id, "a");
}

TEST_F(HostTest, InspectSeesTheSheetBetweenTicks) {
  create("a", small_sheet(), true);
  Answers<Nothing> done;
  std::int32_t vertices = 0;
  host_->inspect(
      "a", [&](const sheet::Sheet& sheet) { vertices = sheet.mesh().num_vertices(); }, done.callback());
  host_->wait_idle();
  EXPECT_EQ(vertices, 25);
  EXPECT_EQ(done.reason(0), "done");
}

TEST_F(HostTest, GaugesFollowTheRunStates) {
  create("a", small_sheet());
  create("b", small_sheet(), true);
  create("c", small_sheet());
  Answers<SheetStatus> done;
  host_->pause("a", done.callback());
  host_->wait_idle();
  const HostMetrics metrics = host_->metrics();
  EXPECT_EQ(metrics.sheets, 3);
  EXPECT_EQ(metrics.running_sheets, 1);
  EXPECT_EQ(metrics.paused_sheets, 2);
}

// One triangle passes through another, far from its corners, and nothing moves.
scene::SheetConfig pierced() {
  scene::ArraySource source;
  source.material_positions.resize(2, 6);
  source.material_positions << 0, 1, 0, 2, 3, 2, 0, 0, 1, 0, 0, 1;
  source.positions.resize(3, 6);
  source.positions << 0, 1, 0, 0.2, 0.2, 1.2, 0, 0, 1, 0.2, 0.2, 0.2, 0, 0, 0, -0.5, 0.5, -0.5;
  source.triangles.resize(3, 2);
  source.triangles << 0, 3, 1, 4, 2, 5;
  scene::SheetConfig config = scenes::hanging(4);
  config.mesh = source;
  config.pins.clear();
  config.gravity.setZero();
  return config;
}

TEST_F(HostTest, SelfContactIsCountedOverAllSheets) {
  create("a", pierced(), true);
  create("b", pierced(), true);
  Answers<SheetStatus> stepped;
  host_->step("a", 3, stepped.callback());
  host_->wait_idle();
  EXPECT_EQ(status("a").stats.intersections, 0) << "it is off";
  EXPECT_EQ(host_->metrics().self_contact.phases, 0);
  for (const char* id : {"a", "b"}) {
    ASSERT_TRUE(submit(id, scene::SetSelfContact{true, 0.5, {}}).ok());
    EXPECT_EQ(status(id).self_contact, (scene::SelfContact{true, 0.5, {}}));
    host_->step(id, 2, stepped.callback());
    host_->wait_idle();
    EXPECT_EQ(status(id).stats.intersections, 1);
  }
  const fem::SelfContactStats counted = host_->metrics().self_contact;
  EXPECT_EQ(counted.intersections, 4);
  EXPECT_GE(counted.phases, 4);
  EXPECT_GE(counted.searches, 4);
}

}  // namespace
}  // namespace kerf::host
