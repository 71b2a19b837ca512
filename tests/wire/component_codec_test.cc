// Components of a scene as messages.
#include "server/service/wire/component_codec.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/sheet/sheet.h"
#include "server/service/wire/json.h"
#include "server/service/wire/scene_codec.h"
#include "tests/wire/codec_checks.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

constexpr const char* kClothAndRibbon = R"({
  "components": [
    {"name": "cloth", "grid": {"columns": 11, "rows": 11, "width_m": 1, "height_m": 1}},
    {"name": "ribbon", "grid": {"columns": 11, "rows": 3, "width_m": 1, "height_m": 0.2},
     "placement": {"origin": {"z": 0.5}}, "offset": {"x": 2, "y": 0.25}, "material": {"preset": "silk"},
     "materials": [{"region": {"box": {"max": {"x": 0.5, "y": 1}}}, "material": {"preset": "denim"}}]}
  ],
  "material": {"preset": "wool"},
  "materials": [{"region": {"box": {"max": {"x": 0.3, "y": 0.3}}}, "material": {"preset": "demo"}}],
  "pins": [{"edge": "LEFT", "component": "ribbon"}],
  "commands": [
    {"tick": 1, "command": {"cut": {"curve": {"circle": {"center": {"x": 0.5, "y": 0.1}, "radius_m": 0.05}},
                                    "component": "ribbon"}}},
    {"tick": 2, "command": {"cut_batch": {"cuts": [
      {"curve": {"circle": {"radius_m": 1}}}, {"curve": {"circle": {"radius_m": 1}}, "component": "cloth"}]}}},
    {"tick": 3, "command": {"set_pins": {"pins": [{"all": true, "component": "cloth"}]}}}
  ]
})";

v1::Scene cloth_and_ribbon() {
  v1::Scene scene;
  EXPECT_TRUE(from_json(kClothAndRibbon, scene).ok());
  return scene;
}

sheet::Sheet made(const v1::Scene& scene) {
  Result<sheet::Sheet> sheet = sheet::Sheet::create(decoded(scene));
  EXPECT_TRUE(sheet.ok()) << sheet.error().message;
  return std::move(sheet).value();
}

TEST(ComponentCodec, DecodesWhatEachHasOfItsOwn) {
  const scene::SheetConfig config = decoded(cloth_and_ribbon());
  ASSERT_EQ(config.components.size(), 2U);
  EXPECT_EQ(config.components[0].name, "cloth");
  EXPECT_EQ(std::get<scene::GridSource>(config.components[0].mesh).rows, 11);
  EXPECT_FALSE(config.components[0].placement.has_value());
  EXPECT_FALSE(config.components[0].offset.has_value());
  EXPECT_EQ(config.components[1].placement->origin, Eigen::Vector3d(0.0, 0.0, 0.5));
  EXPECT_EQ(config.components[1].offset, Eigen::Vector2d(2.0, 0.25));
  EXPECT_EQ(config.material, fem::find_preset("wool").value());
  ASSERT_EQ(config.materials.size(), 3U) << "those of components come first";
  EXPECT_TRUE(std::holds_alternative<scene::WholeSheet>(config.materials[0].region.shape));
  EXPECT_EQ(config.materials[0].region.component, "ribbon");
  EXPECT_EQ(config.materials[0].material, fem::find_preset("silk").value());
  EXPECT_EQ(config.materials[1].region.component, "ribbon");
  EXPECT_EQ(config.materials[1].material, fem::find_preset("denim").value());
  EXPECT_EQ(config.materials[2].region.component, "");
  EXPECT_EQ(config.pins[0].component, "ribbon");
  EXPECT_EQ(std::get<scene::Cut>(config.commands[0].command).component, "ribbon");
  EXPECT_EQ(std::get<scene::CutBatch>(config.commands[1].command).cuts[1].component, "cloth");
  EXPECT_EQ(std::get<scene::SetPins>(config.commands[2].command).pins[0].component, "cloth");
}

TEST(ComponentCodec, ComesBackWithItsMaterialsAsPartsOfTheScene) {
  const v1::Scene encoded = encode_scene(decoded(cloth_and_ribbon()));
  EXPECT_EQ(encoded.mesh_case(), v1::Scene::MESH_NOT_SET);
  EXPECT_FALSE(encoded.has_placement());
  EXPECT_EQ(encoded.components_size(), 2);
  EXPECT_FALSE(encoded.components(1).has_material());
  ASSERT_EQ(encoded.materials_size(), 3);
  EXPECT_EQ(encoded.materials(0).region().component(), "ribbon");
  EXPECT_TRUE(encoded.materials(0).region().all());
  expect_equal(encode_scene(decoded(encoded)), encoded);
  EXPECT_EQ(made(cloth_and_ribbon()).state_hash(), made(encoded).state_hash());
}

TEST(ComponentCodec, EveryMeshComesBackUnchanged) {
  v1::Scene scene = encode_scene(decoded(cloth_and_ribbon()));
  v1::Component& component = *scene.mutable_components(0);
  component.mutable_obj()->set_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  component.mutable_obj()->mutable_reading()->set_reader_version(mesh::kNewestReader);
  expect_equal(encode_scene(decoded(scene)), scene);
  component.mutable_ply()->set_data("ply");
  component.mutable_ply()->mutable_reading()->set_reader_version(mesh::kNewestReader);
  expect_equal(encode_scene(decoded(scene)), scene);
  for (const double number : {0.0, 0.0, 1.0, 0.1, 0.3, 1.0}) {
    component.mutable_inline_()->add_material_positions(number);
  }
  for (const int number : {0, 1, 2}) component.mutable_inline_()->add_triangles(number);
  expect_equal(encode_scene(decoded(scene)), scene);
  component.mutable_outline()->mutable_boundary()->mutable_circle()->set_radius_m(1.0);
  component.mutable_outline()->set_min_angle_deg(20.0);
  component.mutable_outline()->mutable_boundary()->mutable_circle()->mutable_center();
  expect_equal(encode_scene(decoded(scene)), scene);
}

TEST(ComponentCodec, ReadsFilesOnlyWithAReader) {
  v1::Scene scene = cloth_and_ribbon();
  scene.mutable_components(1)->mutable_obj()->set_file("ribbon.obj");
  const Result<scene::SheetConfig> refused = decode_scene(scene);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "OBJ_FILE_REFUSED");
  EXPECT_EQ(refused.error().field, "components[1].obj.file");
  const auto reader = [](const std::string& /*path*/) -> Result<std::string> { return std::string("v 0 0 0\n"); };
  const Result<scene::SheetConfig> read = decode_scene(scene, reader);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(std::get<scene::ObjSource>(read->components[1].mesh).text, "v 0 0 0\n");
}

TEST(ComponentCodec, EveryBadFieldIsRefusedByName) {
  struct Bad {
    std::string field;
    std::function<void(v1::Scene&)> spoil;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Bad> all{
      {"mesh", [](v1::Scene& s) { s.mutable_grid(); }},
      {"placement", [](v1::Scene& s) { s.mutable_placement(); }},
      {"components[1].name", [](v1::Scene& s) { s.mutable_components(1)->set_name("cloth"); }},
      {"components[0].name", [](v1::Scene& s) { s.mutable_components(0)->clear_name(); }},
      {"components[0].mesh", [](v1::Scene& s) { s.mutable_components(0)->clear_mesh(); }},
      {"components[0].grid.rows", [](v1::Scene& s) { s.mutable_components(0)->mutable_grid()->set_rows(1); }},
      {"components[0].grid.pattern",
       [](v1::Scene& s) {
         s.mutable_components(0)->mutable_grid()->set_pattern(static_cast<v1::GridMesh::Pattern>(9));
       }},
      {"components[0].outline.boundary", [](v1::Scene& s) { s.mutable_components(0)->mutable_outline(); }},
      {"components[1].placement.y_axis",
       [](v1::Scene& s) {
         testing::set(s.mutable_components(1)->mutable_placement()->mutable_y_axis(), 0.0, 2.0, 0.0);
       }},
      {"components[1].offset.x", [=](v1::Scene& s) { s.mutable_components(1)->mutable_offset()->set_x(nan); }},
      {"components[1].material.preset",
       [](v1::Scene& s) { s.mutable_components(1)->mutable_material()->set_preset("stone"); }},
      {"components[1].material.thickness_m",
       [](v1::Scene& s) { s.mutable_components(1)->mutable_material()->set_thickness_m(5.0); }},
      {"components[1].materials[0].material.density_kgpm3",
       [=](v1::Scene& s) {
         s.mutable_components(1)->mutable_materials(0)->mutable_material()->set_density_kgpm3(nan);
       }},
      {"components[1].materials[0].region.region",
       [](v1::Scene& s) { s.mutable_components(1)->mutable_materials(0)->mutable_region()->clear_region(); }},
      {"components[1].materials[0].region.box.max.x",
       [=](v1::Scene& s) {
         s.mutable_components(1)->mutable_materials(0)->mutable_region()->mutable_box()->mutable_max()->set_x(nan);
       }},
      {"components[1].materials[0].region.component",
       [](v1::Scene& s) { s.mutable_components(1)->mutable_materials(0)->mutable_region()->set_component("cloth"); }},
      {"commands[0].command.cut.component",
       [](v1::Scene& s) { s.mutable_commands(0)->mutable_command()->mutable_cut()->set_component("band"); }},
      {"commands[1].command.cut_batch.cuts[0].component",
       [](v1::Scene& s) {
         s.mutable_commands(1)->mutable_command()->mutable_cut_batch()->mutable_cuts(0)->set_component("band");
       }},
      {"commands[2].command.set_pins.pins[0].component",
       [](v1::Scene& s) {
         s.mutable_commands(2)->mutable_command()->mutable_set_pins()->mutable_pins(0)->set_component("band");
       }},
      {"components",
       [](v1::Scene& s) {
         for (int i = 0; i < 63; ++i) *s.add_components() = s.components(0);
       }},
  };
  for (const Bad& bad : all) {
    v1::Scene scene = cloth_and_ribbon();
    bad.spoil(scene);
    const Result<scene::SheetConfig> config = decode_scene(scene);
    ASSERT_FALSE(config.ok()) << bad.field;
    EXPECT_EQ(config.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(config.error().field, bad.field) << config.error().message;
  }
}

TEST(ComponentCodec, PlacesOfASheetAreEncoded) {
  const sheet::Sheet sheet = made(cloth_and_ribbon());
  const v1::SheetComponent ribbon = encode_component_place(sheet.components()[1]);
  EXPECT_EQ(ribbon.name(), "ribbon");
  EXPECT_EQ(ribbon.offset().x(), 2.0);
  EXPECT_EQ(ribbon.offset().y(), 0.25);
  EXPECT_EQ(ribbon.extent().min().x(), 0.0);
  EXPECT_EQ(ribbon.extent().max().x(), 1.0);
  EXPECT_NEAR(ribbon.extent().max().y(), 0.2, 1e-15);
  EXPECT_EQ(ribbon.first_vertex(), 121);
  EXPECT_EQ(ribbon.num_vertices(), 33);
}

}  // namespace
}  // namespace kerf::wire
