// Sheets with materials by region.
#include <algorithm>
#include <array>

#include "server/core/fem/model/model.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"
#include "tests/support/shells.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

fem::Material heavy() {
  fem::Material m = fem::isotropic(4.0e6, 0.2, 1.0e-3, 1500.0);
  m.mass_damping = 1.0;
  return m;
}
fem::Material third() {
  fem::Material m = fem::isotropic(1.0e5, 0.4, 2.0e-3, 700.0);
  m.bending_stiffness_1 = 2.0e-5;  // as if measured
  m.bending_coupling = -1.0e-6;
  return m;
}

scene::MaterialBox box(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y1}};
}

// The right half of the sheet heavy, with a spot of a third material in the middle.
scene::SheetConfig divided(std::int32_t n) {
  scene::SheetConfig config = scenes::hanging(n);
  config.materials = {{box(0.5, 0.0, 1.0, 1.0), heavy()}, {box(0.3, 0.3, 0.7, 0.7), third()}};
  return config;
}

// m^2, of each material.
std::vector<double> areas(const Sheet& sheet) {
  std::vector<double> areas(sheet.model().materials().size(), 0.0);
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (sheet.mesh().is_solid(t)) areas[static_cast<std::size_t>(sheet.mesh().region(t))] += sheet.mesh().area(t);
  }
  return areas;
}

std::string reason_of(scene::SheetConfig config) {
  const Result<Sheet> created = Sheet::create(std::move(config));
  return created.ok() ? "made" : created.error().reason + " " + created.error().field;
}

TEST(SheetMaterials, LaterEntriesWinAndTheRestHasTheSheetsOwn) {
  const Sheet sheet = make(divided(21));
  const fem::MaterialTable& materials = sheet.model().materials();
  ASSERT_EQ(materials.size(), 3U);
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (!sheet.mesh().is_solid(t)) continue;
    Vector2d at = Vector2d::Zero();
    for (const mesh::VertexId v : sheet.mesh().vertices(t)) at += sheet.mesh().rest_position(v) / 3.0;
    const bool in_spot = (at - Vector2d(0.5, 0.5)).cwiseAbs().maxCoeff() <= 0.2;
    const fem::Material expected = in_spot ? third() : at.x() >= 0.5 ? heavy() : scenes::demo_material();
    EXPECT_EQ(sheet.model().elements().law(t).material, expected) << at.transpose();
  }
  EXPECT_NEAR(sheet.model().masses().total(), 0.16 * 1.4 + 0.42 * 1.5 + 0.42 * 0.2, 1e-12);
  ASSERT_EQ(sheet.pieces().size(), 1U);
  EXPECT_NEAR(sheet.pieces()[0].mass, sheet.model().masses().total(), 1e-12);
}

TEST(SheetMaterials, OneThatIsAllOfTheSheetIsAsGoodAsItsOwn) {
  scene::SheetConfig all = scenes::hanging(9);
  all.materials = {{box(0.0, 0.0, 0.4, 0.4), third()}, {scene::WholeSheet{}, heavy()}};
  scene::SheetConfig own = scenes::hanging(9);
  own.material = heavy();
  Sheet a = make(all), b = make(own);
  run(a, 5);
  run(b, 5);
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

void expect_kept_through_cuts(fem::MembraneLaw membrane_law) {
  scene::SheetConfig config = divided(21);
  config.membrane_law = membrane_law;
  Sheet sheet = make(config);
  run(sheet, 3);
  const std::uint64_t mesh = sheet.mesh().state_hash(), model = sheet.model().hash();
  const std::vector<double> before = areas(sheet);
  for (scene::Cut& cut : scenes::three_cuts()) ASSERT_TRUE(apply(sheet, std::move(cut)).ok());
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  const std::vector<double> after = areas(sheet);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-13);
  double mass = 0.0;
  for (const scene::Piece& piece : sheet.pieces()) mass += piece.mass;
  EXPECT_NEAR(mass, sheet.model().masses().total(), 1e-12);
  const std::uint64_t cut_mesh = sheet.mesh().state_hash(), cut_model = sheet.model().hash();
  std::vector<fem::Material> materials;
  for (const fem::MaterialLaw& law : sheet.model().materials()) materials.push_back(law.material);
  EXPECT_EQ(cut_model, fem::Model(sheet.mesh(), materials, membrane_law).hash());
  EXPECT_EQ(sheet.model().materials().membrane_law(), membrane_law);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), mesh);
  EXPECT_EQ(sheet.model().hash(), model);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.mesh().state_hash(), cut_mesh);
  EXPECT_EQ(sheet.model().hash(), cut_model);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(sheet.model().hash(), model);
}

TEST(SheetMaterials, CutsKeepThemAndUndoAndRedoGiveThemBack) {
  for (const fem::MembraneLaw law : {fem::MembraneLaw::kCorotational, fem::MembraneLaw::kGreen}) {
    expect_kept_through_cuts(law);
  }
}

TEST(SheetMaterials, ElementWiseCutsKeepThemToo) {
  Sheet sheet = make(divided(15));
  const std::vector<double> before = areas(sheet);
  scene::Cut cut = scenes::bezier_cut({0.2, 0.5}, {0.4, 0.8}, {0.6, 0.2}, {0.8, 0.5});
  cut.options.method = cut::Method::kElement;
  ASSERT_TRUE(apply(sheet, cut).ok());
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  const std::vector<double> after = areas(sheet);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i], before[i], 1e-13);
}

TEST(SheetMaterials, AStripTakesTheMassOfWhatItCrosses) {
  scene::SheetConfig config = scenes::hanging(21);
  config.materials = {{box(0.5, 0.0, 1.0, 1.0), heavy()}};
  Sheet sheet = make(config);
  const double before = sheet.model().masses().total();
  scene::Cut cut = scenes::line_cut({0.2, 0.5}, {0.8, 0.5});
  cut.options.width_m = 0.02;
  const Result<scene::CommandReply> done = apply(sheet, cut);
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_NEAR(*done->cut->removed_mass, before - sheet.model().masses().total(), 1e-12);
  const double expected = 0.02 * 0.3 * (0.2 + 1.5) + 0.5 * 3.14159 * 1e-4 * (0.2 + 1.5);
  EXPECT_NEAR(*done->cut->removed_mass, expected, 0.02 * expected);
}

TEST(SheetMaterials, ARecordingReplaysBitForBit) {
  std::vector<std::vector<scene::Command>> ticks(25);
  ticks[3] = {scenes::three_cuts()[0]};
  ticks[7] = {scenes::three_cuts()[1], scenes::three_cuts()[2]};
  ticks[11] = {scene::UndoCut{}};
  ticks[15] = {scene::RedoCut{}};
  expect_equal_replay(divided(15), ticks);
}

TEST(SheetMaterials, OfACurvedSheetPartTheFacetsToo) {
  scene::SheetConfig config = of_arrays(test::rolled_square(9, 0.4));
  config.materials = {{box(0.5, -1.0, 2.0, 2.0), heavy()}};
  Sheet sheet = make(config);
  ASSERT_TRUE(sheet.mesh().is_curved());
  ASSERT_EQ(sheet.model().materials().size(), 2U);
  const std::vector<double> before = areas(sheet);
  const double mass = sheet.model().masses().total();
  EXPECT_NEAR(mass, before[0] * 0.2 + before[1] * 1.5, 1e-9);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.1, 0.43}, {0.9, 0.57})).ok());
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  const std::vector<double> after = areas(sheet);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(after[i], before[i], 1e-12);
  EXPECT_NEAR(sheet.model().masses().total(), mass, 1e-12);
}

TEST(SheetMaterials, LinesAndListedVerticesNameTriangles) {
  scene::SheetConfig config = scenes::hanging(11);
  config.materials = {{scene::MaterialLine{{0.0, 0.5}, {1.0, 0.5}, 0.1, scene::MaterialLine::Side::kLeft}, heavy()},
                      {std::vector<mesh::VertexId>{0, 1, 11, 12}, third()}};
  const Sheet sheet = make(config);
  ASSERT_EQ(sheet.model().materials().size(), 3U);
  double line = 0.0, corner = 0.0;
  for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
    if (!sheet.mesh().is_solid(t)) continue;
    if (sheet.model().elements().law(t).material == heavy()) line += sheet.mesh().area(t);
    if (sheet.model().elements().law(t).material == third()) corner += sheet.mesh().area(t);
  }
  EXPECT_NEAR(line, 0.1, 1e-12);
  EXPECT_NEAR(corner, 0.01, 1e-12);
}

TEST(SheetMaterials, RegionsWithoutTrianglesAreRefused) {
  scene::SheetConfig config = scenes::hanging(5);
  config.materials = {{scene::WholeSheet{}, heavy()}, {scene::RegionEdge::kTop, third()}};
  EXPECT_EQ(reason_of(config), "REGION_WITHOUT_TRIANGLES materials[1].region");
  config.materials[1].region = scene::NearestVertex{{0.5, 0.5}};
  EXPECT_EQ(reason_of(config), "REGION_WITHOUT_TRIANGLES materials[1].region");
  config.materials[1].region = box(3.0, 3.0, 4.0, 4.0);
  EXPECT_EQ(reason_of(config), "REGION_EMPTY materials[1].region");
  config.materials[1].region = std::vector<mesh::VertexId>{0, 1, 99};
  EXPECT_EQ(reason_of(config), "UNKNOWN_VERTEX materials[1].region.vertices.vertices[2]");
}

TEST(SheetMaterials, AreAtMostSixteenInAtMostSixtyFourRegions) {
  scene::SheetConfig config = scenes::hanging(17);
  for (int i = 0; i < 15; ++i) {
    fem::Material material = heavy();
    material.density += i;
    config.materials.push_back({box(0.0625 * i, 0.0, 0.0625 * (i + 1), 1.0), material});
  }
  EXPECT_EQ(make(config).model().materials().size(), fem::kMaxMaterials);
  scene::SheetConfig more = config;
  more.materials.push_back({box(0.9, 0.0, 1.0, 1.0), third()});
  EXPECT_EQ(reason_of(more), "TOO_MANY_MATERIALS materials");
  // The same ones again do not count.
  while (config.materials.size() < scene::kMaxRegions) config.materials.push_back(config.materials[0]);
  EXPECT_EQ(reason_of(config), "made");
  config.materials.push_back(config.materials[0]);
  EXPECT_EQ(reason_of(config), "TOO_MANY materials");
}

TEST(SheetMaterials, APlanarSheetBendsNowhere) {
  scene::SheetConfig config = divided(9);
  config.planar = true;
  EXPECT_FALSE(make(config).model().materials().has_bending());
}

TEST(SheetMaterials, AGrabIsNoStifferThanTheMembraneThatItHolds) {
  scene::SheetConfig config = scenes::hanging(9);
  config.materials = {{box(0.5, 0.0, 1.0, 1.0), heavy()}};
  config.tick_rate_hz = 1000.0;  // so that the membrane is what limits it
  Sheet sheet = make(config);
  ASSERT_TRUE(apply(sheet, scene::Grab{"soft", 0, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::Grab{"stiff", 8, std::nullopt, 0.0}).ok());
  EXPECT_LT(sheet.grabs()[0].stiffness, 300.0);
  EXPECT_GT(sheet.grabs()[1].stiffness, 3000.0);
}

}  // namespace
}  // namespace kerf::sheet
