// Tests the promises of the search for an equilibrium. Comparisons with references: tests/accuracy.
#include <cmath>

#include "server/core/fem/statics/equilibrium.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

// A strip of 0.3 m x 0.05 m along x, clamped at x = 0.
struct Cantilever {
  explicit Cantilever(int num_x)
      : mesh(mesh::make_grid({.num_x = num_x + 1, .num_y = 4, .width = 0.3, .height = 0.05}).value()),
        model(mesh, isotropic(5.0e8, 0.0, 5.0e-4, 1300.0)),
        x(rest_state(mesh).x) {
    std::vector<Clamp> clamps;
    for (int j = 0; j < 4; ++j) {
      const int v = j * (num_x + 1);
      loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
      clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
  }
  [[nodiscard]] double energy() const { return model.energies({x, 0.0 * x}, loads.gravity).total(); }

  mesh::TriangleMesh mesh;
  Model model;
  linear::VertexField x;
  Loads loads;
};

TEST(Equilibrium, OfASheetThatHardlyStretchesTakesFewStepsAndItsEnergyNeverRises) {
  for (const int num_x : {10, 40, 80}) {
    Cantilever strip(num_x);
    strip.loads.gravity *= 2.0;
    EquilibriumSolver solver({});
    solver.rebuild(strip.model);
    double last = strip.energy();
    const double first = last;
    const auto watch = [&](const EquilibriumStats& stats) {
      const double now = strip.energy();
      EXPECT_LE(now, last + 1e-12 * std::abs(first - last) + 1e-13) << stats.iterations;
      last = now;
      return true;
    };
    const EquilibriumStats stats = solver.solve(strip.model, strip.loads, watch, strip.x);
    EXPECT_TRUE(stats.converged) << stats.residual;
    EXPECT_LE(stats.iterations, 10) << num_x;
    EXPECT_EQ(stats.shift, 0.0);
    EXPECT_LT(strip.x.row(2).minCoeff(), -0.2);
  }
}

TEST(Equilibrium, SaysWhetherItIsStable) {
  // Stands on its clamp, too tall for its weight: 7.84 EI / L^3 is the heaviest it could bear (Greenhill 1881).
  for (const double share : {0.9, 1.1}) {
    Cantilever strip(20);
    const double per_length = 7.837 * (5.0e8 * 1.25e-10 / 12.0) / 0.027;
    strip.loads.gravity = {-share * per_length / (1300.0 * 5.0e-4), 0.0, 0.0};
    EquilibriumSolver solver({});
    solver.rebuild(strip.model);
    const EquilibriumStats stats = solver.solve(strip.model, strip.loads, nullptr, strip.x);
    EXPECT_TRUE(stats.converged);
    EXPECT_LT(strip.x.row(2).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_EQ(stats.shift == 0.0, share < 1.0) << stats.shift;
  }
}

TEST(Equilibrium, LeavesAnUnstableOneDownhill) {
  Cantilever strip(20);
  const double per_length = 7.837 * (5.0e8 * 1.25e-10 / 12.0) / 0.027;
  strip.loads.gravity = {-1.2 * per_length / (1300.0 * 5.0e-4), 0.0, 0.0};
  for (Eigen::Index v = 0; v < strip.x.cols(); ++v) strip.x(2, v) += 1e-3 * strip.x(0, v) * strip.x(0, v);
  EquilibriumSolver solver({});
  solver.rebuild(strip.model);
  const EquilibriumStats stats = solver.solve(strip.model, strip.loads, nullptr, strip.x);
  EXPECT_TRUE(stats.converged) << stats.residual;
  EXPECT_EQ(stats.shift, 0.0);
  EXPECT_GT(strip.x.row(2).maxCoeff(), 0.1);
}

TEST(Equilibrium, MovesUnderALoadThatRoundingOfTheForcesHides) {
  constexpr double kForce = 1e-9;  // N; rounding leaves some 3e-9
  Cantilever strip(20);
  strip.loads.gravity.setZero();
  strip.loads.external_forces = linear::VertexField::Zero(3, strip.x.cols());
  for (const int j : {0, 1, 2, 3})
    strip.loads.external_forces(0, 21 * j + 20) = kForce / (j == 0 || j == 3 ? 6.0 : 3.0);
  const linear::VertexField start = strip.x;
  EquilibriumSolver solver({});
  solver.rebuild(strip.model);
  const EquilibriumStats stats = solver.solve(strip.model, strip.loads, {}, strip.x);
  EXPECT_TRUE(stats.converged) << stats.residual;
  EXPECT_LE(stats.iterations, 2);
  const double expected = kForce * 0.3 / (5.0e8 * 5.0e-4 * 0.05);
  for (const int j : {0, 1, 2, 3})
    EXPECT_NEAR(strip.x(0, 21 * j + 20) - start(0, 21 * j + 20), expected, 0.02 * expected);
}

TEST(Equilibrium, StopsWhereItIsToldTo) {
  Cantilever strip(20);
  EquilibriumSolver solver({});
  solver.rebuild(strip.model);
  int calls = 0;
  const auto stop = [&](const EquilibriumStats& /*stats*/) { return ++calls < 2; };
  EXPECT_FALSE(solver.solve(strip.model, strip.loads, stop, strip.x).converged);
  EXPECT_EQ(calls, 2);
  Cantilever other(20);
  EquilibriumSolver limited({.tolerance = 1e-9, .max_iterations = 3});
  limited.rebuild(other.model);
  const EquilibriumStats stats = limited.solve(other.model, other.loads, nullptr, other.x);
  EXPECT_FALSE(stats.converged);
  EXPECT_EQ(stats.iterations, 3);
}

TEST(Equilibrium, RepeatsBitForBit) {
  Cantilever one(20);
  Cantilever two(20);
  EquilibriumSolver solver({});
  solver.rebuild(one.model);
  solver.solve(one.model, one.loads, nullptr, one.x);
  solver.rebuild(two.model);
  solver.solve(two.model, two.loads, nullptr, two.x);
  EXPECT_EQ(one.x, two.x);
}

}  // namespace
}  // namespace kerf::fem
