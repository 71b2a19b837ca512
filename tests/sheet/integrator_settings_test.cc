// Linear solvers as a sheet has them: what dense ones refuse, and that those that solve a different system do no harm.
#include "server/core/scene/integrator_settings.h"

#include "server/core/fem/element/state.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

scene::SheetConfig dense_scene(scene::LinearSolverKind solver, std::int32_t columns, std::int32_t rows) {
  scene::SheetConfig config = scenes::hanging(4);
  config.mesh = scene::GridSource{.columns = columns, .rows = rows};
  config.integrator.kind = scene::IntegratorKind::kImplicitEuler;
  config.integrator.solver = solver;
  return config;
}

double total_energy(const Sheet& sheet) {
  const Energies energies = sheet.energies();
  return energies.kinetic + energies.membrane + energies.bending + energies.gravity;
}

class DenseSolver : public testing::TestWithParam<scene::LinearSolverKind> {};

TEST_P(DenseSolver, TakesFiveHundredVerticesAndNoMore) {
  EXPECT_TRUE(Sheet::create(dense_scene(GetParam(), 25, 20)).ok());
  const Result<Sheet> refused = Sheet::create(dense_scene(GetParam(), 3, 167));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "SOLVER_TOO_DENSE");
  EXPECT_EQ(refused.error().field, "integrator.solver");
  EXPECT_NE(refused.error().message.find("501 vertices"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("500"), std::string::npos) << refused.error().message;
}

TEST_P(DenseSolver, LimitsNoSheetWhoseIntegratorHasNoUseForIt) {
  for (const scene::IntegratorKind kind :
       {scene::IntegratorKind::kExplicitLeapfrog, scene::IntegratorKind::kAutomatic}) {
    scene::SheetConfig config = dense_scene(GetParam(), 23, 23);
    config.integrator.kind = kind;
    EXPECT_TRUE(Sheet::create(config).ok());
  }
}

TEST_P(DenseSolver, RefusesACutBeyondTheLimitAndGoesOn) {
  Sheet sheet = make(dense_scene(GetParam(), 25, 20));
  EXPECT_EQ(reason(apply(sheet, scenes::line_cut({-0.1, 0.47}, {1.1, 0.53}))), "TOO_MANY_VERTICES");
  EXPECT_EQ(sheet.mesh().num_vertices(), 500);
}

// A sheet that swings, cut as it does. Where it is afterwards is another matter.
TEST_P(DenseSolver, GainsNoEnergyAndShowsItsResidual) {
  for (const scene::EigenvalueNorm norm : {scene::EigenvalueNorm::kPower, scene::EigenvalueNorm::kLog}) {
    scene::SheetConfig config = dense_scene(GetParam(), 6, 6);
    config.placement.y_axis = {0.0, 1.0, 0.0};
    config.integrator.covariance_root.norm = norm;
    Sheet tested = make(config);
    config.integrator.solver = scene::LinearSolverKind::kBlockJacobiCg;
    Sheet sound = make(config);
    EXPECT_NE(tested.integrator_description().find("solves a different system"), std::string::npos);
    const double energy = total_energy(tested);
    double worst = 0.0;
    for (int i = 0; i < 30; ++i) {
      if (i == 10) {
        ASSERT_TRUE(apply(tested, scenes::line_cut({0.3, -0.1}, {0.4, 0.6})).ok());
        ASSERT_TRUE(apply(sound, scenes::line_cut({0.3, -0.1}, {0.4, 0.6})).ok());
      }
      const TickReport report = tested.step({});
      EXPECT_EQ(report.stats.flags & fem::kFrozen, 0U);
      EXPECT_NE(report.stats.flags & fem::kNotConverged, 0U);
      worst = std::max(worst, report.stats.linear_residual);
      EXPECT_LT(sound.step({}).stats.linear_residual, 2.0 * config.integrator.solver_tolerance);
      ASSERT_TRUE(tested.state().x.allFinite());
      EXPECT_LT(total_energy(tested), energy + 1e-3) << "J, of 1 J that the sheet has to fall";
    }
    EXPECT_GT(worst, 0.1);
    EXPECT_LE(worst, fem::kWorstLinearResidual);
  }
}

INSTANTIATE_TEST_SUITE_P(All, DenseSolver,
                         testing::Values(scene::LinearSolverKind::kEsCgm, scene::LinearSolverKind::kAsCgm),
                         [](const testing::TestParamInfo<scene::LinearSolverKind>& tested) {
                           return tested.param == scene::LinearSolverKind::kEsCgm ? "EsCgm" : "AsCgm";
                         });

TEST(LinearResidual, IsThatOfTheSolverAsked) {
  const auto residual = [](scene::LinearSolverKind solver, int max_iterations) {
    scene::SheetConfig config = dense_scene(solver, 8, 8);
    config.placement.y_axis = {0.0, 1.0, 0.0};
    config.integrator.max_linear_iterations = max_iterations;
    Sheet sheet = make(config);
    run(sheet, 5);
    return sheet.step({}).stats.linear_residual;
  };
  EXPECT_LT(residual(scene::LinearSolverKind::kDirect, 1), 1e-10);
  EXPECT_GT(residual(scene::LinearSolverKind::kPlainCg, 1), 1e-2);
  EXPECT_LT(residual(scene::LinearSolverKind::kPlainCg, 10000), 2e-4);
}

}  // namespace
}  // namespace kerf::sheet
