// Compares measurements of probes with known values of simple states.
#include "server/core/analysis/probe.h"

#include <cmath>
#include <map>

#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "tests/sheet/calls.h"

namespace kerf::analysis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using scene::Probe;
using scene::Quantity;
using scene::Reduce;
using scene::SheetConfig;

Probe at_points(const std::string& name, Quantity quantity, std::vector<Vector2d> points) {
  return {name, quantity, std::move(points), {}, Reduce::kEach, {}};
}

Probe over(const std::string& name, Quantity quantity, scene::Region region, Reduce reduce) {
  return {name, quantity, {}, std::move(region), reduce, {}};
}

// Held everywhere: x = X + gradient X in the plane z = 0, of an isotropic material.
SheetConfig stretched(const Eigen::Matrix<double, 3, 2>& gradient) {
  SheetConfig config = scenes::hanging(5);
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.gravity.setZero();
  config.material = fem::isotropic(2.0e6, 0.25, 1.0e-3, 1000.0);
  scene::Constraint all;
  all.region = scene::WholeSheet{};
  all.stretch = gradient;
  config.constraints = {all};
  return config;
}

std::map<std::string, double> measure(const sheet::Sheet& sheet, const std::vector<Probe>& requests) {
  Result<Probes> probes = Probes::create(requests, sheet);
  if (!probes.ok()) {
    ADD_FAILURE() << probes.error().message;
    return {};
  }
  std::vector<double> row;
  probes->measure(sheet, {}, 0.0, row);
  EXPECT_EQ(row.size(), probes->columns().size());
  std::map<std::string, double> found;
  for (std::size_t i = 0; i < row.size(); ++i) found[probes->columns()[i]] = row[i];
  return found;
}

TEST(Probes, GiveDisplacementsPositionsAndTheirReductions) {
  Eigen::Matrix<double, 3, 2> gradient;
  gradient << 0.1, 0.2, 0.0, -0.1, 0.0, 0.0;
  sheet::Sheet sheet = sheet::make(stretched(gradient));
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  auto found = measure(sheet, {at_points("u", Quantity::kDisplacement, {{0.3, 0.7}}),
                               at_points("p", Quantity::kPosition, {{1.0, 1.0}, {0.0, 0.5}}),
                               over("top", Quantity::kDisplacement, scene::RegionEdge::kTop, Reduce::kMean),
                               over("least", Quantity::kPosition, scene::WholeSheet{}, Reduce::kMin),
                               over("most", Quantity::kPosition, scene::WholeSheet{}, Reduce::kMax),
                               over("sum", Quantity::kDisplacement, scene::RegionEdge::kRight, Reduce::kSum)});
  EXPECT_NEAR(found.at("u.x"), 0.1 * 0.3 + 0.2 * 0.7, 1e-9);
  EXPECT_NEAR(found.at("u.y"), -0.1 * 0.7, 1e-9);
  EXPECT_NEAR(found.at("p[0].x"), 1.3, 1e-12);
  EXPECT_NEAR(found.at("p[1].y"), 0.45, 1e-9);
  EXPECT_NEAR(found.at("top.x"), 0.05 + 0.2, 1e-12);
  EXPECT_NEAR(found.at("least.y"), 0.0, 1e-12);
  EXPECT_NEAR(found.at("most.x"), 1.3, 1e-12);
  EXPECT_NEAR(found.at("sum.x"), 5 * 0.1 + 0.2 * 2.5, 1e-12);
}

TEST(Probes, GiveStrainAndStressInMaterialAxesHoweverTheFibresRun) {
  Eigen::Matrix<double, 3, 2> gradient;
  gradient << 2e-3, 1e-3, 1e-3, -1e-3, 0.0, 0.0;  // symmetric: no rotation
  for (const double direction : {0.0, 0.6}) {
    SheetConfig config = stretched(gradient);
    config.material.direction = direction;
    sheet::Sheet sheet = sheet::make(config);
    ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
    auto found = measure(
        sheet, {at_points("e", Quantity::kStrain, {{0.31, 0.72}}), at_points("s", Quantity::kStress, {{0.5, 0.5}}),
                over("all", Quantity::kStress, scene::WholeSheet{}, Reduce::kMax)});
    EXPECT_NEAR(found.at("e.xx"), 2e-3, 1e-12);
    EXPECT_NEAR(found.at("e.yy"), -1e-3, 1e-12);
    EXPECT_NEAR(found.at("e.xy"), 1e-3, 1e-12);
    const double q = 2.0e6 / (1.0 - 0.25 * 0.25);
    EXPECT_NEAR(found.at("s.xx"), q * (2e-3 - 0.25e-3), 1e-5);
    EXPECT_NEAR(found.at("s.yy"), q * (0.5e-3 - 1e-3), 1e-5);
    EXPECT_NEAR(found.at("s.xy"), 2.0 * 0.8e6 * 1e-3, 1e-5);
    EXPECT_NEAR(found.at("all.xx"), found.at("s.xx"), 1e-5);
  }
}

// One strain everywhere, whichever way it is asked for.
TEST(Probes, PatchesOfAUniformFieldAreThatFieldEverywhere) {
  Eigen::Matrix<double, 3, 2> gradient;
  gradient << 2e-3, 1e-3, 1e-3, -1e-3, 0.0, 0.0;
  SheetConfig config = stretched(gradient);
  config.material.direction = 0.6;
  sheet::Sheet sheet = sheet::make(config);
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  std::vector<Probe> probes{at_points("inside", Quantity::kStrain, {{0.31, 0.72}, {0.5, 0.5}, {0.0, 1.0}, {0.3, 0.0}}),
                            over("all", Quantity::kStrain, scene::WholeSheet{}, Reduce::kMean),
                            over("edge", Quantity::kStrain, scene::RegionEdge::kTop, Reduce::kMean),
                            over("most", Quantity::kStrain, scene::RegionEdge::kTop, Reduce::kMax)};
  for (Probe& probe : probes) probe.recovery = scene::Recovery::kPatch;
  const auto found = measure(sheet, probes);
  EXPECT_EQ(found.size(), 21U);
  for (const auto& [column, value] : found) {
    EXPECT_NEAR(value, column.ends_with("xx") ? 2e-3 : column.ends_with("yy") ? -1e-3 : 1e-3, 1e-12) << column;
  }
}

// Held to x = X + k X^2 / 2 along X: strain k X, of which triangles have a mean each, and a patch the line.
TEST(Probes, PatchesFollowALinearFieldWhereTrianglesStepAlongIt) {
  constexpr double kSlope = 1e-4;  // 1/m
  SheetConfig config = stretched(Eigen::Matrix<double, 3, 2>::Zero());
  config.material.poissons_ratio_12 = 0.0;
  const sheet::Sheet flat = sheet::make(config);
  std::vector<mesh::VertexId> all;
  config.constraints[0].displacements.setZero(3, flat.mesh().num_vertices());
  for (mesh::VertexId v = 0; v < flat.mesh().num_vertices(); ++v) {
    const double x = flat.mesh().rest_position(v).x();
    all.push_back(v);
    config.constraints[0].displacements(0, v) = 0.5 * kSlope * x * x;
  }
  config.constraints[0].region = all;
  sheet::Sheet sheet = sheet::make(config);
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  Probe patch = at_points("patch", Quantity::kStrain, {{0.25, 0.5}, {0.3, 0.61}, {1.0, 0.5}, {0.9, 0.45}});
  patch.recovery = scene::Recovery::kPatch;
  Probe mean = at_points("mean", Quantity::kStrain, {{1.0, 0.5}});
  Probe middle = over("middle", Quantity::kStrain, scene::WholeSheet{}, Reduce::kMean);
  middle.recovery = scene::Recovery::kPatch;
  Probe edge = over("edge", Quantity::kStrain, scene::RegionEdge::kRight, Reduce::kMax);
  edge.recovery = scene::Recovery::kPatch;
  auto found = measure(sheet, {patch, mean, middle, edge});
  EXPECT_NEAR(found.at("patch[0].xx"), 0.25 * kSlope, 1e-9);
  EXPECT_NEAR(found.at("patch[1].xx"), 0.3 * kSlope, 1e-9);
  EXPECT_NEAR(found.at("patch[2].xx"), kSlope, 1e-9);
  EXPECT_NEAR(found.at("patch[3].xx"), 0.9 * kSlope, 1e-9);
  EXPECT_NEAR(found.at("middle.xx"), 0.5 * kSlope, 1e-9) << "weighted by area";
  EXPECT_NEAR(found.at("edge.xx"), kSlope, 1e-9);
  EXPECT_LT(found.at("mean.xx"), 0.9 * kSlope) << "triangles on one side alone";
}

// Pulled along x and squeezed along y, F = diag(1.2, 0.9): Cauchy's stress is P F^T / det F.
TEST(Probes, CauchyStressIsForceByAreaAsItIs) {
  Eigen::Matrix<double, 3, 2> gradient;
  gradient << 0.2, 0.0, 0.0, -0.1, 0.0, 0.0;
  sheet::Sheet sheet = sheet::make(stretched(gradient));
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  Probe biot = at_points("biot", Quantity::kStress, {{0.31, 0.72}});
  Probe cauchy = biot;
  cauchy.name = "cauchy";
  cauchy.measure = scene::StressMeasure::kCauchy;
  Probe by_patch = cauchy;
  by_patch.name = "patch";
  by_patch.recovery = scene::Recovery::kPatch;
  auto found = measure(sheet, {biot, cauchy, by_patch});
  const double q = 2.0e6 / (1.0 - 0.25 * 0.25);
  EXPECT_NEAR(found.at("biot.xx"), q * (0.2 - 0.25 * 0.1), 1e-3);
  EXPECT_NEAR(found.at("cauchy.xx"), found.at("biot.xx") / 0.9, 1e-3);
  EXPECT_NEAR(found.at("cauchy.yy"), found.at("biot.yy") / 1.2, 1e-3);
  EXPECT_NEAR(found.at("patch.xx"), found.at("cauchy.xx"), 1e-3);
}

TEST(Probes, ReactionsBalanceTheLoads) {
  SheetConfig config = stretched(Eigen::Matrix<double, 3, 2>::Zero());
  config.constraints[0].region = scene::RegionEdge::kBottom;
  config.gravity = {0.0, -2.0, 0.0};
  config.planar = true;
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kTop, {0.3, 0.5, 0.0}, true}, {}},
                  {scene::EdgeForce{scene::RegionEdge::kBottom, {0.1, 0.0, 0.0}, true}, {}}};
  sheet::Sheet sheet = sheet::make(config);
  ASSERT_TRUE(sheet.settle(1.0, {}, {}).converged);
  auto found = measure(sheet, {over("r", Quantity::kReaction, scene::RegionEdge::kBottom, Reduce::kSum)});
  EXPECT_NEAR(found.at("r.x"), -0.4, 1e-8);
  EXPECT_NEAR(found.at("r.y"), -0.5 + 2.0 * sheet.model().masses().total(), 1e-8);
  EXPECT_NEAR(found.at("r.z"), 0.0, 1e-8);
}

TEST(Probes, ReactionsInTimeIncludeWhatTheMotionOfWhatIsHeldTakes) {
  SheetConfig config = stretched(Eigen::Matrix<double, 3, 2>::Zero());
  config.constraints[0].displacement = {0.0, 0.0, 1.0};
  // Speeds up evenly by a polygon: 1 m/s in the first half second, 2 m/s in the second.
  config.constraints[0].history = {{0.0, 0.5, 1.0}, {0.0, 0.5, 1.5}};
  sheet::Sheet sheet = sheet::make(config);
  Result<Probes> probes = Probes::create({over("r", Quantity::kReaction, scene::WholeSheet{}, Reduce::kSum)}, sheet);
  ASSERT_TRUE(probes.ok());
  double impulse = 0.0;  // N s
  for (int i = 0; i < 60; ++i) {
    const linear::VertexField before = sheet.state().v;
    sheet.step({});
    std::vector<double> row;
    probes->measure(sheet, before, sheet.dt(), row);
    impulse += row[2] * sheet.dt();
  }
  EXPECT_NEAR(impulse, 2.0 * sheet.model().masses().total(), 1e-6);
}

// A stiff sheet that is let go sideways from a hinge: of a large step, Newton's method must leave little.
TEST(Probes, ReactionsOfAnImplicitStepBalanceTheMomentumWhenTheSolverToleranceIsTight) {
  SheetConfig config = stretched(Eigen::Matrix<double, 3, 2>::Zero());
  config.constraints[0].region = scene::RegionEdge::kTop;
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = 1e9;
  config.material.shear_modulus = 4e8;
  config.gravity = {0.0, -9.81, -4.0};
  config.integrator = {.kind = scene::IntegratorKind::kImplicitEuler,
                       .newton_iterations = 30,
                       .solver_tolerance = 1e-11,
                       .solver = scene::LinearSolverKind::kDirect};
  sheet::Sheet sheet = sheet::make(config);
  Result<Probes> probes =
      Probes::create({over("r", Quantity::kReaction, scene::RegionEdge::kTop, Reduce::kSum)}, sheet);
  ASSERT_TRUE(probes.ok());
  for (int i = 0; i < 3; ++i) {
    const linear::VertexField before = sheet.state().v;
    const Eigen::Vector3d momentum_before = sheet.model().momentum(sheet.state()).linear;
    sheet.step({});
    const Eigen::Vector3d change = sheet.model().momentum(sheet.state()).linear - momentum_before;
    std::vector<double> row;
    probes->measure(sheet, before, sheet.dt(), row);
    const Eigen::Vector3d weight = sheet.model().masses().total() * config.gravity;
    const Eigen::Vector3d held = change / sheet.dt() - weight;
    EXPECT_LT((Eigen::Vector3d(row[0], row[1], row[2]) - held).norm(), 1e-4 * weight.norm()) << i;
  }
}

TEST(Probes, MeasureTheWholeSheet) {
  SheetConfig config = scenes::hanging(5);
  config.pins.clear();
  config.gravity = {0.0, 0.0, -10.0};
  config.initial_velocity = scene::InitialVelocity{{0.5, 0.0, 0.0}, {0.0, 3.0, 0.0}, {}};
  const sheet::Sheet sheet = sheet::make(config);
  const double m = sheet.model().masses().total();
  auto found = measure(sheet, {at_points("e", Quantity::kEnergy, {}), at_points("p", Quantity::kMomentum, {}),
                               at_points("l", Quantity::kAngularMomentum, {}),
                               at_points("c", Quantity::kCentreOfMass, {}), at_points("size", Quantity::kExtent, {})});
  EXPECT_NEAR(found.at("c.x"), 0.5, 1e-12);
  EXPECT_NEAR(found.at("c.z"), 0.5, 1e-12);
  EXPECT_NEAR(found.at("e.gravity"), 10.0 * m * 0.5, 1e-12);
  EXPECT_NEAR(found.at("e.total"), found.at("e.gravity") + found.at("e.kinetic"), 1e-12);
  EXPECT_NEAR(found.at("p.x"), 0.5 * m, 1e-12);
  EXPECT_GT(found.at("l.y"), 3.0 * m / 6.0);
  EXPECT_NEAR(found.at("l.x"), 0.0, 1e-12);
  EXPECT_NEAR(found.at("size.x"), 1.0, 1e-12);
  EXPECT_NEAR(found.at("size.y"), 0.0, 1e-12);
}

// A slit across the middle whose lips are moved apart by hand.
TEST(Probes, OpeningIsSignedInTheFrameOfTheLips) {
  SheetConfig config = scenes::hanging(9);
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.gravity.setZero();
  const auto hold = [](scene::Region region, const Vector3d& displacement) {
    scene::Constraint constraint;
    constraint.region = std::move(region);
    constraint.displacement = displacement;
    return constraint;
  };
  sheet::Sheet sheet = sheet::make(config);
  const std::vector<Probe> probes{at_points("gap", Quantity::kOpening, {{0.5, 0.5}, {0.5, 0.9}})};
  EXPECT_TRUE(std::isnan(measure(sheet, probes).at("gap[0].normal"))) << "no cut yet";
  config.commands = {{1, scenes::line_cut({-0.2, 0.5}, {1.2, 0.5})}};
  // All of the upper half, and of the line both share the lower lip alone.
  config.constraints = {
      hold(scene::MaterialBox{{0.0, 0.5}, {1.0, 1.0}}, {0.02, 0.03, 0.004}),
      hold(scene::MaterialBox{{0.0, 0.0}, {1.0, 0.49}}, Vector3d::Zero()),
      hold(scene::MaterialLine{{0.0, 0.5}, {1.0, 0.5}, 0.0, scene::MaterialLine::Side::kRight}, Vector3d::Zero())};
  sheet = sheet::make(config);
  sheet.begin_load_step();
  const fem::EquilibriumStats stats = sheet.settle(1.0, {}, {});
  ASSERT_TRUE(stats.converged);
  auto found = measure(sheet, probes);
  EXPECT_NEAR(found.at("gap[0].normal"), 0.03, 1e-9);
  EXPECT_NEAR(found.at("gap[0].sliding"), 0.02, 1e-9);
  EXPECT_NEAR(found.at("gap[0].lateral"), 0.004, 1e-9);
  EXPECT_TRUE(std::isnan(found.at("gap[1].normal"))) << "not on the cut";
}

TEST(Probes, ASideChoosesTheLip) {
  SheetConfig config = scenes::hanging(9);
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.pins.clear();
  config.gravity.setZero();
  config.integrator.precision = scene::Precision::kDouble;  // so that what is at rest stays there
  sheet::Sheet sheet = sheet::make(config);
  ASSERT_TRUE(sheet::apply(sheet, scenes::line_cut({-0.2, 0.5}, {1.2, 0.5})).ok());
  Probe upper = at_points("upper", Quantity::kVelocity, {{0.33, 0.5}});
  upper.side = Vector2d(0.33, 1.0);
  Probe lower = upper;
  lower.name = "lower";
  lower.side = Vector2d(0.33, 0.0);
  // Between the lips' vertices and at one of them: nothing has moved yet.
  Probe still = upper;
  still.quantity = Quantity::kDisplacement;
  still.points = {{0.33, 0.5}, {0.375, 0.5}};
  for (const auto& [column, value] : measure(sheet, {still})) EXPECT_NEAR(value, 0.0, 1e-14) << column;
  // Whatever happens above stays above.
  scene::Grab grab{"up", Vector2d(0.4, 0.9), Vector3d(0.4, 3.0, 0.0), 0.0};
  ASSERT_TRUE(sheet::apply(sheet, grab).ok());
  sheet::run(sheet, 20);
  auto found = measure(sheet, {upper, lower});
  EXPECT_GT(std::abs(found.at("upper.y")), 1e-3);
  EXPECT_LT(std::abs(found.at("lower.y")), 1e-12);
}

TEST(Probes, OfLipsWaitForTheCutThatMakesThem) {
  SheetConfig config = scenes::hanging(9);
  const cut::Circle arc{{0.5, 0.5}, 0.19};
  const Probe rim = over("rim", Quantity::kPosition, scene::MaterialCurve{arc}, Reduce::kMean);
  const sheet::Sheet uncut = sheet::make(config);
  const Result<Probes> refused = Probes::create({rim}, uncut);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "REGION_EMPTY");
  scene::Cut slit;
  slit.curve = arc;
  config.commands = {{1, slit}};
  sheet::Sheet sheet = sheet::make(config);
  Result<Probes> probes = Probes::create({rim}, sheet);
  ASSERT_TRUE(probes.ok());
  std::vector<double> row;
  probes->measure(sheet, {}, 0.0, row);
  EXPECT_TRUE(std::isnan(row.at(0)));
  sheet.step({});
  row.clear();
  probes->measure(sheet, {}, 0.0, row);
  EXPECT_NEAR(row.at(0), 0.5, 1e-3);
}

TEST(Probes, RefuseWhatIsNotThereAndSayNaNOfWhatIsCutAway) {
  SheetConfig config = scenes::hanging(9);
  sheet::Sheet sheet = sheet::make(config);
  const auto refusal = [&](const Probe& probe) {
    const Result<Probes> probes = Probes::create({probe}, sheet);
    return probes.ok() ? "made" : probes.error().reason + " " + probes.error().field;
  };
  EXPECT_EQ(refusal(at_points("a", Quantity::kPosition, {{0.5, 0.5}, {1.5, 0.5}})),
            "POINT_OUTSIDE probes[0].points[1]");
  EXPECT_EQ(refusal(over("a", Quantity::kStress, scene::RegionEdge::kTop, Reduce::kMax)),
            "REGION_EMPTY probes[0].region");
  EXPECT_EQ(refusal(over("a", Quantity::kReaction, std::vector<mesh::VertexId>{99}, Reduce::kSum)),
            "UNKNOWN_VERTEX probes[0].region.vertices.vertices[0]");
  Result<Probes> probes = Probes::create({at_points("a", Quantity::kPosition, {{0.5, 0.5}})}, sheet);
  scene::Cut wide = scenes::line_cut({0.4, 0.5}, {0.6, 0.5});
  wide.options.width_m = 0.1;
  ASSERT_TRUE(sheet::apply(sheet, wide).ok());
  std::vector<double> row;
  probes->measure(sheet, {}, 0.0, row);
  EXPECT_TRUE(std::isnan(row.at(0)));
}

}  // namespace
}  // namespace kerf::analysis
