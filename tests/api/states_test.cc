// Saved states over the API: names, answers, the list of cuts, recordings and what viewers see.
#include <cmath>
#include <cstring>
#include <future>
#include <memory>
#include <string>

#include "server/core/sheet/recording.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/reply_codec.h"
#include "tests/api/cuts_fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

class ApiStatesTest : public ApiCutsTest {
 protected:
  Result<v1::SavedState> save(const std::string& state, bool overwrite = false, const std::string& request_id = {}) {
    v1::SaveStateRequest request;
    request.set_parent("sheets/a");
    request.set_state_id(state);
    request.set_overwrite(overwrite);
    request.set_request_id(request_id);
    return call(&Api::save_state, request);
  }
  Result<v1::Sheet> restore(const std::string& state, const std::string& request_id = {}) {
    v1::RestoreStateRequest request;
    request.set_name("sheets/a/states/" + state);
    request.set_request_id(request_id);
    return call(&Api::restore_state, request);
  }
  std::vector<std::string> state_names() {
    v1::ListStatesRequest request;
    request.set_parent("sheets/a");
    std::vector<std::string> found;
    const v1::ListStatesResponse listed = call(&Api::list_states, request).value();
    for (const v1::SavedState& state : listed.states()) found.push_back(state.name());
    return found;
  }
  Result<v1::CutResult> cut(double y) { return call(&Api::create_cut, cut_request("sheets/a", y)); }

  // Compares with GetSheetState, in the quanta of the mirror's box.
  void expect_exact(const kerf::testing::FrameMirror& mirror) {
    v1::GetSheetStateRequest request;
    request.set_name("sheets/a");
    const v1::SheetState state = call(&Api::get_sheet_state, request).value();
    EXPECT_EQ(mirror.tick, state.tick());
    EXPECT_EQ(mirror.topology_version, state.topology_version());
    ASSERT_EQ(mirror.quantised.size() * 8, state.positions().size());
    for (std::size_t i = 0; i < mirror.quantised.size(); ++i) {
      double exact = 0.0;
      std::memcpy(&exact, state.positions().data() + 8 * i, 8);
      const double size = mirror.box_max[i % 3] - mirror.box_min[i % 3];
      ASSERT_EQ(mirror.quantised[i], std::floor((exact - mirror.box_min[i % 3]) * (65535.0 / size) + 0.5)) << i;
    }
    ASSERT_EQ(mirror.triangles.size() * 12, state.triangles().size());
    EXPECT_EQ(std::memcmp(mirror.triangles.data(), state.triangles().data(), state.triangles().size()), 0);
    EXPECT_EQ(std::memcmp(mirror.pieces.data(), state.pieces().data(), state.pieces().size()), 0);
  }
};

TEST_F(ApiStatesTest, AStateIsSavedListedRestoredAndDeleted) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(step(5).ok());
  run_for(3 * kTick);  // The sheet is paused.
  const v1::SavedState saved = save("before").value();
  EXPECT_EQ(saved.name(), "sheets/a/states/before");
  EXPECT_EQ(saved.tick(), 5);
  EXPECT_EQ(saved.scene_tick(), 5);
  EXPECT_EQ(saved.num_vertices(), 49);
  EXPECT_GT(saved.num_bytes(), 49 * 100);
  EXPECT_EQ(saved.state_hash(), get_sheet("sheets/a").state_hash());
  EXPECT_EQ(saved.continuation_hash().size(), 16U);
  EXPECT_NE(saved.continuation_hash(), saved.state_hash());
  EXPECT_EQ(saved.saved_unix_us(), clock_.unix_us());
  EXPECT_EQ(save("before").error().reason, "STATE_EXISTS");
  EXPECT_EQ(save("before").error().code, ErrorCode::kAlreadyExists);
  ASSERT_TRUE(cut(0.45).ok());
  ASSERT_TRUE(step(5).ok());
  ASSERT_TRUE(save("after").ok());
  EXPECT_EQ(state_names(), (std::vector<std::string>{"sheets/a/states/before", "sheets/a/states/after"}));
  const v1::Sheet back = restore("before").value();
  EXPECT_EQ(back.tick(), 5);
  EXPECT_EQ(back.pieces(), 1);
  EXPECT_EQ(back.state_hash(), saved.state_hash());
  EXPECT_EQ(restore("after").value().pieces(), 2) << "a later one can be restored from an earlier one";
  v1::DeleteStateRequest request;
  request.set_name("sheets/a/states/before");
  ASSERT_TRUE(call(&Api::delete_state, request).ok());
  EXPECT_EQ(state_names(), (std::vector<std::string>{"sheets/a/states/after"}));
  EXPECT_EQ(restore("before").error().reason, "STATE_NOT_FOUND");
  EXPECT_EQ(restore("before").error().field, "name");
}

TEST_F(ApiStatesTest, ARepeatedRequestDoesNothingMore) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::SavedState first = save("one", false, "save-1").value();
  ASSERT_TRUE(step(3).ok());
  EXPECT_EQ(save("one", false, "save-1").value().tick(), first.tick()) << "and not STATE_EXISTS";
  EXPECT_EQ(restore("one", "back-1").value().tick(), 0);
  ASSERT_TRUE(step(4).ok());
  EXPECT_EQ(restore("one", "back-1").value().tick(), 0);
  EXPECT_EQ(get_sheet("sheets/a").tick(), 4) << "it did not go back twice";
  EXPECT_EQ(restore("one", "back-2").value().tick(), 0);
}

TEST_F(ApiStatesTest, TheListOfCutsFollows) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(cut(0.3).ok());
  ASSERT_TRUE(cut(0.5).ok());
  ASSERT_TRUE(undo().ok());
  v1::CreateCutRequest later = cut_request("sheets/a", 0.7);
  later.set_at_tick(1000);
  ASSERT_TRUE(call(&Api::create_cut, later).ok());
  const v1::ListCutsResponse then = list();
  ASSERT_TRUE(save("one").ok());
  ASSERT_TRUE(cut(0.8).ok());
  ASSERT_EQ(names().size(), 2U);
  ASSERT_TRUE(restore("one").ok());
  EXPECT_EQ(list().DebugString(), then.DebugString());
  ASSERT_TRUE(redo().ok());
  EXPECT_EQ(names(), (std::vector<std::string>{"sheets/a/cuts/1", "sheets/a/cuts/2"})) << "one that was hidden then";
  v1::ResetSheetRequest reset;
  reset.set_name("sheets/a");
  ASSERT_TRUE(call(&Api::reset_sheet, reset).ok());
  EXPECT_TRUE(names().empty());
  ASSERT_TRUE(restore("one").ok());
  EXPECT_EQ(list().DebugString(), then.DebugString());
}

TEST_F(ApiStatesTest, ViewersSeeTheRestoredSheet) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Viewer viewer(*api_);
  viewer.start("sheets/a");
  host_->wait_idle();
  ASSERT_TRUE(viewer.drain());
  ASSERT_TRUE(cut(0.3).ok());
  ASSERT_TRUE(save("one").ok());
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(cut(0.5 + 0.1 * i).ok());
    run_for(5 * kTick);
    ASSERT_TRUE(viewer.drain());
  }
  const std::int64_t late = viewer.mirror.tick;
  v1::PauseSheetRequest pause;
  pause.set_name("sheets/a");
  ASSERT_TRUE(call(&Api::pause_sheet, pause).ok());
  ASSERT_TRUE(viewer.drain());
  ASSERT_TRUE(restore("one").ok());
  const auto frame = viewer.next();
  ASSERT_TRUE(frame && frame->has_frame());
  EXPECT_LT(frame->frame().tick(), late);
  EXPECT_EQ(frame->frame().base_tick(), -1);
  EXPECT_EQ(frame->frame().topology().base_version(), -1);
  EXPECT_FALSE(frame->frame().epoch().empty());
  EXPECT_EQ(frame->frame().stats().skipped(), 0);
  ASSERT_EQ(viewer.mirror.apply(frame->frame()), std::nullopt);
  viewer.acknowledge(viewer.mirror.sequence);
  expect_exact(viewer.mirror);
  // Another history with the same versions as the one that was left.
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(cut(0.45 + 0.1 * i).ok());
    ASSERT_TRUE(viewer.drain());
    expect_exact(viewer.mirror);
  }
  ASSERT_TRUE(step(2).ok());
  ASSERT_TRUE(viewer.drain());
  expect_exact(viewer.mirror);
  EXPECT_TRUE(viewer.failure().empty());
}

TEST_F(ApiStatesTest, AnEpochFromBeforeIsNotResumed) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(save("one").ok());
  const auto first_frame = [&](const std::string& epoch, std::int32_t version) {
    Viewer viewer(*api_);
    v1::WatchRequest request;
    request.mutable_start()->set_name("sheets/a");
    request.mutable_start()->set_epoch(epoch);
    request.mutable_start()->set_topology_version(version);
    viewer.session().on_request(request);
    host_->wait_idle();
    return viewer.next()->frame();
  };
  const v1::Frame before = first_frame("", -1);
  EXPECT_FALSE(first_frame(before.epoch(), before.topology_version()).has_topology()) << "it is resumed";
  ASSERT_TRUE(restore("one").ok());
  const v1::Frame after = first_frame(before.epoch(), before.topology_version());
  EXPECT_NE(after.epoch(), before.epoch());
  EXPECT_EQ(after.topology().base_version(), -1);
}

class ApiKeptStatesTest : public ApiStatesTest {
 protected:
  ApiKeptStatesTest() {
    host::HostOptions options = small_host();
    options.encode_tick = wire::encode_recorded_tick;
    api_.reset();
    host_ = std::make_unique<host::Host>(std::move(options), clock_, entropy_);
    make_api({}, nullptr);
  }
};

TEST_F(ApiKeptStatesTest, TheRecordingIsThatOfTheRunThatLedToTheSheet) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(cut(0.3).ok());
  ASSERT_TRUE(step(70).ok());
  ASSERT_TRUE(save("one").ok());
  ASSERT_TRUE(cut(0.5).ok());
  ASSERT_TRUE(step(10).ok());
  ASSERT_TRUE(restore("one").ok());
  ASSERT_TRUE(cut(0.7).ok());
  ASSERT_TRUE(step(5).ok());
  std::promise<Result<std::shared_ptr<const std::string>>> file;
  v1::GetSheetRecordingRequest request;
  request.set_name("sheets/a");
  api_->get_sheet_recording(request, [&](auto reply) { file.set_value(std::move(reply)); });
  const std::string bytes = *file.get_future().get().value();
  const wire::RecordingFile decoded = wire::decode_recording(bytes).value();
  ASSERT_FALSE(decoded.recording.entries.empty());
  EXPECT_EQ(decoded.recording.entries.back().tick, 75);
  const sheet::ReplayReport replayed = sheet::replay(decoded.recording).value();
  EXPECT_EQ(replayed.ticks, 75);
  EXPECT_FALSE(replayed.divergence.has_value());
  EXPECT_EQ(wire::encode_hash(decoded.recording.entries.back().state_hash), get_sheet("sheets/a").state_hash());
}

}  // namespace
}  // namespace kerf::api
