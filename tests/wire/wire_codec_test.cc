// Scenes, commands, recordings, errors and JSON.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "server/base/random.h"
#include "server/sheet/sheet.h"
#include "server/wire/command_codec.h"
#include "server/wire/error_codec.h"
#include "server/wire/json.h"
#include "server/wire/mesh_source_codec.h"
#include "server/wire/protobuf_log.h"
#include "server/wire/recording_codec.h"
#include "server/wire/reply_codec.h"
#include "server/wire/scene_codec.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;
using ::testing::HasSubstr;
using testing::set_outline;

void expect_equal(const google::protobuf::Message& a, const google::protobuf::Message& b) {
  std::string difference;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&difference);
  EXPECT_TRUE(differencer.Compare(a, b)) << difference;
}

sheet::SheetConfig decoded(const v1::Scene& scene) {
  const Result<sheet::SheetConfig> config = decode_scene(scene);
  EXPECT_TRUE(config.ok()) << config.error().message << " at " << config.error().field;
  return config.value();
}

TEST(SceneCodec, FullSceneComesBackUnchanged) {
  // Complete, so that encoding what was decoded gives every field again; bit for bit, as the comparison is exact.
  const v1::Scene scene = full_scene();
  expect_equal(encode_scene(decoded(scene)), scene);
}

TEST(SceneCodec, EveryMeshSourceComesBackUnchanged) {
  v1::Scene scene = full_scene();
  v1::InlineMesh& arrays = *scene.mutable_inline_();
  for (const double number : {0.0, 0.0, 1.0, 0.1, 0.3, 1.0}) arrays.add_material_positions(number);
  for (const int number : {0, 1, 2}) arrays.add_triangles(number);
  for (int i = 0; i < 9; ++i) arrays.add_positions(0.1 * i);
  expect_equal(encode_scene(decoded(scene)), scene);
  scene.mutable_inline_()->clear_positions();
  expect_equal(encode_scene(decoded(scene)), scene);
  scene.mutable_obj()->set_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expect_equal(encode_scene(decoded(scene)), scene);
  scene.mutable_ply()->set_data(test::write_ply(test::one_triangle(), test::PlyKind::kBigEndian));
  expect_equal(encode_scene(decoded(scene)), scene);
  set_outline(scene);
  expect_equal(encode_scene(decoded(scene)), scene);
  v1::Scene from_file;  // bytes of every value are base64 in a scene file
  scene.mutable_ply()->set_data(std::string("ply\n\0\xff", 6));
  ASSERT_TRUE(from_json(to_json(scene), from_file).ok());
  expect_equal(from_file, scene);
}

TEST(SceneCodec, EveryAnalysisComesBackUnchanged) {
  v1::Scene scene = full_scene();
  scene.mutable_analysis()->mutable_dynamic()->set_measure_every(7);
  expect_equal(encode_scene(decoded(scene)), scene);
  scene.mutable_analysis()->mutable_dynamic()->set_measure_every(0);
  EXPECT_EQ(encode_scene(decoded(scene)).analysis().dynamic().measure_every(), 1);
  scene.clear_analysis();
  EXPECT_TRUE(encode_scene(decoded(scene)).analysis().has_dynamic());
}

// The number of steps has no check but the codec's.
TEST(SceneCodec, LoadStepsAreLimited) {
  v1::Scene scene = full_scene();
  v1::StaticAnalysis* const analysis = scene.mutable_analysis()->mutable_static_();
  analysis->set_steps(10'000);
  const Result<sheet::SheetConfig> most = decode_scene(scene);
  ASSERT_TRUE(most.ok()) << most.error().message;
  EXPECT_EQ(std::get<sheet::StaticAnalysis>(most->analysis).loads.size(), 10'000U);
  EXPECT_TRUE(sheet::validate(most->analysis).ok());
  analysis->set_steps(10'001);
  EXPECT_EQ(decode_scene(scene).error().field, "analysis.static.steps");
}

TEST(SceneCodec, BendingThatIsNotGivenStaysDerived) {
  v1::Scene scene = full_scene();
  scene.mutable_material()->clear_bending_coupling_nm();
  scene.mutable_material()->clear_twisting_stiffness_nm();
  const sheet::SheetConfig config = decoded(scene);
  EXPECT_EQ(config.material.bending_stiffness_1, 2.0e-6);
  EXPECT_EQ(config.material.twisting_stiffness, std::nullopt);
  expect_equal(encode_scene(config), scene);
}

TEST(SceneCodec, EveryLinearSolverRoundTrips) {
  const v1::Scene scene = full_scene();
  for (const fem::LinearSolverName& name : fem::kLinearSolverNames) {
    sheet::SheetConfig config = decoded(scene);
    config.integrator.solver = name.kind;
    EXPECT_EQ(decoded(encode_scene(config)).integrator.solver, name.kind) << name.option;
  }
}

TEST(SceneCodec, MinimalSceneGetsTheDocumentedDefaults) {
  v1::Scene scene;
  scene.mutable_grid()->set_columns(3);
  scene.mutable_grid()->set_rows(4);
  scene.mutable_grid()->set_width_m(1.0);
  scene.mutable_grid()->set_height_m(2.0);
  const sheet::SheetConfig config = decoded(scene);
  EXPECT_EQ(config.material, fem::find_preset("demo").value());
  EXPECT_EQ(config.membrane_law, fem::MembraneLaw::kCorotational);
  EXPECT_EQ(config.placement.origin, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(config.placement.x_axis, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(config.placement.y_axis, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(config.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(config.wind.air_density, 0.0);
  EXPECT_EQ(config.tick_rate_hz, 60.0);
  EXPECT_EQ(config.integrator.max_substeps, 20000);
  EXPECT_EQ(config.integrator.newton_iterations, 2);
  EXPECT_EQ(config.integrator.solver_tolerance, 1e-4);
  EXPECT_EQ(config.integrator.solver, sheet::LinearSolverKind::kBlockJacobiCg);
  EXPECT_EQ(config.integrator.max_linear_iterations, 1000);
  EXPECT_EQ(config.integrator.covariance_root.norm, sheet::EigenvalueNorm::kPower);
  EXPECT_EQ(config.integrator.covariance_root.power, 0.5);
  EXPECT_EQ(config.integrator.covariance_root.newton_schulz_iterations, 5);
  EXPECT_EQ(config.integrator.highest_mode_damping, 0.05);
  EXPECT_EQ(config.integrator.precision, sheet::Precision::kMixed);
  scene.mutable_integrator()->set_highest_mode_damping(0.0);
  EXPECT_EQ(decoded(scene).integrator.precision, sheet::Precision::kDouble);
  scene.mutable_integrator()->set_precision(v1::Integrator::MIXED);
  EXPECT_EQ(decoded(scene).integrator.precision, sheet::Precision::kMixed);
  scene.mutable_wind();
  EXPECT_EQ(decoded(scene).wind.air_density, 1.2);
  EXPECT_EQ(decoded(scene).wind.drag_coefficient, 1.0);
}

TEST(SceneCodec, AnOutlineOnlyNeedsItsBorder) {
  v1::Scene scene;
  v1::OutlineMesh& message = *scene.mutable_outline();
  message.mutable_boundary()->mutable_circle()->set_radius_m(1.0);
  message.add_sizes()->mutable_point();
  message.mutable_sizes(0)->set_edge_length_m(0.01);
  const auto outline = std::get<sheet::OutlineSource>(decoded(scene).mesh);
  EXPECT_EQ(outline.edge_length, 0.0);
  EXPECT_EQ(outline.min_angle_deg, 25.0);
  EXPECT_EQ(outline.sizes[0].growth, 0.25);
  EXPECT_TRUE(outline.holes.empty());
}

TEST(SceneCodec, AnOutlineMayBeADrawingFromAFile) {
  v1::Scene scene;
  ASSERT_TRUE(from_json(R"({"outline": {"boundary": {"svg": {"file": "plate.svg"}}}})", scene).ok());
  const auto reader = [](const std::string& path) -> Result<std::string> {
    EXPECT_EQ(path, "plate.svg");
    return std::string(
        R"(<svg xmlns="http://www.w3.org/2000/svg" width="96" height="96"><rect width="96" height="48"/></svg>)");
  };
  const Result<sheet::SheetConfig> config = decode_scene(scene, reader);
  ASSERT_TRUE(config.ok()) << config.error().message;
  const Result<sheet::Sheet> sheet = sheet::Sheet::create(*config);
  ASSERT_TRUE(sheet.ok()) << sheet.error().message;
  EXPECT_NEAR(sheet->mesh().bounding_box().sizes().x(), 0.0254, 1e-12);
  EXPECT_NEAR(sheet->mesh().bounding_box().sizes().y(), 0.0127, 1e-12);
  EXPECT_FALSE(decode_scene(scene).ok());  // over the network
}

TEST(SceneCodec, MaterialPutsWhatIsGivenOverThePreset) {
  v1::Scene scene = full_scene();
  scene.mutable_material()->Clear();
  scene.mutable_material()->set_preset("rubber");
  const fem::Material rubber = fem::find_preset("rubber").value();
  EXPECT_EQ(decoded(scene).material, rubber);
  scene.mutable_material()->set_youngs_modulus_pa(2.0e6);
  fem::Material material = decoded(scene).material;
  EXPECT_EQ(material.youngs_modulus_1, 2.0e6);
  EXPECT_EQ(material.youngs_modulus_2, 2.0e6);
  EXPECT_EQ(material.shear_modulus, 2.0e6 / (2.0 * (1.0 + rubber.poissons_ratio_12)));
  EXPECT_EQ(material.density, rubber.density);
  scene.mutable_material()->set_youngs_modulus_2_pa(3.0e6);
  scene.mutable_material()->set_shear_modulus_pa(5.0e5);
  material = decoded(scene).material;
  EXPECT_EQ(material.youngs_modulus_1, 2.0e6);
  EXPECT_EQ(material.youngs_modulus_2, 3.0e6);
  EXPECT_EQ(material.shear_modulus, 5.0e5);
}

TEST(SceneCodec, EveryBadFieldIsRefusedByName) {
  for (const testing::BadScene& bad : testing::bad_scenes()) {
    v1::Scene scene = full_scene();
    bad.spoil(scene);
    const Result<sheet::SheetConfig> config = decode_scene(scene);
    ASSERT_FALSE(config.ok()) << bad.field;
    EXPECT_EQ(config.error().code, ErrorCode::kInvalidArgument) << bad.field;
    EXPECT_EQ(config.error().field, bad.field) << config.error().message;
    EXPECT_FALSE(config.error().reason.empty());
    EXPECT_FALSE(config.error().message.empty());
  }
}

TEST(SceneCodec, MeshFilesAreReadOnlyWithAReader) {
  v1::Scene scene = full_scene();
  scene.mutable_obj()->set_file("flag.obj");
  const Result<sheet::SheetConfig> refused = decode_scene(scene);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "OBJ_FILE_REFUSED");
  EXPECT_EQ(refused.error().field, "obj.file");
  std::string asked;
  const FileReader reader = [&asked](const std::string& path) -> Result<std::string> {
    asked = path;
    if (path == "flag.obj") return std::string("v 0 0 0\n");
    return Error{ErrorCode::kNotFound, "FILE_NOT_FOUND", "no such file", {}};
  };
  const Result<sheet::SheetConfig> read = decode_scene(scene, reader);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(asked, "flag.obj");
  EXPECT_EQ(std::get<sheet::ObjSource>(read->mesh).text, "v 0 0 0\n");
  scene.mutable_obj()->set_file("none.obj");
  EXPECT_EQ(decode_scene(scene, reader).error().field, "obj.file");
  scene.mutable_obj()->set_text("v 0 0 0\n");
  EXPECT_EQ(decode_scene(scene, reader).error().reason, "OBJ_TWICE");
  scene.mutable_ply()->set_file("flag.obj");
  EXPECT_EQ(decode_scene(scene).error().reason, "PLY_FILE_REFUSED");
  EXPECT_EQ(decode_scene(scene).error().field, "ply.file");
  EXPECT_NE(decode_scene(scene).error().message.find("ply.data"), std::string::npos);
  EXPECT_EQ(std::get<sheet::PlySource>(decode_scene(scene, reader)->mesh).data, "v 0 0 0\n");
  scene.mutable_ply()->set_data("ply");
  EXPECT_EQ(decode_scene(scene, reader).error().reason, "PLY_TWICE");
}

TEST(SceneCodec, RestShapesOfMeshFiles) {
  const std::vector<std::pair<v1::RestShape, sheet::RestShape>> all{
      {v1::REST_SHAPE_UNSPECIFIED, sheet::RestShape::kAutomatic},
      {v1::REST_SHAPE_FLAT, sheet::RestShape::kFlat},
      {v1::REST_SHAPE_SURFACE, sheet::RestShape::kSurface}};
  for (const auto& [name, rest_shape] : all) {
    v1::Scene scene;
    scene.mutable_obj()->set_text("v 0 0 0\n");
    scene.mutable_obj()->set_rest_shape(name);
    const sheet::MeshSource obj = decode_scene(scene).value().mesh;
    EXPECT_EQ(std::get<sheet::ObjSource>(obj).rest_shape, rest_shape);
    v1::Scene again;
    encode_mesh_source(obj, again);
    EXPECT_EQ(again.obj().rest_shape(), name);
    scene.mutable_ply()->set_data("ply\n");
    scene.mutable_ply()->set_rest_shape(name);
    const sheet::MeshSource ply = decode_scene(scene).value().mesh;
    EXPECT_EQ(std::get<sheet::PlySource>(ply).rest_shape, rest_shape);
    encode_mesh_source(ply, again);
    EXPECT_EQ(again.ply().rest_shape(), name);
  }
  v1::Scene scene;
  scene.mutable_ply()->set_data("ply\n");
  scene.mutable_ply()->set_rest_shape(static_cast<v1::RestShape>(7));
  EXPECT_EQ(decode_scene(scene).error().field, "ply.rest_shape");
  scene.mutable_obj()->set_text("v 0 0 0\n");
  scene.mutable_obj()->set_rest_shape(static_cast<v1::RestShape>(7));
  EXPECT_EQ(decode_scene(scene).error().field, "obj.rest_shape");
}

TEST(SceneCodec, RestPositionsOfArrays) {
  v1::Scene scene;
  v1::InlineMesh& message = *scene.mutable_inline_();
  for (const int id : {0, 1, 2}) message.add_triangles(id);
  for (const double value : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5}) message.add_rest_positions(value);
  const sheet::MeshSource source = decode_scene(scene).value().mesh;
  EXPECT_EQ(std::get<sheet::ArraySource>(source).rest_positions.col(2), Eigen::Vector3d(0.0, 1.0, 0.5));
  EXPECT_EQ(std::get<sheet::ArraySource>(source).material_positions.cols(), 0);
  v1::Scene again;
  encode_mesh_source(source, again);
  EXPECT_EQ(again.SerializeAsString(), scene.SerializeAsString());
  message.add_rest_positions(1.0);
  EXPECT_EQ(decode_scene(scene).error().field, "inline.rest_positions");
}

// Names and comments in another encoding than UTF-8: a message could not hold them, nor a recording.
TEST(SceneCodec, ObjFilesMayHoldAnyBytes) {
  v1::Scene scene = full_scene();
  scene.mutable_obj()->set_file("flag.obj");
  const FileReader reader = [](const std::string&) -> Result<std::string> {
    return std::string("o T\xfcr\nv 0 0 0\n");
  };
  const Result<sheet::SheetConfig> read = decode_scene(scene, reader);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(encode_scene(*read).obj().text(), "o T?r\nv 0 0 0\n");
}

TEST(CommandCodec, EveryKindComesBackUnchanged) {
  const v1::Scene scene = full_scene();
  ASSERT_EQ(scene.commands_size(), 17);
  for (const v1::ScheduledCommand& scheduled : scene.commands()) {
    const Result<sheet::Command> command = decode_command(scheduled.command());
    ASSERT_TRUE(command.ok()) << command.error().message;
    expect_equal(encode_command(*command), scheduled.command());
  }
}

TEST(CommandCodec, ZerosOfACutMeanTheDefaults) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_circle()->set_radius_m(0.1);
  const Result<sheet::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok());
  EXPECT_EQ(std::get<sheet::Cut>(*command).tolerance, 0.02);
  EXPECT_EQ(std::get<sheet::Cut>(*command).min_angle_deg, 20.0);
  EXPECT_EQ(std::get<sheet::Cut>(*command).max_new_triangles, 200'000);
  EXPECT_EQ(std::get<sheet::Cut>(*command).method, cut::Method::kNeighbourhood);
  EXPECT_FALSE(std::get<sheet::Cut>(*command).tip_edge_length.has_value());
  EXPECT_EQ(std::get<sheet::Cut>(*command).tip_grading, 1.5);
  EXPECT_FALSE(std::get<sheet::Cut>(*command).tolerance_m.has_value());
  EXPECT_TRUE(std::get<sheet::Cut>(*command).relax);
  EXPECT_FALSE(std::get<sheet::Cut>(*command).width.has_value());
}

TEST(CommandCodec, FineQualityIsAnAngle) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_circle()->set_radius_m(0.1);
  cut.set_quality(v1::Cut::FINE);
  const Result<sheet::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok());
  EXPECT_EQ(std::get<sheet::Cut>(*command).min_angle_deg, 25.0);
}

TEST(ReplyCodec, QualityAndCornersOfACutAreAllTold) {
  sheet::CommandReply reply;
  reply.cut.emplace();
  cut::CutReport& report = reply.cut->report;
  report.refinement_stopped = true;
  report.closed_gaps = 4;
  report.widest_gap_m = 2.5e-5;
  report.merged_segments = 6;
  report.quality = {9, 3.5, 30.25, 6.5, 2.5, 4.5, 1.75, 1e-4, 7, 2, {{{0.25, -0.5}, 12.5, 3}, {{1.0, 2.0}, 33.0, 1}},
                    5};
  const v1::CutResult result = encode_cut_result(reply, *reply.cut);
  EXPECT_EQ(result.min_angle_deg(), 3.5);
  EXPECT_TRUE(result.refinement_stopped());
  EXPECT_EQ(result.closed_gaps(), 4);
  EXPECT_EQ(result.widest_gap_m(), 2.5e-5);
  EXPECT_EQ(result.merged_segments(), 6);
  const v1::CutQuality& quality = result.quality();
  EXPECT_EQ(quality.mean_min_angle_deg(), 30.25);
  EXPECT_EQ(quality.max_aspect(), 6.5);
  EXPECT_EQ(quality.mean_aspect(), 2.5);
  EXPECT_EQ(quality.max_edge_ratio(), 4.5);
  EXPECT_EQ(quality.mean_edge_ratio(), 1.75);
  EXPECT_EQ(quality.min_height_m(), 1e-4);
  EXPECT_EQ(quality.below_angle(), 7);
  EXPECT_EQ(quality.below_contract(), 2);
  EXPECT_EQ(quality.corners_total(), 5);
  ASSERT_EQ(quality.corners_size(), 2);
  EXPECT_EQ(quality.corners(0).position().x(), 0.25);
  EXPECT_EQ(quality.corners(0).position().y(), -0.5);
  EXPECT_EQ(quality.corners(0).angle_deg(), 12.5);
  EXPECT_EQ(quality.corners(0).elements_below(), 3);
}

v1::Cut cut_on_a_picture() {
  v1::Cut cut;
  v1::Circle& circle = *cut.mutable_curve()->mutable_circle();
  circle.mutable_center()->set_x(300.0);
  circle.mutable_center()->set_y(200.0);
  circle.set_radius_m(40.0);
  v1::View& view = *cut.mutable_view();
  view.mutable_camera()->mutable_eye()->set_y(-2.0);
  view.mutable_camera()->set_vertical_fov_deg(50.0);
  view.set_width_px(640.0);
  view.set_height_px(480.0);
  return cut;
}

TEST(CommandCodec, CamerasAndMatricesAreOneView) {
  v1::Cut cut = cut_on_a_picture();
  cut.mutable_view()->set_layers(v1::View::DEPTH_RANGE);
  cut.mutable_view()->set_nearest_m(1.5);
  cut.mutable_view()->set_farthest_m(2.5);
  cut.mutable_view()->set_piece(4);
  const Result<sheet::Command> command = decode_cut(cut);
  ASSERT_TRUE(command.ok()) << command.error().message;
  const cut::View& view = *std::get<sheet::Cut>(*command).view;
  EXPECT_EQ(view.layers, cut::LayerRule::kDepthRange);
  EXPECT_EQ(view.piece, 4);
  // The camera stands at y = -2 and looks along y with z up: the target is 2 m before it, in the middle.
  const Eigen::Vector4d target = view.view * Eigen::Vector4d(0.0, 0.0, 0.0, 1.0);
  EXPECT_NEAR(target.z(), -2.0, 1e-12);
  const Eigen::Vector4d top =
      view.projection * (view.view * Eigen::Vector4d(0.0, 0.0, 2.0 * std::tan(0.43633231), 1.0));
  EXPECT_NEAR(top.x() / top.w(), 0.0, 1e-12);
  EXPECT_NEAR(top.y() / top.w(), 1.0, 1e-6);
  // It is told as matrices, which mean the same again.
  const v1::Command told = encode_command(*command);
  EXPECT_EQ(told.cut().view().view_size(), 16);
  EXPECT_EQ(told.cut().view().projection_size(), 16);
  EXPECT_FALSE(told.cut().view().has_camera());
  const Result<sheet::Command> again = decode_command(told);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(std::get<sheet::Cut>(*again).view->view, view.view);
  EXPECT_EQ(std::get<sheet::Cut>(*again).view->projection, view.projection);
  expect_equal(encode_command(*again), told);
}

TEST(CommandCodec, BadViewsAreRefusedByName) {
  const auto reason = [](const std::function<void(v1::Cut&)>& spoil) {
    v1::Cut cut = cut_on_a_picture();
    spoil(cut);
    const Result<sheet::Command> command = decode_cut(cut);
    return command.ok() ? std::string("accepted") : command.error().reason + " " + command.error().field;
  };
  EXPECT_EQ(reason([](v1::Cut&) {}), "accepted");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->clear_camera(); }), "FIELD_MISSING cut.view.camera");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->add_view(1.0); }), "CHOICE_MISSING cut.view.camera");
  EXPECT_EQ(reason([](v1::Cut& c) {
              c.mutable_view()->clear_camera();
              c.mutable_view()->mutable_view()->Resize(15, 0.0);
            }),
            "MATRIX_SIZE cut.view.view");
  EXPECT_EQ(reason([](v1::Cut& c) {
              c.mutable_view()->clear_camera();
              c.mutable_view()->mutable_view()->Resize(16, 0.0);
            }),
            "MATRIX_SIZE cut.view.projection");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->mutable_camera()->mutable_eye()->set_y(0.0); }),
            "CAMERA_SINGULAR cut.view.camera.up");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->mutable_camera()->set_vertical_fov_deg(180.0); }),
            "FOV_OUT_OF_RANGE cut.view.camera.vertical_fov_deg");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->set_layers(static_cast<v1::View::Layers>(9)); }),
            "UNKNOWN_ENUM_VALUE cut.view.layers");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_view()->set_width_px(0.0); }), "VIEWPORT_OUT_OF_RANGE cut.view.width_px");
  EXPECT_EQ(reason([](v1::Cut& c) { c.mutable_fit(); }), "FIT_WITH_VIEW cut.fit");
}

sheet::Recording sample_recording() {
  sheet::Recording recording;
  recording.config = decoded(full_scene());
  SeededRandom random(8);
  for (std::int64_t tick = 1; tick <= 20; ++tick) {
    sheet::RecordedTick entry{tick, {}, random.next()};
    if (tick % 5 == 0) entry.commands.push_back(recording.config.commands[static_cast<std::size_t>(tick / 5)].command);
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

std::string encode(const sheet::Recording& recording) {
  std::string file = encode_recording_header(recording.config, "0.1.0 g++");
  for (const sheet::RecordedTick& entry : recording.entries) file += encode_recorded_tick(entry);
  return file;
}

TEST(RecordingCodec, ComesBackUnchanged) {
  const sheet::Recording recording = sample_recording();
  const std::string file = encode(recording);
  const Result<RecordingFile> read = decode_recording(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->build, "0.1.0 g++");
  ASSERT_EQ(read->recording.entries.size(), 20U);
  EXPECT_EQ(read->recording.entries[3].state_hash, recording.entries[3].state_hash);
  EXPECT_EQ(read->recording.entries[4].commands.size(), 1U);
  EXPECT_EQ(encode(read->recording), file);
}

TEST(RecordingCodec, EveryTruncationIsRefusedWithItsOffset) {
  const sheet::Recording recording = sample_recording();
  const std::string file = encode(recording);
  std::size_t boundary = encode_recording_header(recording.config, "0.1.0 g++").size();
  std::vector<std::size_t> boundaries{boundary};
  for (const sheet::RecordedTick& entry : recording.entries) {
    boundaries.push_back(boundary += encode_recorded_tick(entry).size());
  }
  std::size_t start = 0;  // of the message that the cut goes through
  for (std::size_t length = 0; length < file.size(); ++length) {
    const Result<RecordingFile> read = decode_recording(std::string_view(file).substr(0, length));
    if (std::find(boundaries.begin(), boundaries.end(), length) != boundaries.end()) {
      ASSERT_TRUE(read.ok()) << length << ": a recording that was stopped between two ticks is whole";
      start = length;
      continue;
    }
    ASSERT_FALSE(read.ok()) << length;
    EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
    EXPECT_EQ(read.error().reason, "RECORDING_TRUNCATED");
    EXPECT_EQ(read.error().field, "offset " + std::to_string(start)) << length;
  }
}

TEST(RecordingCodec, DamageIsRefusedOrChangesOnlyWhatItHits) {
  discard_protobuf_log();
  const std::string file = encode(sample_recording());
  int refused = 0;
  for (std::size_t at = 0; at < file.size(); ++at) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x80);
    const Result<RecordingFile> read = decode_recording(damaged);
    if (read.ok()) continue;  // a number or text that still is one: replay finds it by its hash
    ++refused;
    EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
    EXPECT_THAT(read.error().field, HasSubstr("offset "));
  }
  EXPECT_GT(refused, 50);
}

TEST(RecordingCodec, OtherFilesAreNoRecordings) {
  EXPECT_EQ(decode_recording("").error().reason, "RECORDING_TRUNCATED");
  EXPECT_EQ(decode_recording(std::string("\x02\x7b\x7d", 3)).error().reason, "RECORDING_FORMAT");
  v1::RecordingHeader header;
  header.set_magic("kerf-recording");
  header.set_format_version(3);
  std::string file(1, static_cast<char>(header.ByteSizeLong()));
  header.AppendToString(&file);
  EXPECT_EQ(decode_recording(file).error().reason, "RECORDING_FORMAT");
  EXPECT_THAT(decode_recording(file).error().message, HasSubstr("version 3"));
}

TEST(RecordingCodec, FilesOfVersionOneAreReadAsWell) {
  v1::RecordingHeader header;
  header.set_magic("kerf-recording");
  header.set_format_version(1);
  header.mutable_scene()->mutable_grid()->set_columns(2);
  header.mutable_scene()->mutable_grid()->set_rows(2);
  header.mutable_scene()->mutable_grid()->set_width_m(1.0);
  header.mutable_scene()->mutable_grid()->set_height_m(1.0);
  ASSERT_LT(header.ByteSizeLong(), 128U);
  std::string file(1, static_cast<char>(header.ByteSizeLong()));
  header.AppendToString(&file);
  const Result<RecordingFile> read = decode_recording(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->recording.entries.empty());
}

TEST(ErrorCodec, StatusHasTheStandardDetails) {
  google::rpc::Status status;
  const Error bad = invalid_argument("CURVE_NOT_FINITE", "x is not finite", "cut.curve.circle.center.x");
  ASSERT_TRUE(status.ParseFromString(encode_status(bad)));
  EXPECT_EQ(status.code(), 3);
  EXPECT_EQ(status.message(), "x is not finite");
  ASSERT_EQ(status.details_size(), 2);
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(status.details(0).UnpackTo(&info));
  EXPECT_EQ(info.reason(), "CURVE_NOT_FINITE");
  EXPECT_EQ(info.domain(), "kerf");
  google::rpc::BadRequest request;
  ASSERT_TRUE(status.details(1).UnpackTo(&request));
  EXPECT_EQ(request.field_violations(0).field(), "cut.curve.circle.center.x");

  const Error full{ErrorCode::kResourceExhausted, "QUEUE_FULL", "64 commands wait", {}};
  ASSERT_TRUE(status.ParseFromString(encode_status(full)));
  EXPECT_EQ(status.code(), 8);
  google::rpc::RetryInfo retry;
  ASSERT_EQ(status.details_size(), 2);
  ASSERT_TRUE(status.details(1).UnpackTo(&retry));
  EXPECT_EQ(retry.retry_delay().nanos(), 100'000'000);
  EXPECT_THAT(error_to_json(full), HasSubstr("\"reason\":\"QUEUE_FULL\""));
  EXPECT_THAT(error_to_json(full), HasSubstr("\"retry_delay\":\"0.100s\""));
}

TEST(ErrorCodec, CodesAreThoseOfGrpc) {
  EXPECT_EQ(status_code(ErrorCode::kNotFound), 5);
  EXPECT_EQ(status_code(ErrorCode::kAlreadyExists), 6);
  EXPECT_EQ(status_code(ErrorCode::kFailedPrecondition), 9);
  EXPECT_EQ(status_code(ErrorCode::kAborted), 10);
  EXPECT_EQ(status_code(ErrorCode::kInternal), 13);
  EXPECT_EQ(status_code(ErrorCode::kUnavailable), 14);
  EXPECT_EQ(status_code(ErrorCode::kDataLoss), 15);
  EXPECT_EQ(status_name(ErrorCode::kDataLoss), "DATA_LOSS");
}

TEST(Json, SceneComesBackUnchangedInBothSpellings) {
  const v1::Scene scene = full_scene();
  const std::string json = to_json(scene);
  EXPECT_THAT(json, HasSubstr("\"tick_rate_hz\":"));
  v1::Scene back;
  ASSERT_TRUE(from_json(json, back).ok());
  expect_equal(back, scene);
  ASSERT_TRUE(from_json(R"({"tickRateHz": 30, "grid": {"widthM": 2.5}})", back).ok());
  EXPECT_EQ(back.tick_rate_hz(), 30.0);
  EXPECT_EQ(back.grid().width_m(), 2.5);
}

TEST(Json, DefaultsArePrinted) {
  const std::string json = to_json(v1::CutResult());
  EXPECT_THAT(json, HasSubstr("\"new_vertices\":0"));
  EXPECT_THAT(json, HasSubstr("\"state_hash\":\"\""));
}

struct BadJson {
  const char* text;
  const char* reason;
  const char* field;
  const char* where;
};

TEST(Json, FaultsNameLineColumnAndField) {
  const std::vector<BadJson> cases = {
      {"{\n  \"grid\": {\"colums\": 3}\n}", "JSON_UNKNOWN_FIELD", "grid.colums", "line 2, column 12"},
      {"{\"pins\": [{\"edge\": \"TOP\"},\n {\"edge\": \"TOPP\"}]}", "JSON_TYPE", "pins[1].edge", "line 2, column 11"},
      {"{\"grid\": {\"columns\": 3.5}}", "JSON_TYPE", "grid.columns", "line 1, column 22"},
      {"{\"grid\": {\"columns\": 3000000000}}", "JSON_TYPE", "grid.columns", "line 1"},
      {"{\"grid\": {\"columns\": \"many\"}}", "JSON_TYPE", "grid.columns", "line 1"},
      {"{\"grid\": 3}", "JSON_TYPE", "grid", "line 1, column 10"},
      {"{\"pins\": {}}", "JSON_TYPE", "pins", "line 1"},
      {"{\"sheet_id\": 3}", "JSON_TYPE", "sheet_id", "line 1"},
      {"{\"tick_rate_hz\": [1]}", "JSON_TYPE", "tick_rate_hz", "line 1"},
      {"{\"sheet_id\": \"a\", \"sheetId\": \"b\"}", "JSON_DUPLICATE_FIELD", "sheet_id", "line 1, column 19"},
      {"{\"grid\": {},\n\"obj\": {}}", "JSON_DUPLICATE_FIELD", "obj", "line 2, column 1"},
      {"{\"grid\": {}", "JSON_SYNTAX", "", "line 1, column 12"},
      {"{\"grid\": {} \"obj\": {}}", "JSON_SYNTAX", "", "expected , or }"},
      {"{\"grid\" {}}", "JSON_SYNTAX", "grid", "expected :"},
      {"{} {}", "JSON_SYNTAX", "", "after the end"},
      {"{\"sheet_id\": \"a", "JSON_SYNTAX", "sheet_id", "without end"},
      {"", "JSON_TYPE", "", "line 1, column 1"},
      {"[]", "JSON_TYPE", "", "expected an object"},
  };
  for (const BadJson& bad : cases) {
    v1::Scene scene;
    const Status status = from_json(bad.text, scene);
    ASSERT_FALSE(status.ok()) << bad.text;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(status.error().reason, bad.reason) << bad.text << ": " << status.error().message;
    EXPECT_EQ(status.error().field, bad.field) << bad.text << ": " << status.error().message;
    EXPECT_THAT(status.error().message, HasSubstr(bad.where)) << bad.text;
  }
}

TEST(Json, NoTruncationOrByteFlipGetsThroughUnnoticedOrCrashes) {
  const std::string json = to_json(full_scene());
  v1::Scene scene;
  for (std::size_t length = 0; length < json.size(); length += 7) {
    EXPECT_FALSE(from_json(std::string_view(json).substr(0, length), scene).ok()) << length;
  }
  SeededRandom random(9);
  for (int round = 0; round < 2000; ++round) {
    std::string damaged = json;
    damaged[random.below(damaged.size())] = static_cast<char>(random.below(256));
    const Status status = from_json(damaged, scene);
    EXPECT_TRUE(status.ok() || status.error().code == ErrorCode::kInvalidArgument);
  }
}

TEST(Json, MapsAreObjectsWhoseNamesAreFree) {
  v1::RunResult result;
  (*result.mutable_flagged_ticks())["substepped"] = 3;
  (*result.mutable_flagged_ticks())["not_converged"] = 12;
  v1::RunResult read;
  ASSERT_TRUE(from_json(to_json(result), read).ok());
  // Not by MessageDifferencer: under the thread sanitizer maps have another layout than in Debian's library, which it
  // reads.
  ASSERT_EQ(read.flagged_ticks_size(), 2);
  EXPECT_EQ(read.flagged_ticks().at("substepped"), 3);
  EXPECT_EQ(read.flagged_ticks().at("not_converged"), 12);
  ASSERT_TRUE(from_json(R"({"flagged_ticks": {}})", read).ok());
  EXPECT_TRUE(read.flagged_ticks().empty());
  const auto refusal = [](const char* json) {
    v1::RunResult message;
    const Status status = from_json(json, message);
    return status.ok() ? "fine" : status.error().reason + " " + status.error().field;
  };
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a": 1.5}})"), "JSON_TYPE flagged_ticks.a");
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a": 1, "a": 2}})"), "JSON_DUPLICATE_FIELD flagged_ticks.a");
  EXPECT_EQ(refusal(R"({"flagged_ticks": [1]})"), "JSON_TYPE flagged_ticks");
  EXPECT_EQ(refusal(R"({"flagged_ticks": {"a" 1}})"), "JSON_SYNTAX flagged_ticks.a");
}

TEST(ReplyCodec, TellsOfFlagsThatWereReported) {
  fem::FlagCounts counts{};
  fem::count_flags(fem::kSubstepped | fem::kDamped, counts);
  fem::count_flags(fem::kDamped, counts);
  v1::RunResult message;
  encode_flags(counts, *message.mutable_flagged_ticks());
  EXPECT_EQ(message.flagged_ticks().size(), 2U);
  EXPECT_EQ(message.flagged_ticks().at("substepped"), 1);
  EXPECT_EQ(message.flagged_ticks().at("damped"), 2);
}

TEST(Json, NotANumberReachesValidation) {
  const Result<sheet::SheetConfig> config =
      decode_scene_file(R"({"grid": {"columns": 3, "rows": 3, "width_m": "NaN", "height_m": 1}})", {});
  ASSERT_FALSE(config.ok());
  EXPECT_EQ(config.error().field, "grid.width_m");
}

TEST(ReplyCodec, CutResultHoldsTheReport) {
  sheet::CommandReply reply;
  reply.tick = 12;
  reply.topology_version = 3;
  reply.state_hash = 0xabc;
  reply.cut.emplace();
  reply.cut->status = cut::CutStatus::kApplied;
  reply.cut->report.pieces = 2;
  reply.cut->report.new_vertices = 40;
  reply.cut->report.deviation_m = 1e-4;
  reply.cut->warnings = {"one gap closed"};
  const v1::CutResult result = encode_cut_result(reply, *reply.cut);
  EXPECT_EQ(result.status(), v1::CutResult::APPLIED);
  EXPECT_EQ(result.tick(), 12);
  EXPECT_EQ(result.pieces(), 2);
  EXPECT_EQ(result.new_vertices(), 40);
  EXPECT_EQ(result.deviation_m(), 1e-4);
  EXPECT_EQ(result.state_hash(), "0000000000000abc");
  EXPECT_EQ(result.warnings(0), "one gap closed");
}

TEST(ReplyCodec, TellsOfPiecesAndOfEveryCutOfABatch) {
  sheet::CommandReply reply;
  reply.batch.resize(2);
  reply.batch[1].status = cut::CutStatus::kApplied;
  sheet::Piece piece;
  piece.birth = {7, 2, 3};
  piece.label = 1;
  piece.num_triangles = 12;
  piece.area = 0.25;
  piece.mass = 0.1;
  piece.centroid = {0.5, 0.125};
  piece.world_centroid = {1.0, 2.0, 3.0};
  reply.batch[1].split_pieces = {{2, {piece, piece}}};
  const std::vector<v1::CutResult> results = encode_cut_results(reply);
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].status(), v1::CutResult::NO_INTERSECTION);
  ASSERT_EQ(results[1].split_pieces_size(), 1);
  EXPECT_EQ(results[1].split_pieces(0).piece(), 2);
  ASSERT_EQ(results[1].split_pieces(0).children_size(), 2);
  const v1::Piece& child = results[1].split_pieces(0).children(0);
  EXPECT_EQ(child.id(), 7);
  EXPECT_EQ(child.parent(), 2);
  EXPECT_EQ(child.cut_number(), 3);
  EXPECT_EQ(child.label(), 1);
  EXPECT_EQ(child.num_triangles(), 12);
  EXPECT_EQ(child.area_m2(), 0.25);
  EXPECT_EQ(child.mass_kg(), 0.1);
  EXPECT_EQ(child.centroid().y(), 0.125);
  EXPECT_EQ(child.world_centroid().z(), 3.0);
  EXPECT_TRUE(encode_cut_results({}).empty());
}

}  // namespace
}  // namespace kerf::wire
