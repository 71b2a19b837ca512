// Scenes of several components: their meshes become one, side by side in the material plane.
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "server/core/fem/element/state.h"
#include "server/core/scene/components.h"
#include "server/core/scene/mesh_source.h"
#include "tests/sheet/calls.h"
#include "tests/support/component_scenes.h"
#include "tests/support/shells.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using scenes::cloth_and_ribbon;
using scenes::component;
using scenes::grid;

// m^2, at rest, of the triangles of a component.
double area_of(const Sheet& sheet, std::size_t index) {
  double area = 0.0;
  const scene::ComponentPlace& place = sheet.components()[index];
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (!sheet.mesh().is_solid(t)) continue;
    const mesh::VertexId v = sheet.mesh().vertices(t)[0];
    if (v >= place.first_vertex && v < place.first_vertex + place.num_vertices) area += sheet.mesh().area(t);
  }
  return area;
}

std::string message_of(const scene::SheetConfig& config) {
  const Result<Sheet> made = Sheet::create(config);
  return made.ok() ? "made" : made.error().message;
}

TEST(Components, LieSideBySideAndAreOneSheet) {
  const Sheet sheet = make(cloth_and_ribbon());
  EXPECT_EQ(sheet.mesh().num_vertices(), 121 + 33);
  EXPECT_EQ(sheet.mesh().num_pieces(), 2);
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  ASSERT_EQ(sheet.components().size(), 2U);
  const scene::ComponentPlace& cloth = sheet.components()[0];
  const scene::ComponentPlace& ribbon = sheet.components()[1];
  EXPECT_EQ(cloth.name, "cloth");
  EXPECT_EQ(cloth.offset, Vector2d(0.0, 0.0));
  EXPECT_EQ(cloth.first_vertex, 0);
  EXPECT_EQ(cloth.num_vertices, 121);
  EXPECT_EQ(ribbon.name, "ribbon");
  EXPECT_EQ(ribbon.offset, Vector2d(1.1, 0.0)) << "a tenth of the largest side lies between them";
  EXPECT_EQ(ribbon.extent.min(), Vector2d(0.0, 0.0));
  EXPECT_NEAR((ribbon.extent.max() - Vector2d(1.0, 0.2)).norm(), 0.0, 1e-15);
  EXPECT_EQ(ribbon.first_vertex, 121);
  EXPECT_EQ(ribbon.num_vertices, 33);
  EXPECT_FALSE(ribbon.room.intersects(cloth.room));
  EXPECT_NEAR((sheet.mesh().rest_position(121 + 13) - Vector2d(1.1 + 0.2, 0.1)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((sheet.state().x.col(121 + 13) - Vector3d(1.3, 0.0, 0.1)).norm(), 0.0, 1e-12)
      << "without a placement they hang beside each other";
}

TEST(Components, OneAloneIsTheSameSheetAsItsMesh) {
  scene::SheetConfig plain = scenes::hanging_with_three_cuts(13);
  scene::SheetConfig named = plain;
  named.components = {component("cloth", plain.mesh)};
  named.mesh = scene::GridSource{};
  Sheet expected = make(plain);
  Sheet sheet = make(named);
  EXPECT_EQ(sheet.state_hash(), expected.state_hash());
  run(expected, 40);
  run(sheet, 40);
  EXPECT_EQ(sheet.num_cuts(), 3);
  EXPECT_EQ(sheet.state_hash(), expected.state_hash());
}

TEST(Components, LieWhereTheirOffsetsAndPlacementsSay) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.components[1].offset = Vector2d(0.0, -0.5);
  config.components[1].placement = scene::Placement{{0.0, 0.0, 3.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}};
  config.components.push_back(component("third", grid(3, 3, 0.5, 0.5)));
  const Sheet sheet = make(config);
  EXPECT_EQ(sheet.components()[1].offset, Vector2d(0.0, -0.5));
  EXPECT_EQ(sheet.components()[2].offset, Vector2d(1.1, 0.0)) << "on the right of all before";
  EXPECT_NEAR((sheet.mesh().rest_position(121 + 13) - Vector2d(0.2, -0.4)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((sheet.state().x.col(121 + 13) - Vector3d(0.1, 0.2, 3.0)).norm(), 0.0, 1e-12)
      << "a placement is of the component's own coordinates";
}

TEST(Components, KeepTheirOwnYAndMayBeginAnywhere) {
  scene::SheetConfig config = cloth_and_ribbon();
  scene::ArraySource triangle;
  triangle.material_positions.resize(2, 3);
  triangle.material_positions << 7.0, 8.0, 7.0, 5.0, 5.0, 6.0;
  triangle.triangles = Eigen::Vector3i(0, 1, 2);
  config.components.push_back(component("triangle", triangle));
  const Sheet sheet = make(config);
  const double right = 1.1 + 1.0 + 0.1;
  EXPECT_NEAR((sheet.components()[2].offset - Vector2d(right - 7.0, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((sheet.mesh().rest_position(154) - Vector2d(right, 5.0)).norm(), 0.0, 1e-12);
}

TEST(Components, MayHaveEveryKindOfMesh) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.components.push_back(component("obj", scene::ObjSource{"v 0 0 2\nv 1 0 2\nv 0 1 2\nf 1 2 3\n", {}}));
  scene::OutlineSource disc;
  disc.boundary = cut::Circle{{0.0, 0.0}, 0.3};
  config.components.push_back(component("disc", disc));
  scene::ArraySource slit;  // two triangles, whose common edge has vertices of its own on either side
  slit.material_positions.resize(2, 6);
  slit.material_positions << 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0;
  slit.triangles.resize(3, 2);
  slit.triangles << 0, 3, 1, 4, 2, 5;
  config.components.push_back(component("slit", slit));
  const Sheet sheet = make(config);
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  EXPECT_EQ(sheet.mesh().num_pieces(), 6) << "the cut between the last two triangles is kept";
  EXPECT_NEAR(area_of(sheet, 3), 0.09 * 3.14159265, 1e-3);
  EXPECT_NEAR((sheet.state().x.col(sheet.components()[2].first_vertex + 1) - Vector3d(1.0, 0.0, 2.0)).norm(), 0.0,
              1e-12)
      << "a mesh file has its own places in the world";
}

TEST(Components, MayBeFlatAndCurvedTogether) {
  scene::SheetConfig alone = of_arrays(test::dome(6, 1.0));
  scene::SheetConfig config = alone;
  config.components = {component("cloth", grid(11, 11, 1.0, 1.0)), component("dome", alone.mesh),
                       component("ribbon", grid(11, 3, 1.0, 0.2))};
  const Sheet dome = make(alone);
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  EXPECT_TRUE(sheet.mesh().is_curved());
  EXPECT_NEAR(area_of(sheet, 0), 1.0, 1e-9);
  double area = 0.0;
  for (mesh::TriangleId t = 0; t < dome.mesh().num_triangle_slots(); ++t) {
    if (dome.mesh().is_solid(t)) area += dome.mesh().area(t);
  }
  EXPECT_NEAR(area_of(sheet, 1), area, 1e-9 * area);
  EXPECT_NEAR(area_of(sheet, 2), 0.2, 1e-9);
  EXPECT_NEAR(sheet.energies().membrane, 0.0, 1e-12) << "each starts in its rest shape";
  ASSERT_TRUE(apply(sheet, scenes::of("ribbon", scenes::line_cut({0.5, -0.1}, {0.5, 0.3}))).ok());
  EXPECT_EQ(sheet.mesh().num_pieces(), 4);
}

TEST(Components, AreAsLargeAsTheLargest) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.components.push_back(component("long", grid(3, 2, 3.0, 0.5)));
  EXPECT_EQ(scene::build_mesh(config).value().size(), 3.0);
  config.components.clear();
  config.mesh = grid(3, 2, 2.0, 4.0);
  EXPECT_EQ(scene::build_mesh(config).value().size(), 4.0);
}

TEST(Components, HaveMaterialsOfTheirOwn) {
  scene::SheetConfig config = cloth_and_ribbon();
  fem::Material heavy = config.material;
  heavy.density *= 10.0;
  config.materials = {{scene::Region(scene::WholeSheet{}, "ribbon"), heavy}};
  const Sheet sheet = make(config);
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 2U);
  const double light = config.material.density * config.material.thickness;
  EXPECT_NEAR(pieces[0].mass, light, 1e-9 * light);
  EXPECT_NEAR(pieces[1].mass, 10.0 * 0.2 * light, 1e-9 * light);
}

TEST(Components, AreRefusedByNameAndNumber) {
  const auto with = [](auto spoil) {
    scene::SheetConfig config = cloth_and_ribbon();
    spoil(config.components);
    return config;
  };
  using All = std::vector<scene::Component>;
  EXPECT_EQ(refused(with([](All& all) { all[1].name = "cloth"; })), "COMPONENT_NAME components[1].name");
  EXPECT_EQ(refused(with([](All& all) { all[0].name = "Cloth"; })), "COMPONENT_NAME components[0].name");
  EXPECT_EQ(refused(with([](All& all) { all[0].name = ""; })), "COMPONENT_NAME components[0].name");
  EXPECT_EQ(refused(with([](All& all) { all[1].mesh = grid(1, 3, 1.0, 1.0); })),
            "OUT_OF_RANGE components[1].grid.columns");
  EXPECT_EQ(refused(with([](All& all) {
              all[1].mesh = scene::ObjSource{"f 1 2 3\n", {}};
            })),
            "OBJ_INDEX components[1].obj.text");
  EXPECT_EQ(refused(with([](All& all) {
              all[1].placement = scene::Placement{{}, {2.0, 0.0, 0.0}, {}};
            })),
            "NOT_UNIT components[1].placement.x_axis");
  EXPECT_EQ(refused(with([](All& all) { all[0].offset = Vector2d(0.0, kNan); })), "NOT_FINITE components[0].offset.y");
  EXPECT_EQ(refused(with([](All& all) { all[0].offset = Vector2d(9999.5, 0.0); })),
            "OUT_OF_RANGE components[0].offset");
  EXPECT_EQ(refused(with([](All& all) { all.resize(65, all[0]); })), "TOO_MANY components");
  EXPECT_NE(message_of(with([](All& all) { all[1].mesh = grid(1, 3, 1.0, 1.0); })).find("components[1] (ribbon): "),
            std::string::npos);
}

TEST(Components, MayNotTouchInThePlane) {
  const auto at = [](double x, double y) {
    scene::SheetConfig config = cloth_and_ribbon();
    config.components[1].offset = Vector2d(x, y);
    return config;
  };
  EXPECT_EQ(refused(at(0.0, 0.0)), "COMPONENTS_OVERLAP components[1].offset");
  EXPECT_EQ(refused(at(1.0, 0.0)), "COMPONENTS_OVERLAP components[1].offset") << "they would touch";
  EXPECT_EQ(refused(at(1.0009, 0.5)), "COMPONENTS_OVERLAP components[1].offset");
  EXPECT_EQ(refused(at(1.0011, 0.5)), "made");
  EXPECT_EQ(refused(at(0.5, 1.0011)), "made") << "above each other";
  const std::string message = message_of(at(0.5, 0.5));
  EXPECT_NE(message.find("components[1] (ribbon): "), std::string::npos) << message;
  EXPECT_NE(message.find("cloth"), std::string::npos) << message;
}

TEST(Components, CountTogetherAgainstTheLimitOfVertices) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.max_vertices = 154;
  EXPECT_EQ(refused(config), "made");
  config.max_vertices = 153;
  EXPECT_EQ(refused(config), "TOO_MANY_VERTICES components[1]");
  config.max_vertices = 122;
  EXPECT_EQ(refused(config), "TOO_MANY_VERTICES components[1]");
  scene::OutlineSource disc;
  disc.boundary = cut::Circle{{0.0, 0.0}, 0.5};
  disc.edge_length = 0.01;
  config.components[1] = component("disc", disc);
  config.max_vertices = 1000;
  EXPECT_EQ(refused(config), "OUTLINE_TOO_FINE components[1].outline.edge_length_m");
}

}  // namespace
}  // namespace kerf::sheet
