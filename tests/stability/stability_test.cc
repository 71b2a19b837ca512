// A share of the stability matrix (stability_matrix runs all of it), and values that are none in every input.
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/mesh/grid_mesh.h"
#include "tests/stability/stability_case.h"
#include "tests/support/meshes.h"

namespace kerf::stability {
namespace {

constexpr std::size_t kTestedPerStart = 6;  // 102 cases
#if defined(__SANITIZE_ADDRESS__)
constexpr int kSteps = 10;
constexpr int kSpinSteps = 100;
#else
constexpr int kSteps = 150;  // stability_matrix takes 600
constexpr int kSpinSteps = 10'000;
#endif

TEST(StabilityMatrix, CoversEveryStartStiffnessStepAndAspectRatio) {
  const std::vector<Case> cases = matrix();
  EXPECT_GE(cases.size(), 800U);
  EXPECT_GE(matrix(kTestedPerStart).size(), 100U);
  for (std::size_t i = 1; i < cases.size(); ++i) {
    for (std::size_t j = i; j-- > 0 && cases[j].start == cases[i].start;) {
      EXPECT_NE(cases[i].name(), cases[j].name());
    }
  }
}

class StabilityMatrixCase : public testing::TestWithParam<Case> {};

TEST_P(StabilityMatrixCase, StaysFiniteAndKeepsItsEnergy) {
  const Outcome outcome = run(GetParam(), kSteps);
  EXPECT_TRUE(outcome.finite);
  const fem::ConditionClass rating = fem::rate_condition(outcome.condition);
  if (rating == fem::ConditionClass::kBounded) {
    EXPECT_LE(outcome.gain, 1.0) << outcome.integrator;
  }
  if (rating != fem::ConditionClass::kAccurate) return;
  // Verlet swings about the energy that it keeps by what its steps resolve.
  EXPECT_LE(outcome.gain, outcome.is_explicit ? 1e-2 : 1e-4) << outcome.integrator;
  EXPECT_LE(outcome.drift, 1e-6) << outcome.integrator;
}

INSTANTIATE_TEST_SUITE_P(Share, StabilityMatrixCase, testing::ValuesIn(matrix(kTestedPerStart)));

// Where users ask for double precision.
std::vector<Case> in_double(std::vector<Case> cases) {
  for (Case& each : cases) each.precision = fem::Precision::kDouble;
  return cases;
}
INSTANTIATE_TEST_SUITE_P(ShareInDouble, StabilityMatrixCase, testing::ValuesIn(in_double(matrix(2))));

// Cases beyond the share that once gained energy without end, or lost momentum: bending kicks in resonance with a taut
// strip, gains let pass in each of many steps, bending energy of slivers that rounding made negative, energy taken from
// the motion of the centre.
Case find_case(const std::string& name) {
  for (const Case& each : matrix()) {
    if (each.name() == name) return each;
  }
  throw std::invalid_argument("no case " + name);
}
INSTANTIATE_TEST_SUITE_P(Mended, StabilityMatrixCase,
                         testing::Values(find_case("1000 rad/s, E 1e+09 Pa, nu 0.30, dt 0.0001 s, aspect 1e+02"),
                                         find_case("pinned at one, E 1e+00 Pa, nu 0.49, dt 1 s, aspect 1e+00"),
                                         find_case("random box, E 1e+03 Pa, nu 0.63, dt 0.001 s, aspect 9e+05"),
                                         find_case("1000 m/s at random, E 1e+09 Pa, nu 0.49, dt 0.1 s, aspect 1e+02")));

// Not a number, infinite, huge or denormal: a step either refuses the state and leaves it, bit for bit, or ends finite.
TEST(StabilityOfInput, OneBadValueAtAnyOfAThousandPlaces) {
  const mesh::TriangleMesh mesh = test::grid(5);
  const fem::Model model(mesh, fem::isotropic(1e6, 0.3, 1e-3, 300.0));
  SeededRandom random(41);
  constexpr std::array<double, 6> kBad{std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity(),
                                       1e300,
                                       -1e300,
                                       std::numeric_limits<double>::denorm_min()};
  int num_refused = 0;
  const auto pick = [&](double n) { return static_cast<Eigen::Index>(random.uniform(0.0, n)); };
  for (const fem::IntegratorKind kind : {fem::IntegratorKind::kExplicit, fem::IntegratorKind::kImplicitEuler,
                                         fem::IntegratorKind::kTrBdf2, fem::IntegratorKind::kAutomatic}) {
    fem::IntegratorOptions options;
    options.kind = kind;
    const std::unique_ptr<fem::Integrator> integrator = fem::make_integrator(options);
    integrator->rebuild(model);
    for (int trial = 0; trial < 250; ++trial) {
      fem::State state;
      state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
      state.v = state.x;
      for (int v = 0; v < mesh.num_vertices(); ++v) state.x.col(v).head<2>() = mesh.rest_position(v);
      fem::Loads loads;
      loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
      loads.pins.push_back({0, state.x.col(0), Eigen::Vector3d::Zero()});
      const double bad = kBad[static_cast<std::size_t>(pick(static_cast<double>(kBad.size())))];
      const Eigen::Index column = pick(mesh.num_vertices());
      const Eigen::Index row = pick(3.0);
      const Eigen::Index place = pick(6.0);
      if (place == 0) state.x(row, column) = bad;
      if (place == 1) state.v(row, column) = bad;
      if (place == 2) loads.external_forces(row, column) = bad;
      if (place == 3) loads.gravity[row] = bad;
      if (place == 4) loads.pins[0].target[row] = bad;
      if (place == 5) loads.pins[0].velocity[row] = bad;
      const fem::State before = state;
      const fem::StepStats stats = integrator->step(model, loads, 1.0 / 60.0, nullptr, state);
      if ((stats.flags & fem::kFrozen) != 0U) {
        ++num_refused;
        const std::size_t size = sizeof(double) * static_cast<std::size_t>(state.x.size());
        EXPECT_EQ(std::memcmp(state.x.data(), before.x.data(), size), 0) << trial;
        EXPECT_EQ(std::memcmp(state.v.data(), before.v.data(), size), 0) << trial;
      } else {
        EXPECT_TRUE(fem::is_finite(state)) << "trial " << trial << ", place " << place << ", value " << bad;
      }
    }
  }
  EXPECT_GT(num_refused, 400);
}

// 1000 rad/s about the normal for 10,000 steps.
TEST(StabilityOfSpin, NeverGainsEnergyNorLeavesItsPlace) {
  for (const double dt : {1e-4, 1.0 / 60.0}) {
    Case spin;
    for (std::size_t i = 0; i < start_kinds().size(); ++i) {
      if (std::string(start_kinds()[i].name) == "1000 rad/s") spin.start = i;
    }
    spin.dt = dt;
    const Outcome outcome = run(spin, kSpinSteps);
    EXPECT_TRUE(outcome.finite);
    EXPECT_LE(outcome.gain, 1e-4) << outcome.integrator;
    EXPECT_LE(outcome.drift, 1e-9) << outcome.integrator;
  }
}

}  // namespace
}  // namespace kerf::stability
