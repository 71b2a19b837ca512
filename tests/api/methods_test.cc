// Every unary method: what it answers, what it refuses, and that a refusal changes nothing.

#include <cstring>
#include <future>

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "render/renderer.h"
#include "server/core/fem/element/material.h"
#include "server/core/fem/element/state.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/service/wire/error_codec.h"
#include "server/service/wire/material_codec.h"
#include "tests/api/bad_calls.h"
#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

using ::testing::HasSubstr;

TEST_F(ApiTest, RefusalsNameCodeAndFieldAndChangeNothing) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", true).ok());
  const std::string hash_a = get_sheet("sheets/a").state_hash();
  const std::string hash_b = get_sheet("sheets/b").state_hash();
  std::vector<BadCall> calls = bad_cuts();
  for (BadCall& call : bad_sheet_calls()) calls.push_back(std::move(call));
  for (BadCall& call : bad_touches()) calls.push_back(std::move(call));
  for (const BadCall& bad : calls) {
    const Result<std::string> reply = call_json("/kerf.v1." + std::string(bad.method), bad.json);
    const std::string what = std::string(bad.method) + " " + bad.json.substr(0, 120);
    ASSERT_FALSE(reply.ok()) << what;
    EXPECT_EQ(wire::status_name(reply.error().code), wire::status_name(bad.code)) << what << reply.error().message;
    EXPECT_TRUE(bad.field == nullptr || reply.error().field == bad.field)
        << what << ": " << reply.error().field << ": " << reply.error().message;
    EXPECT_FALSE(reply.error().reason.empty()) << what;
    EXPECT_FALSE(reply.error().message.empty()) << what;
    ASSERT_EQ(get_sheet("sheets/a").state_hash(), hash_a) << what;
    ASSERT_EQ(get_sheet("sheets/b").state_hash(), hash_b) << what;
  }
  EXPECT_EQ(host_->list(), (std::vector<std::string>{"a", "b"}));
}

TEST_F(ApiTest, RunningSheetIsNotSteppedByHand) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  const Result<std::string> reply = call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":3})");
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, ErrorCode::kFailedPrecondition);
}

TEST_F(ApiTest, SheetsAndVerticesAreBounded) {
  for (const char* id : {"a", "b", "c", "d"}) ASSERT_TRUE(create_sheet(id, true).ok());
  const Result<v1::Sheet> fifth = create_sheet("e", true);
  ASSERT_FALSE(fifth.ok());
  EXPECT_EQ(fifth.error().code, ErrorCode::kResourceExhausted);
}

TEST_F(ApiTest, CommandQueueIsBounded) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  Answers<v1::CutResult> answers;
  for (int i = 0; i < 9; ++i) api_->create_cut(cut_request("sheets/a", 0.1 + 0.1 * i), answers.callback());
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 1U) << "the ninth, at once";
  EXPECT_EQ(answers.reason(0), "QUEUE_FULL");
  run_for(2 * kTick);
  ASSERT_EQ(answers.count(), 9U);
  for (std::size_t i = 1; i < 9; ++i) EXPECT_EQ(answers.at(i)->status(), v1::CutResult::APPLIED);
}

TEST_F(ApiTest, CutTellsWhatItDid) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  const Result<v1::CutResult> result = call(&Api::create_cut, cut_request("sheets/a", 0.45));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->status(), v1::CutResult::APPLIED);
  EXPECT_EQ(result->pieces(), 2);
  EXPECT_GT(result->new_vertices(), 0);
  EXPECT_GT(result->new_triangles(), 0);
  EXPECT_GE(result->min_angle_deg(), 20.0 - 1e-6);
  EXPECT_GE(result->quality().mean_min_angle_deg(), result->min_angle_deg());
  EXPECT_LE(result->quality().max_aspect(), 5.5);
  EXPECT_GT(result->quality().min_height_m(), 0.0);
  EXPECT_EQ(result->quality().below_contract(), 0);
  EXPECT_FALSE(result->refinement_stopped());
  EXPECT_EQ(result->topology_version(), 2);
  EXPECT_EQ(result->name(), "sheets/a/cuts/1");
  EXPECT_GT(result->queued_us(), 0.0);
  EXPECT_EQ(result->state_hash().size(), 16U);
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(sheet.pieces(), 2);
  EXPECT_EQ(sheet.topology_version(), 2);
  EXPECT_EQ(sheet.num_vertices(), 49 + result->new_vertices());
}

TEST_F(ApiTest, CutThatMissesChangesNothing) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const std::string before = get_sheet("sheets/a").state_hash();
  const Result<v1::CutResult> result = call(&Api::create_cut, cut_request("sheets/a", 5.0));
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->status(), v1::CutResult::NO_INTERSECTION);
  EXPECT_EQ(result->name(), "");
  EXPECT_EQ(result->pieces(), 1);
  EXPECT_EQ(result->state_hash(), before);
  EXPECT_EQ(get_sheet("sheets/a").state_hash(), before);
}

TEST_F(ApiTest, ListsSheetsByPage) {
  for (const char* id : {"c", "a", "d", "b"}) ASSERT_TRUE(create_sheet(id, true).ok());
  v1::ListSheetsRequest request;
  request.set_page_size(3);
  const v1::ListSheetsResponse first = call(&Api::list_sheets, request).value();
  ASSERT_EQ(first.sheets_size(), 3);
  EXPECT_EQ(first.sheets(0).name(), "sheets/a");
  EXPECT_EQ(first.sheets(2).name(), "sheets/c");
  // Deletes a listed sheet in between: nothing is skipped.
  v1::DeleteSheetRequest remove;
  remove.set_name("sheets/a");
  ASSERT_TRUE(call(&Api::delete_sheet, remove).ok());
  request.set_page_token(first.next_page_token());
  const v1::ListSheetsResponse second = call(&Api::list_sheets, request).value();
  ASSERT_EQ(second.sheets_size(), 1);
  EXPECT_EQ(second.sheets(0).name(), "sheets/d");
  EXPECT_EQ(second.next_page_token(), "");
}

TEST_F(ApiTest, ListingWaitsForNoSheet) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(create_sheet("b", false).ok());
  const Result<v1::CutResult> cut = call(&Api::create_cut, cut_request("sheets/a", 0.45));
  ASSERT_TRUE(cut.ok());
  std::promise<void> release;
  host_->inspect(
      "a", [released = release.get_future().share()](const sheet::Sheet&) { released.wait(); }, [](const Status&) {});
  Answers<v1::ListSheetsResponse> answers;
  api_->list_sheets({}, caller_, answers.callback());
  const std::size_t answered = answers.count();
  release.set_value();
  ASSERT_EQ(answered, 1U) << "while a's strand was busy";
  const v1::ListSheetsResponse list = answers.at(0).value();
  ASSERT_EQ(list.sheets_size(), 2);
  EXPECT_EQ(list.sheets(0).topology_version(), cut->topology_version());
  EXPECT_EQ(list.sheets(0).pieces(), 2);
  EXPECT_EQ(list.sheets(0).run_state(), v1::Sheet::PAUSED);
  host_->wait_idle();
  v1::Sheet b = get_sheet("sheets/b");
  b.clear_state_hash();
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(list.sheets(1), b));
}

TEST_F(ApiTest, PausesStepsAndResumes) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  EXPECT_EQ(get_sheet("sheets/a").run_state(), v1::Sheet::PAUSED);
  v1::StepSheetRequest step;
  step.set_name("sheets/a");
  step.set_ticks(7);
  EXPECT_EQ(call(&Api::step_sheet, step).value().tick(), 7);
  v1::ResumeSheetRequest resume;
  resume.set_name("sheets/a");
  EXPECT_EQ(call(&Api::resume_sheet, resume).value().run_state(), v1::Sheet::RUNNING);
  run_for(10 * kTick);
  EXPECT_GE(get_sheet("sheets/a").tick(), 16);
  v1::PauseSheetRequest pause;
  pause.set_name("sheets/a");
  const std::int64_t tick = call(&Api::pause_sheet, pause).value().tick();
  run_for(10 * kTick);
  EXPECT_EQ(get_sheet("sheets/a").tick(), tick);
}

TEST_F(ApiTest, SettingsInForceAreToldWithTheSheet) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetGravity",
                        R"({"name":"sheets/a","set_gravity":{"gravity_mps2":{"z":-1.62}}})")
                  .ok());
  ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetWind",
                        R"({"name":"sheets/a","set_wind":{"wind":{"velocity_mps":{"x":3}}}})")
                  .ok());
  ASSERT_TRUE(call_json("/kerf.v1.InteractionService/SetSheetPins",
                        R"({"name":"sheets/a","set_pins":{"pins":[{"vertices":{"vertices":[3,1]}}]}})")
                  .ok());
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(sheet.scene().gravity_mps2().z(), -1.62);
  EXPECT_EQ(sheet.scene().wind().velocity_mps().x(), 3.0);
  EXPECT_EQ(sheet.scene().wind().air_density_kgpm3(), 1.2);
  EXPECT_THAT(sheet.pinned_vertices(), ::testing::ElementsAre(1, 3));
  EXPECT_GT(sheet.settings_version(), 0);
  EXPECT_FALSE(sheet.scene().has_grid());
  EXPECT_GT(sheet.scene().material().youngs_modulus_pa(), 0.0);
}

TEST_F(ApiTest, MaterialsInForceAreToldWithTheSheetUntilAReset) {
  const char* create = R"({"sheet_id":"m","paused":true,"scene":{"grid":{"columns":7,"rows":7,"width_m":1,"height_m":1},
    "material":{"preset":"wool"},"materials":[{"region":{"box":{"min":{"x":0.5},"max":{"x":1,"y":1}}},
    "material":{"preset":"denim"}}]}})";
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/CreateSheet", create).ok());
  const v1::Sheet before = get_sheet("sheets/m");
  ASSERT_TRUE(
      call_json("/kerf.v1.InteractionService/SetSheetMaterial",
                R"({"name":"sheets/m","set_material":{"material":{"preset":"silk","thickness_m":0.0003},"part":0}})")
          .ok());
  const v1::Sheet sheet = get_sheet("sheets/m");
  const fem::Material silk = fem::find_preset("silk").value();
  ASSERT_EQ(sheet.scene().materials_size(), 1);
  EXPECT_EQ(sheet.scene().materials(0).material().thickness_m(), 0.0003);
  EXPECT_EQ(sheet.scene().materials(0).material().density_kgpm3(), silk.density);
  EXPECT_EQ(sheet.scene().materials(0).region().SerializeAsString(),
            before.scene().materials(0).region().SerializeAsString());
  EXPECT_EQ(sheet.scene().material().SerializeAsString(), before.scene().material().SerializeAsString());
  EXPECT_EQ(sheet.settings_version(), before.settings_version() + 1);
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/m"})").ok());
  EXPECT_EQ(get_sheet("sheets/m").scene().SerializeAsString(), before.scene().SerializeAsString());
}

TEST_F(ApiTest, TheSpeedIsToldWithTheSheet) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::Sheet before = get_sheet("sheets/a");
  EXPECT_EQ(before.speed(), 1.0);
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/SetSheetSpeed", R"({"name":"sheets/a","speed":0.25})").ok());
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(sheet.speed(), 0.25);
  EXPECT_EQ(sheet.settings_version(), before.settings_version() + 1);
  EXPECT_EQ(sheet.state_hash(), before.state_hash());
}

template <typename T>
std::vector<T> unpack(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

TEST_F(ApiTest, ExactStateIsThatOfTheSolver) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/StepSheet", R"({"name":"sheets/a","ticks":5})").ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  v1::GetSheetStateRequest request;
  request.set_name("sheets/a");
  const v1::SheetState state = call(&Api::get_sheet_state, request).value();
  EXPECT_EQ(state.tick(), 5);
  EXPECT_EQ(state.state_hash(), get_sheet("sheets/a").state_hash());
  Answers<host::CommandResult> unused;
  host_->inspect(
      "a",
      [&](const sheet::Sheet& sheet) {
        const auto& x = sheet.state().x;
        const auto& v = sheet.state().v;
        ASSERT_EQ(state.num_vertices(), x.cols());
        EXPECT_EQ(unpack<double>(state.positions()), std::vector<double>(x.data(), x.data() + x.size()));
        EXPECT_EQ(unpack<double>(state.velocities()), std::vector<double>(v.data(), v.data() + v.size()));
        const auto triangles = unpack<std::int32_t>(state.triangles());
        const auto pieces = unpack<std::int32_t>(state.pieces());
        ASSERT_EQ(static_cast<std::int32_t>(pieces.size()), sheet.mesh().num_triangle_slots());
        ASSERT_EQ(triangles.size(), 3 * pieces.size());
        for (std::int32_t t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
          const auto slot = static_cast<std::size_t>(t);
          EXPECT_EQ(pieces[slot], sheet.mesh().piece(t));
          for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(triangles[3 * slot + k], sheet.mesh().vertices(t)[k]);
        }
      },
      [](const Status&) {});
  host_->wait_idle();
}

TEST_F(ApiTest, ServerTellsItsLimits) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  run_for(2s);
  const v1::ServerInfo info = call(&Api::get_server_info, v1::GetServerInfoRequest()).value();
  EXPECT_EQ(info.version(), "1.2.3");
  EXPECT_EQ(info.instance_id(), "instance");
  EXPECT_THAT(info.renderer(), HasSubstr("none: "));
  EXPECT_EQ(info.workers(), 2);
  EXPECT_EQ(info.num_sheets(), 1);
  EXPECT_NEAR(info.uptime_s(), 2.0, 0.1);
  EXPECT_THAT(info.material_presets(), ::testing::Contains("demo"));
  EXPECT_EQ(info.limits().max_sheets(), 4);
  EXPECT_EQ(info.limits().max_queued_commands_per_sheet(), 8);
  EXPECT_EQ(info.limits().max_total_vertices(), 2'000'000);
  EXPECT_EQ(info.limits().max_mesh_upload_bytes(), 64 << 20);
  EXPECT_EQ(info.limits().max_recording_upload_bytes(), 128 << 20);
}

TEST_F(ApiTest, ServerTellsTheNumbersOfItsMaterials) {
  const v1::ServerInfo info = call(&Api::get_server_info, v1::GetServerInfoRequest()).value();
  ASSERT_EQ(info.materials_size(), info.material_presets_size());
  for (int i = 0; i < info.materials_size(); ++i) {
    const v1::Material& told = info.materials(i);
    EXPECT_EQ(told.preset(), info.material_presets(i));
    // Whoever sends the numbers gets what the name gets.
    v1::Material numbers = told;
    numbers.clear_preset();
    EXPECT_EQ(wire::decode_material(numbers, "material").value(), fem::find_preset(told.preset()).value())
        << told.preset();
  }
}

TEST_F(ApiTest, AfterStopEverythingIsUnavailable) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  api_->stop();
  api_->stop();
  int asked = 0;
  for (const Method& method : api_->methods()) {
    Answers<std::string> answers;
    method.call("{}", Encoding::kJson, caller_, answers.callback(), {});
    host_->wait_idle();
    ASSERT_EQ(answers.count(), 1U) << method.path;
    EXPECT_EQ(answers.at(0).error().code, ErrorCode::kUnavailable) << method.path;
    ++asked;
  }
  EXPECT_EQ(asked, 42);
}

// Draws nothing, and returns only when released.
class SlowRenderer : public render::Renderer {
 public:
  render::Status render(const render::Scene&, const render::Camera&, int width, int height, render::Pixels& pixels,
                        render::RenderTimes*) override {
    begun_.set_value();
    released_.wait();
    pixels = {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(4 * width * height))};
    return {};
  }
  [[nodiscard]] bool available() const override { return true; }
  [[nodiscard]] std::string description() const override { return "slow"; }

  void wait_until_begun() { begun_.get_future().wait(); }
  void release() { release_.set_value(); }

 private:
  std::promise<void> begun_;
  std::promise<void> release_;
  std::shared_future<void> released_ = release_.get_future().share();
};

TEST_F(ApiTest, StopRefusesPicturesThatWaitAndEndsTheOneBeingDrawn) {
  SlowRenderer renderer;
  make_api({}, &renderer);
  ASSERT_TRUE(create_sheet("a", true).ok());
  v1::RenderImageRequest request;
  request.set_name("sheets/a");
  request.set_width_px(16);
  request.set_height_px(16);
  Answers<v1::RenderImageResponse> drawn;
  api_->render_image(request, drawn.callback());
  renderer.wait_until_begun();
  Answers<v1::RenderImageResponse> waiting;
  for (int i = 0; i < 5; ++i) api_->render_image(request, waiting.callback());
  host_->wait_idle();
  ASSERT_EQ(waiting.count(), 0U);
  api_->stop();
  EXPECT_EQ(waiting.count(), 5U) << "at once, whatever the one being drawn takes";
  for (std::size_t i = 0; i < waiting.count(); ++i) EXPECT_EQ(waiting.at(i).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(drawn.count(), 0U);
  renderer.release();
  api_.reset();
  ASSERT_EQ(drawn.count(), 1U);
  EXPECT_EQ(drawn.at(0)->width_px(), 16) << "it was finished";
}

TEST_F(ApiTest, MethodsSpeakJson) {
  const Result<std::string> created =
      call_json("/kerf.v1.SheetService/CreateSheet",
                R"({"sheetId":"j","paused":true,"scene":{"grid":{"columns":3,"rows":3,"width_m":1,"height_m":1}}})");
  ASSERT_TRUE(created.ok()) << created.error().message;
  EXPECT_THAT(*created, HasSubstr("\"name\":\"sheets/j\""));
  EXPECT_THAT(*created, HasSubstr("\"run_state\":\"PAUSED\""));
  EXPECT_THAT(*created, HasSubstr("\"pieces\":1"));
  EXPECT_EQ(call_json("/kerf.v1.SheetService/DeleteSheet", R"({"name":"sheets/j"})").value(), "{}");
  EXPECT_TRUE(host_->list().empty());
}

}  // namespace
}  // namespace kerf::api
