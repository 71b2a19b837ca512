// Constraints, loads and initial velocities of a scene, through cuts and undos.
#include <cmath>
#include <numbers>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using scenes::flat;

Vector3d total_force(const Sheet& sheet) {
  return sheet.loads().external_forces.rowwise().sum();
}

const fem::Pin* find_pin(const Sheet& sheet, mesh::VertexId v) {
  for (const fem::Pin& pin : sheet.loads().pins) {
    if (pin.vertex == v) return &pin;
  }
  return nullptr;
}

TEST(Constraints, HoldTheChosenComponentsAndNoOthers) {
  scene::SheetConfig config = flat(5);
  config.gravity = {1.0, 2.0, -3.0};
  config.constraints = {hold(scene::RegionEdge::kTop)};
  config.constraints[0].held = {false, true, false};
  Sheet sheet = make(config);
  run(sheet, 30);
  const double t = 0.5;
  for (int v = 20; v < 25; ++v) {
    EXPECT_EQ(sheet.state().x(1, v), 1.0);
    EXPECT_GT(sheet.state().x(0, v) - 0.25 * (v - 20), 0.2 * 0.5 * t * t);
    EXPECT_LT(sheet.state().x(2, v), -0.2 * 1.5 * t * t);
  }
}

TEST(Constraints, FollowTheirHistoriesStretchesAndRotations) {
  scene::SheetConfig config = flat(5);
  scene::Constraint moved = hold(scene::WholeSheet{});
  moved.displacement = {0.0, 0.0, 0.5};
  moved.stretch.col(0) = Vector3d(0.1, 0.0, 0.0);
  moved.rotation = scene::Rotation{{0.0, 0.0, 2.0}, {1.0, 0.0, 0.0}, std::numbers::pi};
  moved.history = {{0.0, 1.0}, {0.0, 1.0}};
  config.constraints = {moved};
  Sheet sheet = make(config);
  run(sheet, 30);  // half way: a quarter turn about (1, 0)
  for (int v = 0; v < 25; ++v) {
    const Vector2d X = sheet.mesh().rest_position(v);
    const Vector3d expected(1.0 - X.y() + 0.05 * X.x(), X.x() - 1.0, 0.25);
    EXPECT_LT((sheet.state().x.col(v) - expected).norm(), 1e-12);
  }
  EXPECT_FALSE(sheet.at_rest());
  run(sheet, 30);
  const Vector3d there = sheet.state().x.col(24);
  EXPECT_LT((there - Vector3d(1.1, -1.0, 0.5)).norm(), 1e-12);
  run(sheet, 130);
  EXPECT_LT((sheet.state().x.col(24) - there).norm(), 1e-12);
  EXPECT_TRUE(sheet.at_rest());
}

TEST(Constraints, EndWhenTheirTimeIsOver) {
  scene::SheetConfig config = flat(5);
  config.gravity = {0.0, 0.0, -9.81};
  config.constraints = {hold(scene::WholeSheet{})};
  config.constraints[0].until = 0.5;
  Sheet sheet = make(config);
  run(sheet, 29);
  EXPECT_EQ(sheet.state().x(2, 7), 0.0);
  EXPECT_FALSE(sheet.at_rest()) << "it will fall";
  run(sheet, 31);
  EXPECT_LT(sheet.state().x(2, 7), -1.0);
}

TEST(Constraints, TheLastOfSeveralAndAConstraintOverAPinHold) {
  scene::SheetConfig config = flat(5);
  config.pins = {scene::RegionEdge::kTop};
  scene::Constraint first = hold(scene::RegionEdge::kTop);
  first.displacement = {1.0, 1.0, 1.0};
  first.held = {true, true, false};
  scene::Constraint second = hold(scene::NearestVertex{{1.0, 1.0}});
  second.displacement = {2.0, 0.0, 0.0};
  second.held = {true, false, false};
  config.constraints = {first, second};
  const Sheet sheet = make(config);
  EXPECT_EQ(find_pin(sheet, 20)->target, Vector3d(1.0, 2.0, 0.0));
  EXPECT_EQ(find_pin(sheet, 24)->target, Vector3d(3.0, 2.0, 0.0));
  EXPECT_TRUE(find_pin(sheet, 24)->is_whole());
  EXPECT_EQ(sheet.loads().pins.size(), 5U);
  EXPECT_EQ(sheet.pinned_vertices().size(), 5U);
}

TEST(Constraints, ListedVerticesMayEachGoTheirOwnWay) {
  scene::SheetConfig config = flat(5);
  config.constraints = {hold(std::vector<mesh::VertexId>{7, 2})};
  config.constraints[0].displacements.resize(3, 2);
  config.constraints[0].displacements << 0.7, 0.2, 0.0, 0.0, 0.0, 0.0;
  const Sheet sheet = make(config);
  EXPECT_EQ(find_pin(sheet, 7)->target, Vector3d(0.5 + 0.7, 0.25, 0.0));
  EXPECT_EQ(find_pin(sheet, 2)->target, Vector3d(0.5 + 0.2, 0.0, 0.0));
}

TEST(Constraints, ReachNewVerticesOnTheirPlaceAndLeaveWithAnUndo) {
  for (const bool listed : {false, true}) {
    scene::SheetConfig config = flat(5);
    scene::Region top = scene::RegionEdge::kTop;
    if (listed) top = std::vector<mesh::VertexId>{20, 21, 22, 23, 24};
    config.constraints = {hold(top)};
    config.constraints[0].stretch.col(0) = Vector3d(0.0, 1.0, 0.0);
    Sheet sheet = make(config);
    const std::uint64_t before = sheet.shape_hash();
    ASSERT_TRUE(apply(sheet, scenes::line_cut({0.6, 0.4}, {0.6, 1.2})).ok());
    ASSERT_GT(sheet.mesh().num_vertices(), 25);
    int new_on_top = 0;
    for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
      const Vector2d X = sheet.mesh().rest_position(v);
      const fem::Pin* const pin = find_pin(sheet, v);
      EXPECT_EQ(pin != nullptr, X.y() > 1.0 - 1e-6) << listed << " " << v;
      if (pin == nullptr) continue;
      EXPECT_LT((pin->target - Vector3d(X.x(), X.y() + X.x(), 0.0)).norm(), 1e-9) << listed << " " << v;
      new_on_top += v >= 25 ? 1 : 0;
    }
    EXPECT_GE(new_on_top, 2) << "a vertex for each lip";
    ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
    EXPECT_EQ(sheet.loads().pins.size(), 5U);
    EXPECT_EQ(sheet.shape_hash(), before);
    ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
    EXPECT_EQ(sheet.loads().pins.size(), static_cast<std::size_t>(5 + new_on_top));
  }
}

TEST(Constraints, AResetBeginsTheirHistoriesAnew) {
  scene::SheetConfig config = flat(5);
  config.constraints = {hold(scene::WholeSheet{})};
  config.constraints[0].displacement = {1.0, 0.0, 0.0};
  config.constraints[0].history = {{0.0, 1.0}, {0.0, 1.0}};
  Sheet sheet = make(config);
  run(sheet, 20);
  const Vector3d there = sheet.state().x.col(3);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(Vector3d(sheet.state().x.col(3)), Vector3d(0.75, 0.0, 0.0));
  run(sheet, 20);
  EXPECT_EQ(Vector3d(sheet.state().x.col(3)), there);
}

TEST(Constraints, CopiesGoOnAlike) {
  scene::SheetConfig config = flat(9);
  config.gravity = {0.0, 0.0, -9.81};
  config.constraints = {hold(scene::RegionEdge::kTop), hold(scene::RegionEdge::kBottom)};
  config.constraints[0].slope = true;
  config.constraints[0].rotation = scene::Rotation{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, 1.0};
  config.constraints[0].history = {{0.0, 0.5}, {0.0, 1.0}};
  config.constraints[1].until = 0.4;
  config.loads = {{scene::PointForce{Vector2d(0.4, 0.4), Vector3d(0.0, 0.0, 0.01)}, {{0.0, 0.3}, {0.0, 1.0}}}};
  Sheet sheet = make(config);
  run(sheet, 11);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.3, 0.2}, {0.7, 1.2})).ok());
  Sheet copy = sheet;
  run(sheet, 25);
  run(copy, 25);
  EXPECT_EQ(sheet.state_hash(), copy.state_hash());
}

TEST(Constraints, AfterAResetSlopesAreHeldAsByAFreshSheet) {
  scene::SheetConfig config = flat(9);
  config.gravity = {0.0, 0.0, -9.81};
  config.constraints = {hold(scene::RegionEdge::kTop)};
  config.constraints[0].slope = true;
  Sheet fresh = make(config);
  Sheet again = make(config);
  run(again, 11);
  ASSERT_TRUE(apply(again, scene::Reset{}).ok());
  run(fresh, 20);
  run(again, 20);
  EXPECT_EQ(again.state().x, fresh.state().x);
}

TEST(PlanarSheets, StayInTheirPlaneAndDoNotBend) {
  scene::SheetConfig config = flat(6);
  config.planar = true;
  config.gravity = {0.0, -1.0, -9.81};
  Sheet sheet = make(config);
  EXPECT_FALSE(sheet.model().materials().has_bending());
  ASSERT_TRUE(apply(sheet, scenes::line_cut({-0.2, 0.4}, {0.6, 0.55})).ok());
  run(sheet, 30);
  EXPECT_EQ(sheet.state().x.row(2).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LT(sheet.state().x(1, 0), -0.1);
  config.placement.y_axis = Vector3d(0.0, 1.0, 1.0).normalized();
  EXPECT_EQ(refused(config), "NOT_PLANAR planar");
}

TEST(Forces, AddUpToWhatWasAskedForThroughCuts) {
  scene::SheetConfig config = flat(9);
  const Vector3d force(1.0, -2.0, 0.5);
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kRight, force, true}, {}},
                  {scene::EdgeForce{scene::RegionEdge::kTop, force, false}, {}},
                  {scene::AreaForce{scene::WholeSheet{}, force, true}, {}},
                  {scene::AreaForce{scene::MaterialBox{{0.0, 0.0}, {0.5, 0.5}}, force, false}, {}},
                  {scene::PointForce{Vector2d(0.3, 0.3), force}, {}},
                  {scene::PointForce{mesh::VertexId{44}, force}, {}}};
  Sheet sheet = make(config);
  const Vector3d all = (1.0 + 1.0 + 1.0 + 0.25 + 1.0 + 1.0) * force;
  EXPECT_LT((total_force(sheet) - all).norm(), 1e-12);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, 0.7}, {1.2, 0.8})).ok());
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.72, 0.6}, {0.7, 1.2})).ok());
  EXPECT_LT((total_force(sheet) - all).norm(), 1e-9);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_LT((total_force(sheet) - all).norm(), 1e-9);
  // Corners of an edge carry half of what its other vertices do.
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kRight, force, true}, {}}};
  sheet = make(config);
  EXPECT_LT((Vector3d(sheet.loads().external_forces.col(8)) - force / 16.0).norm(), 1e-15);
  EXPECT_LT((Vector3d(sheet.loads().external_forces.col(17)) - force / 8.0).norm(), 1e-15);
}

TEST(Forces, ActOnLipsOnceAScheduledCutHasMadeThem) {
  scene::SheetConfig config = flat(9);
  const Vector3d force(0.0, 0.0, 3.0);
  const scene::MaterialLine upper_lip{{0.0, 0.5}, {1.0, 0.5}, 0.0, scene::MaterialLine::Side::kLeft};
  config.loads = {{scene::EdgeForce{upper_lip, force, true}, {}}};
  EXPECT_EQ(refused(config), "NOTHING_LOADED loads[0].edge.region");
  config.commands = {{2, scenes::line_cut({0.25, 0.5}, {0.75, 0.5})}};
  Sheet sheet = make(config);
  sheet.step({});
  EXPECT_EQ(total_force(sheet), Vector3d(0.0, 0.0, 0.0));
  sheet.step({});
  EXPECT_LT((total_force(sheet) - force).norm(), 1e-12);
}

TEST(Forces, FollowTheirHistories) {
  scene::SheetConfig config = flat(5);
  config.gravity = {0.0, 0.0, -1.0};
  config.gravity_history = {{0.0, 1.0}, {0.0, 1.0}};
  config.loads = {{scene::AreaForce{scene::WholeSheet{}, {0.0, 0.0, 2.0}, true}, {{0.0, 0.5}, {1.0, 0.0}}}};
  Sheet sheet = make(config);
  run(sheet, 15);
  EXPECT_NEAR(total_force(sheet).z(), 1.0, 1e-12);
  EXPECT_NEAR(sheet.loads().gravity.z(), -0.25, 1e-12);
  EXPECT_EQ(sheet.gravity(), Vector3d(0.0, 0.0, -1.0));
  run(sheet, 45);
  EXPECT_EQ(total_force(sheet).z(), 0.0);
}

TEST(Forces, KeepASheetAwakeThatTheyWillStillMove) {
  scene::SheetConfig config = flat(5);
  config.material.mass_damping = 0.0;
  config.gravity = {0.0, 0.0, -1.0};
  config.gravity_history = {{1.5, 1.6}, {0.0, 1.0}};
  Sheet sheet = make(config);
  run(sheet, 80);
  EXPECT_LT(sheet.state().v.cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_FALSE(sheet.at_rest());
  run(sheet, 40);
  EXPECT_LT(sheet.state().v(2, 0), -0.1);
}

TEST(Forces, PressureAndMomentsStayWhereTheyActThroughCuts) {
  scene::SheetConfig config = flat(9);
  config.loads = {{scene::Pressure{scene::WholeSheet{}, 3.0}, {}},
                  {scene::Pressure{scene::MaterialBox{{0.0, 0.0}, {0.5, 1.0}}, 2.0}, {{0.0, 1.0}, {0.0, 1.0}}},
                  {scene::EdgeMoment{scene::RegionEdge::kRight, 0.5, true}, {}},
                  {scene::EdgeMoment{scene::RegionEdge::kTop, 0.25, false}, {}}};
  Sheet sheet = make(config);
  const auto pressed = [&] {
    double force = 0.0;  // N, while the sheet is flat
    for (mesh::TriangleId t = 0; t < sheet.mesh().num_triangle_slots(); ++t) {
      if (!sheet.mesh().is_solid(t)) continue;
      const auto& corner = sheet.mesh().vertices(t);
      const Vector2d a = sheet.mesh().rest_position(corner[1]) - sheet.mesh().rest_position(corner[0]);
      const Vector2d b = sheet.mesh().rest_position(corner[2]) - sheet.mesh().rest_position(corner[0]);
      force += sheet.loads().pressure.at(static_cast<std::size_t>(t)) * 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    return force;
  };
  const auto moments = [&] {
    double sum = 0.0;
    for (const fem::EdgeMoment& moment : sheet.loads().edge_moments) sum += moment.moment;
    return sum;
  };
  EXPECT_NEAR(pressed(), 3.0, 1e-12);
  EXPECT_EQ(sheet.loads().edge_moments.size(), 16U);
  EXPECT_NEAR(moments(), 0.5 + 0.25, 1e-12);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.7, 0.7}, {1.2, 0.8})).ok());
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.72, 0.6}, {0.7, 1.2})).ok());
  EXPECT_NEAR(pressed(), 3.0, 1e-9);
  EXPECT_NEAR(moments(), 0.5 + 0.25, 1e-9);
  EXPECT_EQ(sheet.loads().pressure.size(), static_cast<std::size_t>(sheet.mesh().num_triangle_slots()));
  run(sheet, 30);
  EXPECT_NEAR(pressed(), 3.0 + 0.5, 0.02) << "half of its history, on half of the sheet, to the nearest triangle";
}

// Two moments at one edge are one: what they store at the border goes by their sum.
TEST(Forces, MomentsOfSeveralLoadsAddUpEdgeByEdge) {
  const auto stored = [](const std::vector<double>& moments) {
    scene::SheetConfig config = flat(5);
    for (const double moment : moments)
      config.loads.push_back({scene::EdgeMoment{scene::RegionEdge::kTop, moment, false}, {}});
    const Sheet sheet = make(config);
    EXPECT_EQ(sheet.loads().edge_moments.size(), 4U);
    return sheet.energies().bending;
  };
  const double once = stored({0.5});
  EXPECT_GT(once, 0.0);
  EXPECT_EQ(stored({0.25, 0.25}), once);
  EXPECT_NEAR(stored({0.75, -0.25}), once, 1e-12 * once);
  EXPECT_LT(std::abs(stored({0.5, -0.5})), 1e-12 * once);
}

TEST(Forces, WithoutAnythingToActOnAreRefused) {
  scene::SheetConfig config = flat(5);
  config.loads = {{scene::EdgeForce{scene::NearestVertex{{0.0, 0.0}}, {1.0, 0.0, 0.0}, true}, {}}};
  EXPECT_EQ(refused(config), "NOTHING_LOADED loads[0].edge.region");
  config.loads = {{scene::AreaForce{scene::RegionEdge::kTop, {1.0, 0.0, 0.0}, true}, {}}};
  EXPECT_EQ(refused(config), "NOTHING_LOADED loads[0].area.region");
  config.loads = {{scene::PointForce{Vector2d(1.5, 0.0), {1.0, 0.0, 0.0}}, {}}};
  EXPECT_EQ(refused(config), "POINT_OUTSIDE loads[0].point.material");
  config.loads = {{scene::PointForce{mesh::VertexId{25}, {1.0, 0.0, 0.0}}, {}}};
  EXPECT_EQ(refused(config), "UNKNOWN_VERTEX loads[0].point.vertex");
  config.loads.clear();
  config.constraints = {hold(std::vector<mesh::VertexId>{3, 25})};
  EXPECT_EQ(refused(config), "UNKNOWN_VERTEX constraints[0].region.vertices.vertices[1]");
}

TEST(InitialVelocities, TurnAboutTheCentreOfMassUnlessToldOtherwise) {
  scene::SheetConfig config = flat(5);
  config.initial_velocity = scene::InitialVelocity{{1.0, 0.0, 0.0}, {0.0, 0.0, 2.0}, {}};
  Sheet sheet = make(config);
  EXPECT_LT(
      (sheet.model().momentum(sheet.state()).linear - sheet.model().masses().total() * Vector3d(1.0, 0.0, 0.0)).norm(),
      1e-12);
  EXPECT_LT((Vector3d(sheet.state().v.col(24)) - Vector3d(1.0 - 1.0, 1.0, 0.0)).norm(), 1e-12);
  config.initial_velocity->centre = Vector3d(1.0, 1.0, 0.0);
  EXPECT_LT((Vector3d(make(config).state().v.col(24)) - Vector3d(1.0, 0.0, 0.0)).norm(), 1e-12);
  run(sheet, 5);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_LT((Vector3d(sheet.state().v.col(24)) - Vector3d(0.0, 1.0, 0.0)).norm(), 1e-12);
}

TEST(Integrators, AreThoseThatTheSceneAsksFor) {
  scene::SheetConfig config = flat(5);
  config.gravity = {0.0, 0.0, -9.81};
  config.material.mass_damping = 0.0;
  // Free fall by one tick tells them apart: implicit Euler is half a tick late, those of second order are right.
  for (const scene::IntegratorKind kind : {scene::IntegratorKind::kImplicitEuler, scene::IntegratorKind::kTrapezoidal,
                                           scene::IntegratorKind::kBdf2, scene::IntegratorKind::kTrBdf2}) {
    config.integrator.kind = kind;
    Sheet sheet = make(config);
    sheet.step({});
    const double exact = -0.5 * 9.81 * sheet.dt() * sheet.dt();
    const double factor = kind == scene::IntegratorKind::kImplicitEuler ? 2.0 : 1.0;
    EXPECT_NEAR(sheet.state().x(2, 12), factor * exact, 1e-6 * std::abs(exact)) << sheet.integrator_description();
  }
}

}  // namespace
}  // namespace kerf::sheet
