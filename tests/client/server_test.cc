#include "client/cpp/server.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/closed_port.h"
#include "tests/ws/running_server.h"

namespace kerf::client {
namespace {

class ServerTest : public testing::Test {
 protected:
  void SetUp() override {
    running_ = ws_test::start_server();
    ASSERT_NE(running_, nullptr);
    server_ = std::make_unique<Server>(running_->grpc_address());
  }
  // Paused, of 8 x 8 vertices and 1 m x 1 m.
  Sheet make(const std::string& id) { return server_->create(grid_scene(8, 8, 1.0, 1.0), {id, true, ""}).value(); }

  std::unique_ptr<app::Server> running_;
  std::unique_ptr<Server> server_;
};

TEST_F(ServerTest, CreatesFromGridsMeshesOutlinesAndScenes) {
  v1::Scene scene = grid_scene(5, 4, 1.5, 1.0);
  scene.mutable_material()->set_preset("silk");
  pin(v1::Region::CORNERS, scene);
  Sheet grid = server_->create(scene, {"grid", true, ""}).value();
  const v1::Sheet made = grid.get().value();
  EXPECT_EQ(made.num_vertices(), 20);
  EXPECT_EQ(made.pinned_vertices_size(), 4);
  EXPECT_EQ(made.scene().material().density_kgpm3(), 420.0);
  EXPECT_EQ(made.run_state(), v1::Sheet::PAUSED);

  const std::vector<double> corners = {0, 0, 1, 0, 1, 1, 0, 1};
  const std::vector<std::int32_t> triangles = {0, 1, 2, 0, 2, 3};
  EXPECT_EQ(server_->create(mesh_scene(corners, triangles)).value().get().value().num_triangles(), 2);
  EXPECT_EQ(server_->create(obj_scene("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).value().get().value().num_vertices(), 3);
  const v1::Scene ring = outline_scene(circle({0, 0}, 1.0), {circle({0, 0}, 0.4)}, 0.2);
  const std::vector<v1::Piece> pieces = server_->create(ring, {"ring", true, ""}).value().pieces().value();
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_NEAR(pieces[0].area_m2(), std::numbers::pi * (1.0 - 0.16), 0.1);

  const Result<v1::Scene> read =
      json_scene(R"({"sheet_id": "read", "grid": {"columns": 3, "rows": 3, "width_m": 1, "height_m": 1}})");
  EXPECT_EQ(server_->create(read.value()).value().name(), "sheets/read");
  EXPECT_EQ(server_->sheets().value().size(), 5U);
  EXPECT_GT(server_->info().value().limits().max_sheets(), 0);
}

TEST_F(ServerTest, ARequestBeyondTheLimitIsToldWhatToDo) {
  Sheet sheet = make("many");
  const std::vector<Point> points(70'000, Point{0.5, 0.5});
  const Failure failure = sheet.cut(polyline(points)).failure();
  EXPECT_EQ(failure.reason, "MESSAGE_TOO_LARGE");
  EXPECT_NE(failure.message.find("send less in one call"), std::string::npos) << failure.message;
}

TEST_F(ServerTest, CutsAlongEveryKindOfCurve) {
  Sheet sheet = server_->create(grid_scene(30, 30, 1.0, 1.0), {"curves", true, ""}).value();
  const std::vector<v1::Curve> curves = {
      polyline({{-0.1, 0.9}, {1.1, 0.92}}),
      bezier({{-0.1, 0.75}, {0.3, 0.85}, {0.7, 0.65}, {1.1, 0.75}}),
      circle({0.2, 0.2}, 0.1),
      ellipse({0.6, 0.2}, 0.15, 0.08, 0.5),
      PathBuilder({0.1, 0.4}).line({0.2, 0.4}).arc({0.1, 0.4}, 0.06).close().curve(),
      PathBuilder({0.3, 0.4}).cubic({0.35, 0.5}, {0.45, 0.5}, {0.5, 0.4}).quadratic({0.4, 0.35}, {0.3, 0.4}).curve(),
      PathBuilder({0.6, 0.45}).quadratic(1.0, {0.7, 0.6, 2.0}, {0.8, 0.45}).line({0.6, 0.45}).curve(),
  };
  std::int32_t pieces = 1;
  for (const v1::Curve& curve : curves) {
    const v1::CutResult result = sheet.cut(curve).value();
    EXPECT_EQ(result.status(), v1::CutResult::APPLIED) << curve.ShortDebugString();
    EXPECT_EQ(result.pieces(), ++pieces) << curve.ShortDebugString();
  }
  const v1::Curve drawing = svg("<svg viewBox='0 0 9 9'><circle cx='4' cy='4' r='3'/></svg>");
  CutOptions small;
  small.fit = Box{{0.82, 0.1}, {0.92, 0.2}};
  EXPECT_EQ(sheet.cut(drawing, small).value().pieces(), pieces + 1);
  EXPECT_EQ(sheet.cut(circle({5, 5}, 0.1)).value().status(), v1::CutResult::NO_INTERSECTION);
}

TEST(CutOptions, SayEveryFieldOfTheMessage) {
  const CutOptions all{.tolerance = 0.01,
                       .tolerance_m = 1e-3,
                       .min_angle_deg = 18.0,
                       .max_new_triangles = 100,
                       .method = v1::Cut::ELEMENT,
                       .quality = v1::Cut::FINE,
                       .tip_edge_length_m = 0.01,
                       .tip_grading = 1.2,
                       .relax = false,
                       .width_m = 0.02,
                       .fit_sheet = true,
                       .dash = {0.1, 0.05},
                       .dash_offset = 0.02,
                       .view = v1::View(),
                       .join_m = 1e-3,
                       .component = "ribbon"};
  const v1::Cut cut = make_cut(circle({0.5, 0.5}, 0.1), all);
  std::vector<const google::protobuf::FieldDescriptor*> said;
  cut.GetReflection()->ListFields(cut, &said);
  EXPECT_EQ(static_cast<int>(said.size()), v1::Cut::descriptor()->field_count()) << cut.ShortDebugString();
}

TEST_F(ServerTest, OptionsOfACutReachTheServer) {
  Sheet sheet = make("options");
  CutOptions options;
  options.tolerance_m = 1e-4;
  options.width_m = 0.02;
  options.dash = {0.1, 0.05};
  options.dash_offset = 0.02;
  options.min_angle_deg = 18.0;
  const v1::CutResult result = sheet.cut(polyline({{0.1, 0.5}, {0.9, 0.5}}), options).value();
  EXPECT_LE(result.deviation_m(), 1e-4);
  EXPECT_GT(result.removed().area_m2(), 0.005);
  const v1::Cut applied = sheet.cuts().value().cuts(0).cut();
  EXPECT_EQ(applied.dash_size(), 2);
  EXPECT_EQ(applied.dash_offset(), 0.02);
  EXPECT_EQ(applied.min_angle_deg(), 18.0);
  CutOptions by_element;
  by_element.method = v1::Cut::ELEMENT;
  by_element.tip_edge_length_m = 0.01;
  EXPECT_EQ(sheet.cut(circle({0.5, 0.2}, 0.05), by_element).failure().reason, "OPTIONS_CONFLICT");
  CutOptions seen;
  seen.view = picture_view(camera({0.5, -2.0, 0.5}, {0.5, 0.0, 0.5}), 640, 640, v1::View::ALL);
  const v1::CutResult on_picture = sheet.cut(polyline({{0, 160}, {640, 160}}), seen).value();
  EXPECT_EQ(on_picture.layers_size(), 1);
}

TEST_F(ServerTest, BatchesUndoRedoAndScheduledCuts) {
  Sheet sheet = make("batch");
  const std::vector<v1::Cut> cuts = {make_cut(circle({0.3, 0.3}, 0.1)), make_cut(circle({0.7, 0.7}, 0.1))};
  EXPECT_EQ(sheet.cut_all(cuts).value().pieces(), 3);
  const std::vector<v1::Cut> wrong = {make_cut(circle({0.3, 0.7}, 0.1)), make_cut(circle({0.7, 0.3}, -1.0))};
  EXPECT_EQ(sheet.cut_all(wrong).failure().field, "cuts[1].curve.circle.radius_m");
  EXPECT_EQ(sheet.undo().value().pieces(), 1);
  EXPECT_EQ(sheet.redo().value().pieces(), 3);
  EXPECT_EQ(sheet.redo().failure().reason, "NOTHING_TO_REDO");
  EXPECT_EQ(sheet.pieces().value().size(), 3U);

  const std::int64_t tick = sheet.get().value().tick();
  const v1::CutResult later = sheet.cut(circle({0.3, 0.7}, 0.1), {}, tick + 2).value();
  EXPECT_EQ(later.status(), v1::CutResult::SCHEDULED);
  EXPECT_EQ(sheet.cuts().value().scheduled_size(), 1);
  EXPECT_EQ(sheet.cancel(later.scheduled_name()).value().state(), v1::ScheduledCuts::CANCELLED);
}

TEST_F(ServerTest, TimeGoesAsItIsTold) {
  Sheet sheet = make("time");
  const v1::Sheet at_first = sheet.get().value();
  const v1::Sheet stepped = sheet.step(5).value();
  EXPECT_EQ(stepped.tick(), at_first.tick() + 5);
  EXPECT_NE(stepped.state_hash(), at_first.state_hash());
  EXPECT_EQ(sheet.resume().value().run_state(), v1::Sheet::RUNNING);
  EXPECT_EQ(sheet.step(1).failure().code, grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(sheet.pause().value().run_state(), v1::Sheet::PAUSED);
  EXPECT_EQ(sheet.set_speed(0.25).value().speed(), 0.25);
  EXPECT_EQ(sheet.get().value().speed(), 0.25);
  EXPECT_EQ(sheet.set_speed(5.0).failure().field, "speed");
  ASSERT_TRUE(sheet.reset().ok());
  ASSERT_TRUE(sheet.remove().ok());
  EXPECT_EQ(sheet.get().failure().reason, "SHEET_NOT_FOUND");
}

TEST_F(ServerTest, GoesBackToSavedStates) {
  Sheet sheet = make("states");
  const v1::SavedState saved = sheet.save_state("before").value();
  EXPECT_EQ(saved.name(), "sheets/states/states/before");
  EXPECT_EQ(sheet.save_state("before").failure().reason, "STATE_EXISTS");
  ASSERT_TRUE(sheet.step(5).ok());
  EXPECT_EQ(sheet.save_state("before", true, "once").value().tick(), 5);
  ASSERT_TRUE(sheet.step(5).ok());
  EXPECT_EQ(sheet.save_state("before", true, "once").value().tick(), 5) << "the same request again";
  EXPECT_EQ(sheet.restore_state("before").value().tick(), 5);
  EXPECT_EQ(sheet.restore_state("after").failure().reason, "STATE_NOT_FOUND");
  EXPECT_EQ(sheet.states().value().size(), 1U);
  ASSERT_TRUE(sheet.delete_state("before").ok());
  EXPECT_TRUE(sheet.states().value().empty());
  EXPECT_EQ(sheet.delete_state("before").failure().reason, "STATE_NOT_FOUND");
}

// Returns the position of a vertex, m.
Vector place(const State& state, std::size_t vertex) {
  return {state.positions[3 * vertex], state.positions[3 * vertex + 1], state.positions[3 * vertex + 2]};
}

TEST_F(ServerTest, HandsPullTheSheet) {
  Sheet sheet = make("hands");
  ASSERT_TRUE(sheet.set_gravity({0, 0, 0}).ok());
  const State before = sheet.state().value();
  ASSERT_TRUE(sheet.grab_vertex("finger", 0, Vector{0, -0.3, 0}).ok());
  ASSERT_TRUE(sheet.grab("other", {1.0, 1.0}).ok());
  EXPECT_EQ(sheet.grab("finger", {0.5, 0.5}).failure().field, "grab.grab_id");
  ASSERT_TRUE(sheet.step(20).ok());
  EXPECT_LT(place(sheet.state().value(), 0).y, -0.1);
  ASSERT_TRUE(sheet.drag("finger", {0, 0.3, 0}).ok());
  ASSERT_TRUE(sheet.step(40).ok());
  EXPECT_GT(place(sheet.state().value(), 0).y, 0.1);
  ASSERT_TRUE(sheet.release("finger").ok());
  EXPECT_FALSE(sheet.release("finger").ok());

  ASSERT_TRUE(sheet.reset().ok());
  EXPECT_EQ(sheet.state().value().positions, before.positions);
  v1::Region left;
  left.set_edge(v1::Region::LEFT);
  ASSERT_TRUE(sheet.set_pins(std::vector<v1::Region>{left}).ok());
  EXPECT_EQ(sheet.get().value().pinned_vertices_size(), 8);
  v1::Wind wind;
  *wind.mutable_velocity_mps() = vec3({0, 10, 0});
  ASSERT_TRUE(sheet.set_wind(wind).ok());
  EXPECT_EQ(sheet.get().value().scene().wind().velocity_mps().y(), 10.0);
  ASSERT_TRUE(sheet.set_wind({}).ok());
  EXPECT_FALSE(sheet.get().value().scene().has_wind());
}

TEST_F(ServerTest, AMaterialIsSetForAllOfASheetOrAPart) {
  v1::Scene scene = grid_scene(8, 8, 1.0, 1.0);
  v1::RegionMaterial& part = *scene.add_materials();
  part.mutable_region()->mutable_box()->mutable_min()->set_x(0.5);
  part.mutable_region()->mutable_box()->mutable_max()->set_x(1.0);
  part.mutable_region()->mutable_box()->mutable_max()->set_y(1.0);
  part.mutable_material()->set_preset("denim");
  Sheet sheet = server_->create(scene, {"two", true, ""}).value();
  v1::Material material;
  material.set_preset("silk");
  material.set_thickness_m(0.0003);
  ASSERT_TRUE(sheet.set_material(material, 0).ok());
  EXPECT_EQ(sheet.get().value().scene().materials(0).material().thickness_m(), 0.0003);
  EXPECT_NE(sheet.get().value().scene().material().thickness_m(), 0.0003);
  ASSERT_TRUE(sheet.set_material(material).ok());
  EXPECT_EQ(sheet.get().value().scene().material().thickness_m(), 0.0003);
  EXPECT_EQ(sheet.set_material(material, 1).failure().field, "set_material.part");
  material.set_preset("steel");
  EXPECT_EQ(sheet.set_material(material).failure().field, "set_material.material.preset");
}

TEST_F(ServerTest, SelfContactIsTurnedOnAndChanged) {
  Sheet sheet = make("folds");
  v1::SetSelfContact change;
  change.set_mode(v1::SelfContact::ON);
  change.set_thickness_m(0.002);
  ASSERT_TRUE(sheet.set_self_contact(change).ok());
  change.Clear();
  change.set_friction(0.5);
  ASSERT_TRUE(sheet.set_self_contact(change).ok());
  const v1::SelfContact shown = sheet.get().value().scene().self_contact();
  EXPECT_EQ(shown.mode(), v1::SelfContact::ON);
  EXPECT_EQ(shown.friction(), 0.5);
  EXPECT_EQ(shown.thickness_m(), 0.002);
  change.Clear();
  change.set_material_thickness(true);
  ASSERT_TRUE(sheet.set_self_contact(change).ok());
  EXPECT_FALSE(sheet.get().value().scene().self_contact().has_thickness_m());
  change.set_friction(11.0);
  EXPECT_EQ(sheet.set_self_contact(change).failure().field, "set_self_contact.friction");
}

TEST_F(ServerTest, ARecordingIsPlayedAsAnotherSheet) {
  Sheet sheet = make("first");
  ASSERT_TRUE(sheet.step(10).ok());
  ASSERT_TRUE(sheet.cut(circle({0.5, 0.5}, 0.2)).ok());
  const v1::Sheet after = sheet.step(10).value();
  const std::string file = sheet.recording().value();
  Sheet again = server_->replay(file, "again", true).value();
  EXPECT_EQ(again.name(), "sheets/again");
  const v1::Sheet played = again.step(1000).value();
  EXPECT_EQ(played.replay().state(), v1::Replay::DONE);
  EXPECT_EQ(played.state_hash(), after.state_hash());
  EXPECT_EQ(server_->replay("no recording").failure().code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(server_->sheet("nobody").recording().failure().reason, "SHEET_NOT_FOUND");
}

// Two million bytes, of three vertices: more than a message takes.
TEST_F(ServerTest, ALargeMeshFileGoesInParts) {
  std::string obj;
  while (obj.size() < 2'000'000) obj += "# a comment of a file that is large for no reason\n";
  obj += "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const Result<Sheet> made = server_->create(obj_scene(std::move(obj)), {"large", true, ""});
  ASSERT_TRUE(made.ok()) << describe(made.failure());
  EXPECT_EQ(server_->sheet("large").get().value().num_vertices(), 3);
}

TEST_F(ServerTest, ACutThatIsSentAgainIsMadeOnce) {
  Sheet sheet = make("again");
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(sheet.cut(circle({0.3, 0.3}, 0.1), {}, 0, "one").value().pieces(), 2);
    const std::vector<v1::Cut> cuts = {make_cut(circle({0.7, 0.7}, 0.1))};
    EXPECT_EQ(sheet.cut_all(cuts, 0, "two").value().pieces(), 3);
  }
  EXPECT_EQ(sheet.cuts().value().cuts_size(), 2);
}

TEST_F(ServerTest, FilesHaveTheTimeOfCalls) {
  Sheet sheet = make("slow");
  const std::string file = sheet.recording().value();
  Server hasty(running_->grpc_address(), {std::chrono::milliseconds(-1000)});
  EXPECT_EQ(hasty.sheet("slow").recording().failure().code, grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(hasty.replay(file).failure().code, grpc::StatusCode::DEADLINE_EXCEEDED);
  EXPECT_EQ(hasty.replay(file).failure().reason, "NO_ANSWER_IN_TIME");
}

TEST_F(ServerTest, TheExactStateComesAsArrays) {
  Sheet sheet = make("state");
  const State state = sheet.state().value();
  EXPECT_EQ(state.positions.size(), 3U * 64);
  EXPECT_EQ(state.velocities, std::vector<double>(3U * 64, 0.0));
  EXPECT_EQ(state.material_positions.size(), 2U * 64);
  EXPECT_NEAR(state.material_positions[2], 1.0 / 7.0, 1e-9) << "points lie on a lattice";
  EXPECT_EQ(state.triangles.size(), 3 * state.pieces.size());
  EXPECT_EQ(std::count(state.pieces.begin(), state.pieces.end(), 0), 98) << "slots with material";
  EXPECT_EQ(std::count(state.pieces.begin(), state.pieces.end(), -1), std::ssize(state.pieces) - 98);
  EXPECT_EQ(*std::max_element(state.triangles.begin(), state.triangles.end()), 63);
  EXPECT_EQ(state.state_hash, sheet.get().value().state_hash());
}

TEST_F(ServerTest, FramesFilesAndAnalyses) {
  Sheet sheet = make("looks");
  std::int32_t vertices = 0;
  const Result<v1::Ended> ended = sheet.watch([&](const v1::Frame& /*frame*/, const Mirror& mirror) {
    vertices = mirror.num_vertices();
    return false;
  });
  EXPECT_TRUE(ended.ok());
  EXPECT_EQ(vertices, 64);
  bool has_strains = false;
  WatchOptions with_strains;
  with_strains.strains = true;
  EXPECT_TRUE(
      sheet
          .watch(
              [&](const v1::Frame& /*frame*/, const Mirror& mirror) {
                has_strains = mirror.has_strains();
                return !has_strains;  // the first frame may be of a snapshot that was made for the viewer before
              },
              with_strains)
          .ok());
  EXPECT_TRUE(has_strains);
  EXPECT_NE(sheet.obj().value().find("\nv "), std::string::npos);
  EXPECT_NE(sheet.obj().value().find("\nf "), std::string::npos);
  EXPECT_EQ(sheet.gltf().value().substr(0, 4), "glTF");
  v1::AnalyzeSheetRequest modes;
  modes.mutable_analysis()->mutable_modes()->set_count(2);
  EXPECT_EQ(sheet.analyze(modes).value().tables(0).rows_size(), 2);
  RenderOptions wrong;
  wrong.width_px = 3;
  EXPECT_FALSE(sheet.render(wrong).ok());  // refused with or without a renderer
}

TEST_F(ServerTest, RefusalsSayWhyAndValueThrowsThem) {
  Sheet sheet = make("refusals");
  const Result<v1::CutResult> refused = sheet.cut(circle({0.5, 0.5}, -1.0));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.failure().code, grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused.failure().reason, "RADIUS_NOT_POSITIVE");
  EXPECT_EQ(refused.failure().field, "cut.curve.circle.radius_m");
  try {
    static_cast<void>(refused.value());
    FAIL() << "there is no value";
  } catch (const CallFailed& failed) {
    EXPECT_EQ(failed.failure.field, "cut.curve.circle.radius_m");
    EXPECT_NE(std::string(failed.what()).find("RADIUS_NOT_POSITIVE"), std::string::npos);
  }
  EXPECT_EQ(json_scene("{\"grids\": 1}").failure().reason, "SCENE_MALFORMED");
  EXPECT_EQ(server_->sheet("nobody").undo().failure().reason, "SHEET_NOT_FOUND");
  const test::ClosedPort closed;
  Server nobody(closed.address());
  EXPECT_EQ(nobody.info().failure().code, grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace kerf::client
