#include <cmath>
#include <limits>
#include <tuple>

#include "tests/sheet/calls.h"
#include "tests/support/failing_integrator.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Sheet, StartsAsConfigured) {
  const Sheet sheet = make(scenes::hanging(10));
  EXPECT_EQ(sheet.tick(), 0);
  EXPECT_EQ(sheet.topology_version(), 1);
  EXPECT_EQ(sheet.mesh().num_vertices(), 100);
  EXPECT_EQ(sheet.mesh().num_solid_triangles(), 162);
  EXPECT_DOUBLE_EQ(sheet.dt(), 1.0 / 60.0);
  EXPECT_EQ(sheet.pinned_vertices(), (std::vector<mesh::VertexId>{90, 91, 92, 93, 94, 95, 96, 97, 98, 99}));
  EXPECT_NEAR((sheet.state().x.col(99) - Vector3d(1.0, 0.0, 1.0)).norm(), 0.0, 1e-12);
  EXPECT_FALSE(sheet.integrator_description().empty());
}

TEST(Sheet, FallsAsGalileiSaysWhenNothingHoldsIt) {
  // Rounding of the rest shape makes waves: strains of some 2^-24 times their speed.
  const fem::Material cloth = scenes::hanging(8).material;
  const double waves = 8.0 * 0x1p-24 * std::sqrt(cloth.youngs_modulus_1 / cloth.density);  // m/s
  using Case = std::tuple<scene::IntegratorKind, scene::Precision, double>;
  for (const auto& [kind, precision, noise] :
       {Case{scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kDouble, 0.0},
        Case{scene::IntegratorKind::kExplicitLeapfrog, scene::Precision::kMixed, waves},
        Case{scene::IntegratorKind::kImplicitEuler, scene::Precision::kMixed, 0.0}}) {
    scene::SheetConfig config = scenes::hanging(8);
    config.pins.clear();
    config.material.mass_damping = 0.0;
    config.integrator.kind = kind;
    config.integrator.precision = precision;
    Sheet sheet = make(config);
    run(sheet, 30);
    EXPECT_EQ(sheet.tick(), 30);
    const double t = 30.0 * sheet.dt();
    // The leapfrog is exact. Implicit Euler moves by the velocity at the end of each tick: dt / 2 later.
    const double late = kind == scene::IntegratorKind::kImplicitEuler ? sheet.dt() : 0.0;
    for (Eigen::Index i = 0; i < sheet.state().x.cols(); ++i) {
      EXPECT_NEAR(sheet.state().v(2, i), -9.81 * t, 1e-10 + noise);
      const double start = sheet.mesh().rest_position(static_cast<mesh::VertexId>(i)).y();
      EXPECT_NEAR(sheet.state().x(2, i), start - 0.5 * 9.81 * t * (t + late), 1e-11 + noise * sheet.dt());
    }
  }
}

TEST(Sheet, PinsHoldBitForBit) {
  Sheet sheet = make(scenes::hanging(10));
  const Eigen::Matrix3Xd before = sheet.state().x;
  run(sheet, 60);
  for (const mesh::VertexId v : sheet.pinned_vertices()) {
    EXPECT_EQ(Vector3d(sheet.state().x.col(v)), Vector3d(before.col(v)));
    EXPECT_EQ(Vector3d(sheet.state().v.col(v)), Vector3d(0, 0, 0));
  }
  EXPECT_LT(sheet.state().x(2, 0), before(2, 0));
}

TEST(Sheet, SetPinsHoldsVerticesWhereTheyAre) {
  Sheet sheet = make(scenes::hanging(10));
  run(sheet, 20);
  const Vector3d there = sheet.state().x.col(4);
  ASSERT_TRUE(apply(sheet, scene::SetPins{{std::vector<mesh::VertexId>{4, 7, 4}}}).ok());
  EXPECT_EQ(sheet.pinned_vertices(), (std::vector<mesh::VertexId>{4, 7}));
  EXPECT_EQ(sheet.settings_version(), 1);
  run(sheet, 20);
  EXPECT_EQ(Vector3d(sheet.state().x.col(4)), there);
  EXPECT_GT((sheet.state().x.col(99) - Vector3d(1.0, 0.0, 1.0)).norm(), 1e-3);  // let go
  ASSERT_TRUE(apply(sheet, scene::SetPins{}).ok());
  EXPECT_TRUE(sheet.pinned_vertices().empty());
}

TEST(Sheet, RegionsNameTheRightVertices) {
  scene::SheetConfig config = scenes::hanging(5);
  config.pins = {scene::RegionEdge::kCorners};
  EXPECT_EQ(make(config).pinned_vertices(), (std::vector<mesh::VertexId>{0, 4, 20, 24}));
  config.pins = {scene::RegionEdge::kTopCorners};
  EXPECT_EQ(make(config).pinned_vertices(), (std::vector<mesh::VertexId>{20, 24}));
  config.pins = {scene::RegionEdge::kLeft, scene::RegionEdge::kBottom};
  EXPECT_EQ(make(config).pinned_vertices(), (std::vector<mesh::VertexId>{0, 1, 2, 3, 4, 5, 10, 15, 20}));
  config.pins = {scene::RegionEdge::kRight};
  EXPECT_EQ(make(config).pinned_vertices(), (std::vector<mesh::VertexId>{4, 9, 14, 19, 24}));
  config.pins = {scene::MaterialBox{{0.2, 0.2}, {0.5, 0.3}}};
  EXPECT_EQ(make(config).pinned_vertices(), (std::vector<mesh::VertexId>{6, 7}));
}

TEST(Sheet, ACutOnAPausedSheetIsDoneWithoutTime) {
  Sheet sheet = make(scenes::hanging(12));
  run(sheet, 5);
  const std::int32_t vertices = sheet.mesh().num_vertices();
  const Result<scene::CommandReply> reply = apply(sheet, scenes::line_cut({-0.5, 0.55}, {1.5, 0.45}));
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(reply->tick, 5);
  EXPECT_EQ(sheet.tick(), 5);
  EXPECT_EQ(reply->topology_version, 2);
  ASSERT_TRUE(reply->cut.has_value());
  EXPECT_EQ(reply->cut->status, cut::CutStatus::kApplied);
  EXPECT_EQ(reply->cut->report.pieces, 2);
  EXPECT_EQ(reply->cut->report.new_vertices, sheet.mesh().num_vertices() - vertices);
  EXPECT_EQ(reply->state_hash, sheet.state_hash());
  EXPECT_EQ(sheet.mesh().find_violation(), std::nullopt);
  EXPECT_EQ(sheet.num_cuts(), 1);
  run(sheet, 30);
  EXPECT_TRUE(sheet.state().x.allFinite());
  EXPECT_LT(sheet.state().x(2, 0), -0.5);  // the lower piece falls
}

TEST(Sheet, AMissChangesNothingAndSaysSo) {
  Sheet sheet = make(scenes::hanging(8));
  const std::uint64_t hash = sheet.state_hash();
  const Result<scene::CommandReply> reply = apply(sheet, scenes::line_cut({2.0, 0.0}, {3.0, 1.0}));
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(reply->cut->status, cut::CutStatus::kNoIntersection);
  EXPECT_EQ(reply->cut->report.pieces, 1);
  EXPECT_EQ(sheet.state_hash(), hash);
  EXPECT_EQ(sheet.topology_version(), 1);
}

TEST(Sheet, ARefusedCommandChangesNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Sheet sheet = make(scenes::hanging(10));
  run(sheet, 3);
  ASSERT_TRUE(apply(sheet, scene::Grab{"a", 0, Vector3d(0.0, 0.0, 0.0), 0.0}).ok());
  const std::uint64_t hash = sheet.state_hash();
  scene::Cut tight = scenes::line_cut({-0.5, 0.5}, {1.5, 0.5});
  tight.options.max_new_triangles = 1;
  EXPECT_EQ(reason(apply(sheet, tight)), "CUT_ELEMENT_BUDGET");
  EXPECT_EQ(reason(apply(sheet, scenes::line_cut({nan, 0.5}, {1.5, 0.5}))), "CURVE_NOT_FINITE");
  EXPECT_EQ(reason(apply(sheet, scenes::circle_cut({0.5, 0.5}, -1.0))), "RADIUS_NOT_POSITIVE");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"a", 1, std::nullopt, 0.0})), "GRAB_EXISTS");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"", 1, std::nullopt, 0.0})), "EMPTY");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{std::string(64, 'x'), 1, std::nullopt, 0.0})), "TOO_MANY");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", 100, std::nullopt, 0.0})), "UNKNOWN_VERTEX");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", -1, std::nullopt, 0.0})), "UNKNOWN_VERTEX");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", Vector2d(1.5, 0.5), std::nullopt, 0.0})), "POINT_OUTSIDE");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", Vector2d(9e3, 9e3), std::nullopt, 0.0})), "POINT_OUTSIDE");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", 1, Vector3d(0.0, nan, 0.0), 0.0})), "NOT_FINITE");
  EXPECT_EQ(reason(apply(sheet, scene::Grab{"b", 1, std::nullopt, 2e6})), "OUT_OF_RANGE");
  EXPECT_EQ(reason(apply(sheet, scene::Drag{"b", Vector3d(0, 0, 0)})), "GRAB_NOT_FOUND");
  EXPECT_EQ(reason(apply(sheet, scene::Drag{"a", Vector3d(nan, 0, 0)})), "NOT_FINITE");
  EXPECT_EQ(reason(apply(sheet, scene::Drag{"a", Vector3d(0, 1.1e6, 0)})), "OUT_OF_RANGE");
  EXPECT_EQ(reason(apply(sheet, scene::Release{"b"})), "GRAB_NOT_FOUND");
  EXPECT_EQ(reason(apply(sheet, scene::SetPins{{std::vector<mesh::VertexId>{0, 100}}})), "UNKNOWN_VERTEX");
  EXPECT_EQ(reason(apply(sheet, scene::SetPins{{scene::MaterialBox{{0, 0}, {-1, 1}}}})), "BOX_INVERTED");
  EXPECT_EQ(reason(apply(sheet, scene::SetPins{std::vector<scene::Region>(65, scene::RegionEdge::kTop)})), "TOO_MANY");
  EXPECT_EQ(reason(apply(sheet, scene::SetGravity{Vector3d(0, 0, nan)})), "NOT_FINITE");
  EXPECT_EQ(reason(apply(sheet, scene::SetGravity{Vector3d(0, 9e3, 9e3)})), "OUT_OF_RANGE");
  EXPECT_EQ(reason(apply(sheet, scene::SetWind{{Vector3d(0, 0, 1001), 1.2, 1.0}})), "OUT_OF_RANGE");
  EXPECT_EQ(reason(apply(sheet, scene::SetWind{{Vector3d(0, 0, 0), -1.0, 1.0}})), "OUT_OF_RANGE");
  EXPECT_EQ(sheet.state_hash(), hash);
  EXPECT_EQ(sheet.topology_version(), 1);
}

TEST(Sheet, RefusalsNameTheField) {
  Sheet sheet = make(scenes::hanging(5));
  EXPECT_EQ(apply(sheet, scene::Grab{"b", Vector2d(1.5, 0.5), std::nullopt, 0.0}).error().field, "grab.material");
  EXPECT_EQ(apply(sheet, scene::SetPins{{scene::RegionEdge::kTop, std::vector<mesh::VertexId>{0, 25}}}).error().field,
            "set_pins.pins[1].vertices.vertices[1]");
  scene::Cut cut = scenes::line_cut({0, 0}, {1, 1});
  cut.options.tolerance = 0.6;
  EXPECT_EQ(apply(sheet, cut).error().field, "cut.tolerance");
  EXPECT_EQ(apply(sheet, scene::SetWind{{Vector3d(0, 0, 0), 1.0, 11.0}}).error().field,
            "set_wind.wind.drag_coefficient");
}

TEST(Sheet, BothCopiesOfASplitPinnedVertexArePinned) {
  scene::SheetConfig config = scenes::hanging(9);
  Sheet sheet = make(config);
  const std::size_t pinned_before = sheet.pinned_vertices().size();
  // Down along the column x = 0.5, through the pinned vertex (0.5, 1), and through the middle of a pinned edge.
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, 1.2}, {0.5, 0.6})).ok());
  EXPECT_EQ(sheet.pinned_vertices().size(), pinned_before + 1);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.1875, 1.2}, {0.1875, 0.6})).ok());
  EXPECT_EQ(sheet.pinned_vertices().size(), pinned_before + 3);
  const Eigen::Matrix3Xd before = sheet.state().x;
  run(sheet, 30);
  for (const mesh::VertexId v : sheet.pinned_vertices()) {
    EXPECT_DOUBLE_EQ(sheet.mesh().rest_position(v).y(), 1.0);
    EXPECT_EQ(Vector3d(sheet.state().x.col(v)), Vector3d(before.col(v)));
  }
}

TEST(Sheet, RefusesASliverAndStepsTheFlattestSheetThatImportTakes) {
  const auto created = Sheet::create(of_arrays(test::indexed(
      {{0, 0}, {0.9132020097620708, 0.8346492473105291}, {0.8983662352101822, 0.8210896318797345}}, {{0, 1, 2}})));
  ASSERT_FALSE(created.ok());
  EXPECT_EQ(created.error().reason, "MESH_DEGENERATE_TRIANGLE");
  EXPECT_EQ(created.error().field, "inline.triangles");
  // Far from the origin and turned: nothing that is close to rounding may decide whether it has an area.
  for (int i = 0; i < 90; ++i) {
    const double angle = 0.07 * i;
    const Vector2d along(std::cos(angle), std::sin(angle));
    const Vector2d a(9e3, -8e3), b = a + along, c = a + 0.5 * along + 1.1e-6 * Vector2d(-along.y(), along.x());
    scene::SheetConfig config = of_arrays(test::indexed({{a.x(), a.y()}, {b.x(), b.y()}, {c.x(), c.y()}}, {{0, 1, 2}}));
    config.material.direction = 0.9;
    Sheet sheet = make(std::move(config));
    run(sheet, 1);
    EXPECT_TRUE(sheet.state().x.allFinite());
  }
}

TEST(Sheet, ScheduledCommandsComeAtTheirTickBeforeOthersAndInOrder) {
  scene::SheetConfig config = scenes::hanging(8);
  config.commands = {{4, scene::SetGravity{Vector3d(0, 0, -4)}},
                     {2, scene::SetGravity{Vector3d(0, 0, -1)}},
                     {2, scene::SetGravity{Vector3d(0, 0, -2)}}};
  Sheet sheet = make(config);
  run(sheet, 1);
  EXPECT_EQ(sheet.gravity().z(), -9.81);
  EXPECT_TRUE(sheet.apply({}).scheduled.empty());
  const TickReport second = sheet.step({});
  ASSERT_EQ(second.scheduled.size(), 2U);
  EXPECT_EQ(second.scheduled[0].index, 1U);
  EXPECT_EQ(second.scheduled[1].index, 2U);
  EXPECT_EQ(second.scheduled[1].reply->tick, 2);
  EXPECT_EQ(sheet.gravity().z(), -2.0);
  run(sheet, 1);
  const std::vector<scene::Command> outside{scene::SetGravity{Vector3d(0, 0, -5)}};
  sheet.step(outside);
  EXPECT_EQ(sheet.gravity().z(), -5.0);  // the scheduled one came first
}

TEST(Sheet, ResetGoesBackToTheStartAndTimeGoesOn) {
  scene::SheetConfig config = scenes::hanging_with_three_cuts(10);
  Sheet sheet = make(config);
  const std::uint64_t start = sheet.shape_hash();
  run(sheet, 35);
  ASSERT_TRUE(apply(sheet, scene::Grab{"a", 5, std::nullopt, 0.0}).ok());
  ASSERT_TRUE(apply(sheet, scene::SetGravity{Vector3d(0, 1, 0)}).ok());
  EXPECT_EQ(sheet.mesh().num_pieces(), 3);
  const std::int32_t version = sheet.topology_version();
  const Result<scene::CommandReply> reply = apply(sheet, scene::Reset{});
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(sheet.shape_hash(), start);
  EXPECT_EQ(sheet.tick(), 35);
  EXPECT_EQ(sheet.topology_version(), version + 1);
  EXPECT_EQ(sheet.mesh().num_pieces(), 1);
  // From the reset on it does what a fresh sheet does, its scheduled cuts among it.
  run(sheet, 40);
  EXPECT_EQ(sheet.mesh().num_pieces(), 3);
  Sheet fresh = make(config);
  run(fresh, 40);
  EXPECT_EQ(sheet.shape_hash(), fresh.shape_hash());
}

TEST(Sheet, DrapesOverASphereWithoutGoingIn) {
  Sheet sheet = make(scenes::draped_over_sphere(20));
  double deepest = 0.0;
  const double keep = 0.3 + 0.5 * sheet.config().material.thickness;
  for (int tick = 0; tick < 120; ++tick) {
    sheet.step({});
    for (Eigen::Index i = 0; i < sheet.state().x.cols(); ++i) {
      deepest = std::max(deepest, keep - sheet.state().x.col(i).norm());
    }
  }
  EXPECT_LT(deepest, 1e-5);
  EXPECT_GT(sheet.contact_phases(), 119);
  EXPECT_LT(sheet.state().x(2, 0), 0.1);  // the corner hangs
  EXPECT_TRUE(sheet.state().x.allFinite());
}

TEST(Sheet, WithoutCollidersNoContactPhaseRuns) {
  Sheet sheet = make(scenes::hanging(8));
  run(sheet, 10);
  EXPECT_EQ(sheet.contact_phases(), 0);
}

TEST(Sheet, ComesToRestOnAFloorAndIsWokenByACommand) {
  Sheet sheet = make(scenes::lying_on_floor(8));
  int ticks = 0;
  while (!sheet.step({}).at_rest && ticks < 600) ++ticks;
  EXPECT_TRUE(sheet.at_rest());
  EXPECT_GE(ticks, 120) << "two seconds are looked at";
  EXPECT_LT(ticks, 600);
  ASSERT_TRUE(apply(sheet, scene::Grab{"a", 0, std::nullopt, 0.0}).ok());
  EXPECT_FALSE(sheet.at_rest());
  run(sheet, 100);
  EXPECT_FALSE(sheet.at_rest());  // held: a hand may pull any moment
  ASSERT_TRUE(apply(sheet, scene::Release{"a"}).ok());
  run(sheet, 130);
  EXPECT_TRUE(sheet.at_rest());
  EXPECT_FALSE(make(scenes::hanging(8)).at_rest());
}

TEST(Sheet, IsNotAtRestWhileAScheduledCommandIsToCome) {
  scene::SheetConfig config = scenes::lying_on_floor(5);
  config.commands = {{500, scene::SetGravity{Vector3d(0, 0, -1)}}};
  Sheet sheet = make(config);
  run(sheet, 300);
  EXPECT_FALSE(sheet.at_rest());
}

TEST(Sheet, AFailedStepKeepsTheLastGoodStateAndThreeFreezeTheSheet) {
  for (const double failure : {scenes::kGivesUp, scenes::kWritesNonsense}) {
    Sheet sheet = Sheet::create(scenes::hanging(8), scenes::make_failing_integrator).value();
    run(sheet, 5);
    const Eigen::Matrix3Xd good = sheet.state().x;
    const std::vector<scene::Command> fail{scene::SetGravity{Vector3d(0, 0, failure)}};
    TickReport report = sheet.step(fail);
    EXPECT_TRUE(report.step_failed && report.advanced && !report.frozen);
    EXPECT_NE(report.stats.flags & fem::kFrozen, 0U);
    EXPECT_EQ(sheet.tick(), 6);
    EXPECT_TRUE(sheet.state().x == good);
    EXPECT_TRUE(sheet.state().v.allFinite());
    // A good step in between starts the count again.
    const std::vector<scene::Command> recover{scene::SetGravity{Vector3d(0, 0, -9.81)}};
    EXPECT_FALSE(sheet.step(recover).step_failed);
    const Eigen::Matrix3Xd last = sheet.state().x;
    sheet.step(fail);
    EXPECT_FALSE(sheet.step({}).frozen);
    report = sheet.step({});
    EXPECT_TRUE(report.frozen && sheet.frozen());
    EXPECT_EQ(sheet.tick(), 10);

    // Frozen: served and cuttable, but time stands still, until a reset.
    report = sheet.step(recover);
    EXPECT_TRUE(report.replies.at(0).ok() && !report.advanced);
    EXPECT_EQ(sheet.tick(), 10);
    EXPECT_TRUE(sheet.state().x == last);
    ASSERT_TRUE(apply(sheet, scenes::line_cut({-0.1, 0.5}, {1.1, 0.5})).ok());
    EXPECT_EQ(sheet.mesh().num_pieces(), 2);
    EXPECT_FALSE(sheet.at_rest());
    ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
    EXPECT_FALSE(sheet.frozen());
    EXPECT_TRUE(sheet.step({}).advanced);
    EXPECT_EQ(sheet.tick(), 11);
  }
}

}  // namespace
}  // namespace kerf::sheet
