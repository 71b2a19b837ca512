#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/core/sheet/sheet.h"
#include "server/service/wire/json.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/scene_codec.h"
#include "tests/support/mesh_files.h"
#include "tests/support/meshes.h"
#include "tests/wire/bad_scenes.h"
#include "tests/wire/codec_checks.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;
using testing::set_outline;

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
  v1::MeshReading& reading = *scene.mutable_obj()->mutable_reading();
  reading.set_reader_version(mesh::kNewestReader);
  expect_equal(encode_scene(decoded(scene)), scene);
  reading.set_unit_m(1e-3);
  reading.set_up_axis(v1::MeshReading::Y_UP);
  reading.set_join_m(0.0);
  reading.set_ignore_texture_coordinates(true);
  reading.add_objects("left");
  reading.set_reader_version(mesh::kFirstReader);
  expect_equal(encode_scene(decoded(scene)), scene);
  scene.mutable_ply()->set_data(test::write_ply(test::one_triangle(), test::PlyKind::kBigEndian));
  scene.mutable_ply()->mutable_reading()->set_reader_version(mesh::kNewestReader);
  expect_equal(encode_scene(decoded(scene)), scene);
  set_outline(scene);
  expect_equal(encode_scene(decoded(scene)), scene);
  v1::Scene from_file;  // bytes of every value are base64 in a scene file
  scene.mutable_ply()->set_data(std::string("ply\n\0\xff", 6));
  ASSERT_TRUE(from_json(to_json(scene), from_file).ok());
  expect_equal(from_file, scene);
}

TEST(SceneCodec, ReadingsOfMeshFilesAreChecked) {
  const auto refused = [](const std::function<void(v1::MeshReading&)>& change) {
    v1::Scene scene;
    scene.mutable_obj()->set_text("v 0 0 0\n");
    change(*scene.mutable_obj()->mutable_reading());
    const Result<scene::SheetConfig> config = decode_scene(scene);
    return config.ok() ? std::string() : config.error().field;
  };
  EXPECT_EQ(refused([](v1::MeshReading& reading) { reading.set_unit_m(1e-3); }), "");
  EXPECT_EQ(refused([](v1::MeshReading& reading) { reading.set_unit_m(-1.0); }), "obj.reading.unit_m");
  EXPECT_EQ(refused([](v1::MeshReading& reading) { reading.set_join_m(2e4); }), "obj.reading.join_m");
  EXPECT_EQ(refused([](v1::MeshReading& reading) { reading.set_reader_version(mesh::kNewestReader + 1); }),
            "obj.reading.reader_version");
  EXPECT_EQ(refused([](v1::MeshReading& reading) { reading.set_up_axis(static_cast<v1::MeshReading::UpAxis>(9)); }),
            "obj.reading.up_axis");
  EXPECT_EQ(refused([](v1::MeshReading& reading) {
              for (int i = 0; i <= 64; ++i) reading.add_objects("a");
            }),
            "obj.reading.objects");
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
  const Result<scene::SheetConfig> most = decode_scene(scene);
  ASSERT_TRUE(most.ok()) << most.error().message;
  EXPECT_EQ(std::get<scene::StaticAnalysis>(most->analysis).loads.size(), 10'000U);
  EXPECT_TRUE(scene::validate(most->analysis).ok());
  analysis->set_steps(10'001);
  EXPECT_EQ(decode_scene(scene).error().field, "analysis.static.steps");
}

TEST(SceneCodec, BendingThatIsNotGivenStaysDerived) {
  v1::Scene scene = full_scene();
  scene.mutable_material()->clear_bending_coupling_nm();
  scene.mutable_material()->clear_twisting_stiffness_nm();
  const scene::SheetConfig config = decoded(scene);
  EXPECT_EQ(config.material.bending_stiffness_1, 2.0e-6);
  EXPECT_EQ(config.material.twisting_stiffness, std::nullopt);
  expect_equal(encode_scene(config), scene);
}

TEST(SceneCodec, SelfContactComesBackUnchanged) {
  v1::Scene scene = full_scene();
  scene.mutable_integrator()->set_kind(v1::Integrator::AUTOMATIC);
  scene.set_planar(false);
  for (const double friction : {0.0, 0.3, 10.0}) {
    scene.mutable_self_contact()->set_mode(v1::SelfContact::ON);
    scene.mutable_self_contact()->set_friction(friction);
    scene.mutable_self_contact()->set_thickness_m(0.1);
    const scene::SheetConfig config = decoded(scene);
    EXPECT_TRUE(config.self_contact.is_on);
    EXPECT_EQ(config.self_contact.friction, friction);
    EXPECT_EQ(config.self_contact.thickness, 0.1);
    expect_equal(encode_scene(config), scene);
  }
}

TEST(SceneCodec, SelfContactIsOffUnlessAskedForAndThenNotEncoded) {
  v1::Scene scene = full_scene();
  scene.clear_self_contact();
  expect_equal(encode_scene(decoded(scene)), scene);
  EXPECT_EQ(decoded(scene).self_contact, scene::SelfContact{});
  scene.mutable_self_contact();
  EXPECT_EQ(decoded(scene).self_contact, scene::SelfContact{});
  ASSERT_TRUE(from_json(R"({"grid": {"columns": 3, "rows": 3, "width_m": 1, "height_m": 1},
                            "self_contact": {"mode": "ON", "friction": 0.5}})",
                        scene)
                  .ok());
  EXPECT_TRUE(decoded(scene).self_contact.is_on);
  EXPECT_EQ(decoded(scene).self_contact.friction, 0.5);
  EXPECT_EQ(decoded(scene).integrator.kind, scene::IntegratorKind::kAutomatic);
}

TEST(SceneCodec, EveryLinearSolverRoundTrips) {
  const v1::Scene scene = full_scene();
  for (const linear::LinearSolverName& name : linear::kLinearSolverNames) {
    scene::SheetConfig config = decoded(scene);
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
  const scene::SheetConfig config = decoded(scene);
  EXPECT_EQ(config.material, fem::find_preset("demo").value());
  EXPECT_EQ(config.membrane_law, fem::MembraneLaw::kCorotational);
  EXPECT_EQ(config.fidelity, scene::Fidelity::kExact);
  EXPECT_EQ(config.placement.origin, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(config.placement.x_axis, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(config.placement.y_axis, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(config.gravity, Eigen::Vector3d(0, 0, -9.81));
  EXPECT_EQ(config.wind.air_density, 0.0);
  EXPECT_EQ(config.tick_rate_hz, 60.0);
  EXPECT_EQ(config.integrator.max_substeps, 20000);
  EXPECT_EQ(config.integrator.newton_iterations, 2);
  EXPECT_EQ(config.integrator.solver_tolerance, 1e-4);
  EXPECT_EQ(config.integrator.solver, scene::LinearSolverKind::kBlockJacobiCg);
  EXPECT_EQ(config.integrator.max_linear_iterations, 1000);
  EXPECT_EQ(config.integrator.covariance_root.norm, scene::EigenvalueNorm::kPower);
  EXPECT_EQ(config.integrator.covariance_root.power, 0.5);
  EXPECT_EQ(config.integrator.covariance_root.newton_schulz_iterations, 5);
  EXPECT_EQ(config.integrator.highest_mode_damping, 0.05);
  EXPECT_EQ(config.integrator.precision, scene::Precision::kMixed);
  scene.mutable_integrator()->set_highest_mode_damping(0.0);
  EXPECT_EQ(decoded(scene).integrator.precision, scene::Precision::kDouble);
  scene.mutable_integrator()->set_precision(v1::Integrator::MIXED);
  EXPECT_EQ(decoded(scene).integrator.precision, scene::Precision::kMixed);
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
  const auto outline = std::get<scene::OutlineSource>(decoded(scene).mesh);
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
  const Result<scene::SheetConfig> config = decode_scene(scene, reader);
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
    const Result<scene::SheetConfig> config = decode_scene(scene);
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
  const Result<scene::SheetConfig> refused = decode_scene(scene);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "OBJ_FILE_REFUSED");
  EXPECT_EQ(refused.error().field, "obj.file");
  std::string asked;
  const FileReader reader = [&asked](const std::string& path) -> Result<std::string> {
    asked = path;
    if (path == "flag.obj") return std::string("v 0 0 0\n");
    return Error{ErrorCode::kNotFound, "FILE_NOT_FOUND", "no such file", {}};
  };
  const Result<scene::SheetConfig> read = decode_scene(scene, reader);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(asked, "flag.obj");
  EXPECT_EQ(std::get<scene::ObjSource>(read->mesh).text, "v 0 0 0\n");
  scene.mutable_obj()->set_file("none.obj");
  EXPECT_EQ(decode_scene(scene, reader).error().field, "obj.file");
  scene.mutable_obj()->set_text("v 0 0 0\n");
  EXPECT_EQ(decode_scene(scene, reader).error().reason, "OBJ_TWICE");
  scene.mutable_ply()->set_file("flag.obj");
  EXPECT_EQ(decode_scene(scene).error().reason, "PLY_FILE_REFUSED");
  EXPECT_EQ(decode_scene(scene).error().field, "ply.file");
  EXPECT_NE(decode_scene(scene).error().message.find("ply.data"), std::string::npos);
  EXPECT_EQ(std::get<scene::PlySource>(decode_scene(scene, reader)->mesh).data, "v 0 0 0\n");
  scene.mutable_ply()->set_data("ply");
  EXPECT_EQ(decode_scene(scene, reader).error().reason, "PLY_TWICE");
}

TEST(SceneCodec, MeshFilesAreMovedOutOfASceneThatIsHandedOver) {
  v1::Scene scene;
  scene.mutable_obj()->set_text(std::string(1000, '#'));
  const char* const text = scene.obj().text().data();
  const scene::SheetConfig obj = decode_scene(std::move(scene)).value();
  EXPECT_EQ(static_cast<const void*>(std::get<scene::ObjSource>(obj.mesh).text.data()), text);
  v1::Scene other;
  other.mutable_ply()->set_data(std::string(1000, 'p'));
  const char* const data = other.ply().data().data();
  const scene::SheetConfig ply = decode_scene(std::move(other)).value();
  EXPECT_EQ(static_cast<const void*>(std::get<scene::PlySource>(ply.mesh).data.data()), data);
}

TEST(SceneCodec, RestShapesOfMeshFiles) {
  const std::vector<std::pair<v1::RestShape, scene::RestShape>> all{
      {v1::REST_SHAPE_UNSPECIFIED, scene::RestShape::kAutomatic},
      {v1::REST_SHAPE_FLAT, scene::RestShape::kFlat},
      {v1::REST_SHAPE_SURFACE, scene::RestShape::kSurface}};
  for (const auto& [name, rest_shape] : all) {
    v1::Scene scene;
    scene.mutable_obj()->set_text("v 0 0 0\n");
    scene.mutable_obj()->set_rest_shape(name);
    const scene::MeshSource obj = decode_scene(scene).value().mesh;
    EXPECT_EQ(std::get<scene::ObjSource>(obj).reading.rest_shape, rest_shape);
    v1::Scene again;
    encode_mesh_source(obj, again);
    EXPECT_EQ(again.obj().rest_shape(), name);
    scene.mutable_ply()->set_data("ply\n");
    scene.mutable_ply()->set_rest_shape(name);
    const scene::MeshSource ply = decode_scene(scene).value().mesh;
    EXPECT_EQ(std::get<scene::PlySource>(ply).reading.rest_shape, rest_shape);
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
  const scene::MeshSource source = decode_scene(scene).value().mesh;
  EXPECT_EQ(std::get<scene::ArraySource>(source).rest_positions.col(2), Eigen::Vector3d(0.0, 1.0, 0.5));
  EXPECT_EQ(std::get<scene::ArraySource>(source).material_positions.cols(), 0);
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
  const Result<scene::SheetConfig> read = decode_scene(scene, reader);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(encode_scene(*read).obj().text(), "o T\xC3\xBCr\nv 0 0 0\n");
}

}  // namespace
}  // namespace kerf::wire
