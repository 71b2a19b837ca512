#include "server/service/offline/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "server/service/offline/files.h"
#include "server/service/offline/replay.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/scene_codec.h"
#include "tests/support/memory_disk.h"
#include "tests/support/paths.h"
#include "tests/support/self_contact_scenes.h"

namespace kerf::offline {
namespace {

// Returns a small cloth that is cut at tick 3 of 6.
scene::SheetConfig falling_cloth() {
  test::MemoryDisk disk;
  const std::string scene = R"({
    "sheet_id": "cloth", "ticks": 6, "grid": {"columns": 5, "rows": 5, "width_m": 1, "height_m": 1},
    "pins": [{"edge": "TOP"}],
    "commands": [{"tick": 3, "command": {"cut": {"curve": {"circle": {"center": {"x": 0.5, "y": 0.5}, "radius_m": 0.2}}}}}]})";
  EXPECT_TRUE(disk.write_file("cloth.json", scene).ok());
  Result<scene::SheetConfig> config = read_scene(disk, "cloth.json");
  EXPECT_TRUE(config.ok()) << config.error().message;
  return std::move(config).value();
}

TEST(OfflineRun, DescribesTheEndOfAScene) {
  const Result<SceneRun> run = run_scene(falling_cloth(), {});
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_EQ(run->result.scene(), "cloth");
  EXPECT_EQ(run->result.ticks(), 6);
  EXPECT_EQ(run->result.pieces(), 2);
  ASSERT_EQ(run->result.cuts_size(), 1);
  EXPECT_EQ(run->result.cuts(0).status(), v1::CutResult::APPLIED);
  EXPECT_GT(run->result.cuts(0).cut_us(), 0.0);
  EXPECT_GT(run->result.tick_times().median_us(), 0.0);
  EXPECT_NEAR(run->result.simulated_s(), 0.1, 1e-12);
  EXPECT_TRUE(run->recording.empty());
}

TEST(OfflineRun, IsTheSameEachTimeAndAsLongAsRequested) {
  const auto hash = [](std::int64_t ticks) {
    return run_scene(falling_cloth(), {.ticks = ticks})->result.state_hash();
  };
  EXPECT_EQ(hash(0), hash(6));
  EXPECT_NE(hash(6), hash(7));
}

TEST(OfflineRun, ReportsItsProgressAndEndsEarlyIfAsked) {
  std::vector<double> done;
  ASSERT_TRUE(run_scene(falling_cloth(), {.watch =
                                              [&done](const analysis::Progress& progress) {
                                                done.push_back(progress.done);
                                                return true;
                                              }})
                  .ok());
  ASSERT_FALSE(done.empty());
  EXPECT_EQ(done.back(), 1.0);
  const Result<SceneRun> ended = run_scene(falling_cloth(), {.watch = [](const auto&) { return false; }});
  EXPECT_TRUE(!ended.ok() || ended->result.ticks() < 6);
}

TEST(OfflineRun, RecordsDynamicScenesOnly) {
  scene::SheetConfig config = falling_cloth();
  config.commands.clear();
  config.analysis = scene::StaticAnalysis{};
  EXPECT_EQ(run_scene(config, {.record = true}).error().reason, "RECORDING_DYNAMIC_ONLY");
}

class OfflineReplay : public testing::Test {
 protected:
  void write(const std::string& bytes) { ASSERT_TRUE(disk_.write_file("cloth.rec", bytes).ok()); }
  const SceneRun run_ = run_scene(falling_cloth(), {.record = true}).value();
  test::MemoryDisk disk_;
};

TEST_F(OfflineReplay, OfARecordingIsIdentical) {
  write(run_.recording);
  std::size_t entries = 0;
  const Result<ReplayReport> report = replay(disk_, "cloth.rec", [&entries](std::size_t count) { entries = count; });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_EQ(report->ticks, 6);
  EXPECT_EQ(report->torn_bytes, 0);
  EXPECT_EQ(report->state_hash, run_.result.state_hash());
  EXPECT_EQ(report->recorded_by, report->replayed_by);
  EXPECT_EQ(entries, 6U);
}

// Recorded by a build whose automatic integrator took implicit Euler for this sheet. Every hash must come out again,
// while a new scene of the same sheet is stepped otherwise.
TEST_F(OfflineReplay, OfASheetBeforeTheSecondChoiceOfIntegratorsIsIdentical) {
  std::ifstream in(test::source_path("tests/data/recordings/before_second_choice.kerfrec"), std::ios::binary);
  std::stringstream content;
  content << in.rdbuf();
  write(content.str());
  const Result<ReplayReport> report = replay(disk_, "cloth.rec");
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_EQ(report->ticks, 20);

  scene::SheetConfig config = wire::decode_recording(content.str())->recording.config;
  EXPECT_EQ(config.integrator.choice, scene::kFirstChoice);
  const auto integrator = [&config] { return run_scene(config, {.ticks = 20})->result.integrator(); };
  EXPECT_THAT(integrator(), testing::HasSubstr("implicit Euler"));
  const v1::Scene message = to_message(config);
  config = wire::decode_scene(message).value();
  EXPECT_EQ(config.integrator.choice, scene::kNewestChoice);
  EXPECT_THAT(integrator(), testing::HasSubstr("SDIRK2"));
}

TEST_F(OfflineReplay, OfASheetThatTouchesItselfIsIdentical) {
  scene::SheetConfig config = scenes::folded_twice(12);
  config.ticks = 30;
  const std::string hash_without = run_scene(config, {})->result.state_hash();
  config.self_contact = {true, 0.5};
  const Result<SceneRun> run = run_scene(config, {.record = true});
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_NE(run->result.state_hash(), hash_without) << "its layers fall on one another";
  EXPECT_GT(run->result.self_contact().contacts(), 0);
  write(run->recording);
  EXPECT_EQ(wire::decode_recording(run->recording)->recording.config.self_contact, config.self_contact);
  const Result<ReplayReport> report = replay(disk_, "cloth.rec");
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->divergence.has_value());
  EXPECT_EQ(report->ticks, 30);
  EXPECT_EQ(report->state_hash, run->result.state_hash());
}

TEST(OfflineRun, CountsOfSelfContactAreThoseOfAllTicksAndAbsentWithoutIt) {
  scene::SheetConfig config = scenes::cut_in_the_pile(12);
  config.ticks = 60;
  EXPECT_FALSE(run_scene(config, {})->result.has_self_contact());
  config.self_contact.is_on = true;
  sheet::Sheet sheet = sheet::Sheet::create(config).value();
  fem::SelfContactStats sum;
  for (int i = 0; i < 60; ++i) sum += sheet.step({}).stats.self_contact;
  const Result<SceneRun> run = run_scene(config, {});
  ASSERT_TRUE(run.ok()) << run.error().message;
  const v1::SelfContactCounts& counts = run->result.self_contact();
  EXPECT_EQ(counts.phases(), sum.phases);
  EXPECT_EQ(counts.searches(), sum.searches);
  EXPECT_EQ(counts.contacts(), sum.contacts);
  EXPECT_EQ(counts.repairs(), sum.repairs);
  EXPECT_EQ(counts.zones(), sum.zones);
  EXPECT_EQ(counts.unsettled(), sum.unsettled);
  EXPECT_EQ(counts.intersections(), sum.intersections);
  EXPECT_GT(counts.contacts(), counts.phases());
  // It counts where a command turns it on, too.
  config.self_contact.is_on = false;
  config.commands.push_back({50, scene::SetSelfContact{true, {}, {}}});
  const Result<SceneRun> later = run_scene(config, {});
  ASSERT_TRUE(later.ok()) << later.error().message;
  EXPECT_GT(later->result.self_contact().phases(), 0);
  EXPECT_LT(later->result.self_contact().phases(), counts.phases());
}

TEST_F(OfflineReplay, LeavesOutATornEntry) {
  write(run_.recording.substr(0, run_.recording.size() - 3));
  const Result<ReplayReport> report = replay(disk_, "cloth.rec");
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->ticks, 5);
  EXPECT_GT(report->torn_bytes, 0);
}

TEST_F(OfflineReplay, NamesTheFirstTickThatDiffers) {
  wire::RecordingFile file = wire::decode_recording(run_.recording).value();
  file.recording.entries[3].state_hash ^= 1;
  std::string bytes = wire::encode_recording_header(file.recording.config, "another build");
  for (const sheet::RecordedTick& entry : file.recording.entries) bytes += wire::encode_recorded_tick(entry);
  write(bytes);
  const Result<ReplayReport> report = replay(disk_, "cloth.rec");
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_TRUE(report->divergence.has_value());
  EXPECT_EQ(report->divergence->tick, 4);
  EXPECT_NE(report->divergence->recorded_hash, report->divergence->replayed_hash);
  EXPECT_EQ(report->recorded_by, "another build");
}

TEST_F(OfflineReplay, RefusesWhatIsNoRecording) {
  EXPECT_EQ(replay(disk_, "cloth.rec").error().reason, "FILE_NOT_FOUND");
  write("not a recording");
  EXPECT_EQ(replay(disk_, "cloth.rec").error().code, ErrorCode::kDataLoss);
}

}  // namespace
}  // namespace kerf::offline
