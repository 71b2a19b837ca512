// Recordings of live sheets, and files that come in parts.
#include <future>
#include <memory>
#include <string>

#include "server/core/sheet/recording.h"
#include "server/service/api/upload.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/scene_codec.h"
#include "tests/api/fixture.h"
#include "tests/support/self_contact_scenes.h"

namespace kerf::api {
namespace {

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

class ApiFilesTest : public ApiTest {
 protected:
  static host::HostOptions keeping() {
    host::HostOptions options = small_host();
    options.encode_tick = wire::encode_recorded_tick;
    return options;
  }
  ApiFilesTest() : ApiTest(keeping()) {
    Limits limits;
    limits.max_uploading_bytes = 1000;
    make_api(limits, nullptr);
  }

  // Blocks until the file worker, and a sheet's strand, have replied.
  template <typename T>
  static Result<T> wait(const std::function<void(Reply<T>)>& call) {
    std::promise<Result<T>> promise;
    call([&promise](Result<T> reply) { promise.set_value(std::move(reply)); });
    return promise.get_future().get();
  }
  Result<std::shared_ptr<const std::string>> recording(const std::string& name) {
    v1::GetSheetRecordingRequest request;
    request.set_name(name);
    return wait<std::shared_ptr<const std::string>>([&](auto reply) { api_->get_sheet_recording(request, reply); });
  }
  static Result<v1::Sheet> finish(Upload& upload) {
    return wait<v1::Sheet>([&](auto reply) { upload.finish(reply); });
  }
  static v1::SheetUpload obj_upload(const std::string& id, std::int64_t num_bytes) {
    v1::SheetUpload start;
    start.set_num_bytes(num_bytes);
    start.mutable_sheet()->set_sheet_id(id);
    start.mutable_sheet()->set_paused(true);
    start.mutable_sheet()->mutable_scene()->mutable_obj();
    return start;
  }
  static v1::RecordingUpload recording_upload(const std::string& id, const std::string& file) {
    v1::RecordingUpload start;
    start.set_sheet_id(id);
    start.set_paused(true);
    start.set_num_bytes(static_cast<std::int64_t>(file.size()));
    return start;
  }
};

TEST_F(ApiFilesTest, ASheetThatTouchesItselfIsShownRecordedAndPlayedSo) {
  make_api({}, nullptr);
  scene::SheetConfig config = scenes::falls_on_edge(12);
  config.self_contact = {true, 0.5};
  v1::CreateSheetRequest request;
  request.set_sheet_id("a");
  *request.mutable_scene() = wire::encode_scene(config);
  request.mutable_scene()->mutable_integrator()->set_kind(v1::Integrator::AUTOMATIC);
  ASSERT_TRUE(call(&Api::create_sheet, request).ok());
  run_for(30 * kTick);
  const v1::Sheet live = get_sheet("sheets/a");
  EXPECT_GE(live.tick(), 30);
  EXPECT_EQ(live.scene().self_contact().mode(), v1::SelfContact::ON);
  EXPECT_EQ(live.scene().self_contact().friction(), 0.5);
  EXPECT_NE(live.integrator().find("explicit, preferred for self-contact"), std::string::npos) << live.integrator();
  v1::SetSheetSelfContactRequest turn_off;
  turn_off.set_name("sheets/a");
  turn_off.mutable_set_self_contact()->set_mode(v1::SelfContact::OFF);
  ASSERT_TRUE(call(&Api::set_sheet_self_contact, turn_off).ok());
  run_for(5 * kTick);
  const Result<std::shared_ptr<const std::string>> file = recording("sheets/a");
  ASSERT_TRUE(file.ok()) << file.error().message;
  const Result<wire::RecordingFile> decoded = wire::decode_recording(**file);
  ASSERT_TRUE(decoded.ok()) << decoded.error().message;
  EXPECT_EQ(decoded->recording.config.self_contact, config.self_contact);
  const Result<sheet::ReplayReport> report = sheet::replay(decoded->recording);
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->divergence);
  EXPECT_GE(report->ticks, 30);
}

TEST_F(ApiFilesTest, ARecordingTakenMidRunIsPlayedToTheSameBits) {
  make_api({}, nullptr);
  ASSERT_TRUE(create_sheet("a", false).ok());
  run_for(70 * kTick);
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  run_for(5 * kTick);
  const v1::Sheet live = get_sheet("sheets/a");
  const Result<std::shared_ptr<const std::string>> file = recording("sheets/a");
  ASSERT_TRUE(file.ok()) << file.error().message;
  const Result<wire::RecordingFile> decoded = wire::decode_recording(**file);
  ASSERT_TRUE(decoded.ok()) << decoded.error().message;
  EXPECT_EQ(decoded->build, wire::build_name());
  const Result<sheet::ReplayReport> report = sheet::replay(decoded->recording);
  ASSERT_TRUE(report.ok());
  EXPECT_FALSE(report->divergence);
  EXPECT_EQ(report->ticks, live.tick());

  const auto upload = api_->replay_recording(recording_upload("b", **file));
  ASSERT_TRUE(upload.ok()) << upload.error().message;
  ASSERT_TRUE((*upload)->append((*file)->substr(0, 100)).ok());
  ASSERT_TRUE((*upload)->append((*file)->substr(100)).ok());
  const Result<v1::Sheet> made = finish(**upload);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->replay().state(), v1::Replay::PLAYING);
  EXPECT_EQ(made->replay().end_tick(), live.tick());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/b","ticks":100000})").ok());
  const v1::Sheet played = get_sheet("sheets/b");
  EXPECT_EQ(played.replay().state(), v1::Replay::DONE);
  EXPECT_EQ(played.state_hash(), live.state_hash());
  EXPECT_FALSE(live.has_replay());
  v1::ListCutsRequest cuts;
  cuts.set_parent("sheets/b");
  EXPECT_EQ(call(&Api::list_cuts, cuts)->cuts_size(), 1);
}

TEST_F(ApiFilesTest, RecordingsOnTheirWayAreLimited) {
  Limits limits;
  limits.max_recordings_sent = 2;
  make_api(limits, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  const std::shared_ptr<const std::string> first = *recording("sheets/a");
  std::shared_ptr<const std::string> second = *recording("sheets/a");
  const auto third = recording("sheets/a");
  ASSERT_FALSE(third.ok());
  EXPECT_EQ(third.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(third.error().reason, "TOO_MANY_RECORDINGS");
  second.reset();
  // Retries: the file worker frees refused work only after it has called the replies.
  Result<std::shared_ptr<const std::string>> next = recording("sheets/a");
  while (!next.ok()) next = recording("sheets/a");
  EXPECT_EQ(**next, *first);
}

TEST_F(ApiFilesTest, ARecordingHasNoMoreTicksAndCommandsThanMayBe) {
  for (const std::int64_t most : {3, 2}) {
    Limits limits;
    limits.max_recorded_ticks = most;
    limits.max_recorded_parts = most;
    make_api(limits, nullptr);
    const std::string name = "from" + std::to_string(most);
    ASSERT_TRUE(create_sheet(name, true).ok());
    for (int i = 0; i < 3; ++i)
      ASSERT_TRUE(call_json("/kerf.v1.CutService/CreateCut",
                            R"({"parent":"sheets/)" + name +
                                R"(","cut":{"curve":{"circle":{"center":{"x":0.5,"y":0.5},"radius_m":0.)" +
                                std::to_string(i + 1) + "}}}}")
                      .ok());
    const std::string file = **recording("sheets/" + name);
    const auto upload = api_->replay_recording(recording_upload("of" + std::to_string(most), file));
    ASSERT_TRUE((*upload)->append(file).ok());
    const Result<v1::Sheet> made = finish(**upload);
    EXPECT_EQ(made.ok() ? "made" : made.error().reason, most == 3 ? "made" : "RECORDING_TOO_LARGE");
  }
}

TEST_F(ApiFilesTest, ATornRecordingIsPlayedToItsLastWholeEntry) {
  make_api({}, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":64})").ok());
  const std::string hash = get_sheet("sheets/a").state_hash();
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":3})").ok());
  const std::string file = **recording("sheets/a");
  const std::string torn = file.substr(0, file.size() - 3);
  const auto upload = api_->replay_recording(recording_upload("b", torn));
  ASSERT_TRUE((*upload)->append(torn).ok());
  const Result<v1::Sheet> made = finish(**upload);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->replay().end_tick(), 64);
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/b","ticks":100})").ok());
  const v1::Sheet played = get_sheet("sheets/b");
  EXPECT_EQ(played.replay().state(), v1::Replay::DONE);
  EXPECT_EQ(played.state_hash(), hash);
  const std::int64_t entry_bytes = static_cast<std::int64_t>(wire::encode_recorded_tick({67, {}, 1}).size());
  EXPECT_EQ(played.replay().torn_bytes(), entry_bytes - 3);
}

TEST_F(ApiFilesTest, ADamagedRecordingMakesNoSheet) {
  make_api({}, nullptr);
  ASSERT_TRUE(create_sheet("a", true).ok());
  std::string damaged = **recording("sheets/a");
  damaged[damaged.size() / 2] ^= 1;
  const auto upload = api_->replay_recording(recording_upload("b", damaged));
  ASSERT_TRUE((*upload)->append(damaged).ok());
  const Result<v1::Sheet> made = finish(**upload);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(made.error().reason, "RECORDING_DAMAGED");
  EXPECT_EQ(host_->list(), std::vector<std::string>{"a"});
  EXPECT_EQ(recording("sheets/nobody").error().field, "name");
  EXPECT_EQ(recording("nobody").error().code, ErrorCode::kInvalidArgument);
}

TEST_F(ApiFilesTest, AnUploadEndsAtTheLengthThatWasTold) {
  const std::string file = kTriangle;
  const auto size = static_cast<std::int64_t>(file.size());
  const auto upload = api_->upload_sheet(obj_upload("a", size));
  ASSERT_TRUE(upload.ok()) << upload.error().message;
  for (const char byte : file) ASSERT_TRUE((*upload)->append(std::string(1, byte)).ok());
  const Result<v1::Sheet> made = finish(**upload);
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->num_vertices(), 3);

  const auto fewer = api_->upload_sheet(obj_upload("b", size + 1));
  ASSERT_TRUE((*fewer)->append(file).ok());
  EXPECT_EQ(finish(**fewer).error().reason, "UPLOAD_LENGTH");
  const auto more = api_->upload_sheet(obj_upload("b", size - 1));
  EXPECT_EQ((*more)->append(file).error().reason, "UPLOAD_LENGTH");
  EXPECT_EQ(host_->list(), std::vector<std::string>{"a"});
}

TEST_F(ApiFilesTest, WhatIsTooLongIsRefusedBeforeAByteComes) {
  Limits limits;
  limits.max_uploading_bytes = std::int64_t{1} << 40;
  make_api(limits, nullptr);
  EXPECT_TRUE(api_->upload_sheet(obj_upload("a", 64 << 20)).ok());
  for (const std::int64_t bytes : {std::int64_t{-1}, std::int64_t{0}, (std::int64_t{64} << 20) + 1}) {
    const auto refused = api_->upload_sheet(obj_upload("a", bytes));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().field, "start.num_bytes") << bytes;
  }
  v1::RecordingUpload start;
  start.set_num_bytes(128 << 20);
  EXPECT_TRUE(api_->replay_recording(start).ok());
  start.set_num_bytes((128 << 20) + 1);
  EXPECT_EQ(api_->replay_recording(start).error().field, "start.num_bytes");
}

TEST_F(ApiFilesTest, UploadsUnderWayAreLimitedTogether) {
  auto first = api_->upload_sheet(obj_upload("a", 600));
  ASSERT_TRUE(first.ok());
  const auto second = api_->upload_sheet(obj_upload("b", 401));
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kResourceExhausted);
  EXPECT_TRUE(api_->upload_sheet(obj_upload("b", 400)).ok()) << "and given back at once";
  first->reset();
  EXPECT_TRUE(api_->upload_sheet(obj_upload("b", 1000)).ok());
}

TEST_F(ApiFilesTest, UploadsNameNoFilesOfTheServerAndAreOfAMesh) {
  v1::SheetUpload start = obj_upload("a", 10);
  start.mutable_sheet()->mutable_scene()->mutable_obj()->set_file("../../etc/passwd");
  EXPECT_EQ(api_->upload_sheet(start).error().field, "start.sheet.scene");
  start.mutable_sheet()->mutable_scene()->mutable_obj()->clear_file();
  start.mutable_sheet()->mutable_scene()->mutable_obj()->set_text(kTriangle);
  EXPECT_EQ(api_->upload_sheet(start).error().field, "start.sheet.scene");
  start.mutable_sheet()->mutable_scene()->mutable_grid();
  EXPECT_EQ(api_->upload_sheet(start).error().field, "start.sheet.scene");
  v1::RecordingUpload recording;
  recording.set_num_bytes(10);
  recording.set_sheet_id("../a");
  EXPECT_EQ(api_->replay_recording(recording).error().field, "start.sheet_id");
  api_->stop();
  EXPECT_EQ(api_->upload_sheet(obj_upload("a", 10)).error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace kerf::api
