// Cuts and regions that name a component of the scene, and are in its own coordinates.
#include <string>
#include <utility>
#include <vector>

#include "server/base/state_hash.h"
#include "server/core/cut/fit.h"
#include "server/core/fem/element/state.h"
#include "server/core/scene/components.h"
#include "server/core/scene/region.h"
#include "tests/sheet/calls.h"
#include "tests/support/component_scenes.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using scenes::circle_cut;
using scenes::cloth_and_ribbon;
using scenes::line_cut;
using scenes::of;
using Ids = std::vector<mesh::VertexId>;

// A ribbon with an offset that is no round number, in the middle of the plane.
scene::SheetConfig ribbon_elsewhere() {
  scene::SheetConfig config = cloth_and_ribbon();
  config.components[1].offset = Vector2d(1.0 / 3.0 + 1.0, 0.1);
  return config;
}

// The cut of the ribbon as a cut in the scene's plane.
scene::Cut in_plane(const Sheet& sheet, scene::Cut cut) {
  cut::shift(sheet.components()[1].offset, cut.curve);
  if (cut.options.fit && cut.options.fit->box) {
    cut.options.fit->box->low += sheet.components()[1].offset;
    cut.options.fit->box->high += sheet.components()[1].offset;
  }
  return cut;
}

TEST(ComponentCuts, AreTheCutsOfTheShiftedCurves) {
  std::vector<scene::Cut> cuts{scenes::bezier_cut({0.2, -0.02}, {0.25, 0.1}, {0.15, 0.1}, {0.2, 0.22}),
                               line_cut({0.31, 0.05}, {0.39, 0.15}), circle_cut({0.5, 0.1}, 0.06)};
  cuts.push_back(line_cut({0.6, 0.1}, {0.7, 0.12}));
  cuts.back().options.width_m = 0.01;
  cuts.push_back(line_cut({0.75, 0.03}, {0.75, 0.17}));
  cuts.back().options.dash = {{0.02, 0.01}, 0.005};
  cuts.push_back(circle_cut({50.0, 70.0}, 3.0));
  cuts.back().options.fit = cut::Fit{cut::Box{{0.82, 0.04}, {0.94, 0.16}}};
  cut::Subpath path{{0.05, 0.05}, {cut::ArcTo{{0.1, 0.05}, 0.2, false, true, {0.12, 0.1}}}, true};
  cuts.emplace_back().curve = cut::Path{{path}};
  cuts.emplace_back().curve = cut::Ellipse{{0.45, 0.03}, {0.02, 0.01}, 0.4};
  Sheet sheet = make(ribbon_elsewhere());
  Sheet expected = sheet;
  for (const scene::Cut& cut : cuts) {
    const Result<scene::CommandReply> reply = apply(sheet, of("ribbon", cut));
    ASSERT_TRUE(reply.ok()) << reply.error().message;
    EXPECT_EQ(reply->cut->status, cut::CutStatus::kApplied);
    ASSERT_TRUE(apply(expected, in_plane(expected, cut)).ok());
    EXPECT_EQ(sheet.state_hash(), expected.state_hash());
  }
  run(sheet, 5);
  run(expected, 5);
  EXPECT_EQ(sheet.state_hash(), expected.state_hash());
}

TEST(ComponentCuts, LeaveEverythingElseWhole) {
  Sheet sheet = make(cloth_and_ribbon());
  const scene::Cut across = line_cut({-50.0, 0.11}, {50.0, 0.11});
  ASSERT_TRUE(apply(sheet, of("ribbon", across)).ok());
  EXPECT_EQ(sheet.pieces().size(), 3U);
  const scene::CommandReply nothing = apply(sheet, of("ribbon", line_cut({-3.0, 0.5}, {3.0, 0.5}))).value();
  EXPECT_EQ(nothing.cut->status, cut::CutStatus::kNoIntersection) << "it meets only the cloth";
  ASSERT_TRUE(apply(sheet, of("cloth", across)).ok());
  EXPECT_EQ(sheet.pieces().size(), 4U);
  ASSERT_TRUE(apply(sheet, line_cut({-50.0, 0.05}, {50.0, 0.05})).ok());
  EXPECT_EQ(sheet.pieces().size(), 6U) << "a cut of no component meets all";
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
}

TEST(ComponentCuts, WithAWidthRemoveNothingElse) {
  Sheet sheet = make(cloth_and_ribbon());
  scene::Cut strip = of("ribbon", line_cut({-50.0, 0.1}, {50.0, 0.1}));
  strip.options.width_m = 5.0;  // wider than all of the sheet
  const scene::CommandReply reply = apply(sheet, strip).value();
  EXPECT_EQ(reply.cut->report.removed_pieces, 1);
  EXPECT_NEAR(reply.cut->report.removed_area_m2, 0.2, 1e-9);
  ASSERT_EQ(sheet.pieces().size(), 1U);
  EXPECT_NEAR(sheet.pieces()[0].area, 1.0, 1e-9);
  strip.component = "cloth";
  EXPECT_EQ(reason(apply(sheet, strip)), "STRIP_COVERS_SHEET");
}

TEST(ComponentCuts, AreFittedIntoTheirComponent) {
  Sheet sheet = make(cloth_and_ribbon());
  scene::Cut star = of("ribbon", circle_cut({0.0, 0.0}, 1.0));
  star.options.fit = cut::Fit{};
  ASSERT_TRUE(apply(sheet, star).ok());
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_NEAR(pieces[2].area, 3.14159265 * 0.09 * 0.09, 5e-4) << "90 % of the ribbon's width across";
  EXPECT_NEAR((pieces[2].centroid - Vector2d(1.1 + 0.5, 0.1)).norm(), 0.0, 1e-3) << "results are in the scene's plane";
}

TEST(ComponentCuts, OfUnknownComponentsAreRefusedAndChangeNothing) {
  Sheet sheet = make(cloth_and_ribbon());
  const std::uint64_t before = sheet.state_hash();
  const scene::Cut wrong = of("band", line_cut({0.2, 0.1}, {0.8, 0.1}));
  const Result<scene::CommandReply> alone = apply(sheet, wrong);
  ASSERT_FALSE(alone.ok());
  EXPECT_EQ(alone.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(alone.error().reason, "COMPONENT_UNKNOWN");
  EXPECT_EQ(alone.error().field, "cut.component");
  EXPECT_NE(alone.error().message.find("cloth, ribbon"), std::string::npos) << alone.error().message;
  const scene::CutBatch batch{{of("ribbon", line_cut({0.2, 0.1}, {0.8, 0.1})), wrong}};
  const Result<scene::CommandReply> second = apply(sheet, batch);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().reason, "COMPONENT_UNKNOWN");
  EXPECT_EQ(second.error().field, "cut_batch.cuts[1].component");
  EXPECT_EQ(sheet.state_hash(), before);
  Sheet plain = make(scenes::hanging(5));
  const Result<scene::CommandReply> none = apply(plain, wrong);
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("has no components"), std::string::npos) << none.error().message;
}

TEST(ComponentCuts, OnAPictureAreRefused) {
  Sheet sheet = make(cloth_and_ribbon());
  scene::Cut cut = of("ribbon", line_cut({100.0, 100.0}, {200.0, 100.0}));
  cut.view = cut::View{};
  EXPECT_EQ(reason(apply(sheet, cut)), "COMPONENT_WITH_VIEW");
}

TEST(ComponentCuts, OfASceneAreCheckedWhenItIsMade) {
  const auto with = [](scene::Command command) {
    scene::SheetConfig config = cloth_and_ribbon();
    config.commands = {{5, std::move(command)}};
    return refused(config);
  };
  const scene::Cut known = of("ribbon", line_cut({0.2, 0.1}, {0.8, 0.1}));
  EXPECT_EQ(with(known), "made");
  EXPECT_EQ(with(of("x", known)), "COMPONENT_UNKNOWN commands[0].command.cut.component");
  EXPECT_EQ(with(scene::CutBatch{{known, of("x", known)}}),
            "COMPONENT_UNKNOWN commands[0].command.cut_batch.cuts[1].component");
  EXPECT_EQ(with(scene::SetPins{{scene::Region(scene::RegionEdge::kTop, "x")}}),
            "COMPONENT_UNKNOWN commands[0].command.set_pins.pins[0].component");
}

TEST(ComponentCuts, AreUndoneRedoneAndReplayedToTheSameBits) {
  const scene::CutBatch both{
      {of("cloth", circle_cut({0.5, 0.5}, 0.2)), of("ribbon", line_cut({0.4, -1.0}, {0.5, 1.0}))}};
  scene::SheetConfig config = cloth_and_ribbon();
  config.pins = {scene::Region(scene::RegionEdge::kTop, "ribbon")};
  Sheet sheet = make(config);
  const auto mesh_hash = [&sheet] {
    StateHash hash;
    sheet.mesh().add_to(hash);
    return hash.value();
  };
  const std::uint64_t before = mesh_hash();
  ASSERT_TRUE(apply(sheet, both).ok());
  EXPECT_EQ(sheet.pieces().size(), 4U);
  const std::uint64_t after = mesh_hash();
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(mesh_hash(), before) << "both cuts are one step";
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(mesh_hash(), after);
  expect_equal_replay(config, {{}, {both}, {}, {scene::UndoCut{}}, {}, {scene::RedoCut{}}, {}});
}

Ids found_in(const Sheet& sheet, const scene::RegionShape& shape, const std::string& name = "ribbon") {
  const scene::PlacedRegion placed = scene::place(scene::Region(shape, name), sheet.components(), "pins[0]").value();
  return scene::find_vertices(sheet.mesh(), placed, "pins[0]").value();
}

// The ribbon has 11 x 3 vertices, of which the first is number 121.
TEST(ComponentRegions, AreInTheComponentsOwnCoordinates) {
  const Sheet sheet = make(cloth_and_ribbon());
  const mesh::VertexId first = 121;
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kLeft), (Ids{first, first + 11, first + 22}));
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kRight), (Ids{first + 10, first + 21, first + 32}));
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kTop).size(), 11U);
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kTop).front(), first + 22);
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kBottom).back(), first + 10);
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kCorners), (Ids{first, first + 10, first + 22, first + 32}));
  EXPECT_EQ(found_in(sheet, scene::RegionEdge::kTopCorners, "cloth"), (Ids{110, 120}));
  EXPECT_EQ(found_in(sheet, scene::MaterialBox{{-9.0, 0.05}, {9.0, 0.15}}).size(), 11U) << "none of the cloth";
  EXPECT_EQ(found_in(sheet, Ids{0, 32}), (Ids{first, first + 32}));
  EXPECT_EQ(found_in(sheet, scene::MaterialLine{{-9.0, 0.1}, {0.15, 0.1}}), (Ids{first + 11, first + 12}));
  EXPECT_EQ(found_in(sheet, scene::NearestVertex{{-0.9, 0.1}}), (Ids{first + 11}))
      << "not the cloth's, which is nearer";
  EXPECT_EQ(found_in(sheet, scene::WholeSheet{}).size(), 33U);
  EXPECT_EQ(found_in(sheet, scene::MaterialCurve{cut::Polyline{{{-9.0, 0.2}, {9.0, 0.2}}}}).size(), 11U);
  EXPECT_EQ(found_in(sheet, scene::NearestBorder{{-0.9, 0.5}}).size(), 24U) << "all around the ribbon alone";
  EXPECT_EQ(found_in(sheet, scene::NearestBorder{{9.0, 0.5}}, "cloth").size(), 40U);
}

TEST(ComponentRegions, AreRefusedWhereNoComponentHasThem) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.pins = {scene::Region(scene::RegionEdge::kTop, "cloth"), scene::Region(scene::RegionEdge::kTop, "x")};
  EXPECT_EQ(refused(config), "COMPONENT_UNKNOWN pins[1].component");
  config.pins = {scene::Region(Ids{0, 33}, "ribbon")};
  EXPECT_EQ(refused(config), "UNKNOWN_VERTEX pins[0].vertices.vertices[1]");
  config.pins = {scene::Region(scene::MaterialBox{{0.0, 0.3}, {1.0, 1.0}}, "ribbon")};
  EXPECT_EQ(refused(config), "REGION_EMPTY pins[0]");
  config.pins.clear();
  config.constraints = {hold(scene::Region(scene::RegionEdge::kTop, "x"))};
  EXPECT_EQ(refused(config), "COMPONENT_UNKNOWN constraints[0].region.component");
  config.constraints.clear();
  config.loads = {{scene::Pressure{scene::Region(scene::WholeSheet{}, "x"), 1.0}, {}}};
  EXPECT_EQ(refused(config), "COMPONENT_UNKNOWN loads[0].pressure.region.component");
  config.loads.clear();
  config.materials = {{scene::Region(scene::WholeSheet{}, "x"), config.material, "components[1].material"}};
  EXPECT_EQ(refused(config), "COMPONENT_UNKNOWN components[1].material.region.component");
  Sheet sheet = make(cloth_and_ribbon());
  EXPECT_EQ(reason(apply(sheet, scene::SetPins{{scene::Region(scene::RegionEdge::kTop, "x")}})), "COMPONENT_UNKNOWN");
}

TEST(ComponentRegions, ArePinnedHeldAndLoadedThroughCuts) {
  scene::SheetConfig config = cloth_and_ribbon();
  config.gravity.setZero();
  config.pins = {scene::Region(scene::RegionEdge::kLeft, "cloth")};
  scene::Constraint moved = hold(scene::Region(Ids{0, 11, 22}, "ribbon"));
  moved.displacements = Eigen::Matrix3Xd::Zero(3, 3);
  moved.displacements.row(1) << 0.01, 0.02, 0.03;
  config.constraints = {moved, hold(scene::Region(scene::RegionEdge::kRight, "ribbon"))};
  config.loads = {{scene::Pressure{scene::Region(scene::WholeSheet{}, "cloth"), 1.0}, {}}};
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.pinned_vertices().size(), 11U);
  EXPECT_EQ(sheet.pinned_vertices().front(), 0);
  sheet.step({});
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(sheet.state().x(1, 121 + 11 * k), 0.01 * (k + 1), 1e-12);
  ASSERT_TRUE(apply(sheet, of("ribbon", line_cut({0.5, 0.1}, {1.5, 0.1}))).ok());
  ASSERT_TRUE(apply(sheet, of("cloth", line_cut({0.5, 0.5}, {1.5, 0.5}))).ok());
  run(sheet, 5);
  EXPECT_NEAR(sheet.state().x(0, 131), 2.1, 1e-12) << "still held";
  EXPECT_GT(sheet.state().v.col(60).norm(), 0.0) << "the pressure moves the cloth";
  const scene::BorderEdge lip = scene::edges_in(sheet.mesh(), found_in(sheet, scene::RegionEdge::kRight)).front();
  EXPECT_NEAR(sheet.state().x(0, lip.ends[0]), 2.1, 1e-12);
  ASSERT_TRUE(apply(sheet, scene::SetPins{{scene::Region(scene::WholeSheet{}, "ribbon")}}).ok());
  EXPECT_GE(sheet.pinned_vertices().size(), 33U);
  EXPECT_EQ(sheet.pinned_vertices().front(), 121);
}

}  // namespace
}  // namespace kerf::sheet
