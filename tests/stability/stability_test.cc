// Runs a share of the stability matrix, of which the program stability_matrix runs all, and some very long runs.
#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/stability/case.h"
#include "tests/support/trials.h"

namespace kerf::stability {
namespace {

constexpr int kTestedPerStart = 6;  // 126 cases

// share(): cases of each start. num_steps(): steps of each case, of which stability_matrix makes 600.
std::size_t share() {
  return static_cast<std::size_t>(test::num_trials({.few = 1, .usual = kTestedPerStart, .many = 2 * kTestedPerStart}));
}
int num_steps() {
  return test::num_trials({.few = 2, .usual = 150, .many = 150});
}

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
  const Outcome outcome = run(GetParam(), num_steps(), kMatrixBudget);
  EXPECT_TRUE(outcome.finite);
  const fem::ConditionClass rating = fem::rate_condition(outcome.condition);
  if (rating == fem::ConditionClass::kBounded) {
    EXPECT_LE(outcome.gain, 1.0) << outcome.integrator;
  }
  if (rating != fem::ConditionClass::kAccurate) return;
  // Verlet's energy oscillates about a constant, within the accuracy of its steps.
  EXPECT_LE(outcome.gain, outcome.is_explicit ? 1e-2 : 1e-4) << outcome.integrator;
  EXPECT_LE(outcome.drift, 1e-6) << outcome.integrator;
}

INSTANTIATE_TEST_SUITE_P(Share, StabilityMatrixCase, testing::ValuesIn(matrix(share())));

// Returns the cases in double precision, as users may request.
std::vector<Case> in_double(std::vector<Case> cases) {
  for (Case& each : cases) each.precision = fem::Precision::kDouble;
  return cases;
}
INSTANTIATE_TEST_SUITE_P(ShareInDouble, StabilityMatrixCase,
                         testing::ValuesIn(in_double(matrix(std::min<std::size_t>(share(), 2)))));

// Cases beyond the share that once gained energy without end, or lost momentum:
// - bending kicks in resonance with a taut strip,
// - gains let pass in each of many steps,
// - bending energy of slivers that rounding made negative,
// - energy taken from the motion of the centre,
// - noise that the inertia of clusters held and gave back.
Case find_case(const std::string& name) {
  for (const Case& each : matrix()) {
    if (each.name() == name) return each;
  }
  throw std::invalid_argument("no case " + name);
}
INSTANTIATE_TEST_SUITE_P(
    Mended, StabilityMatrixCase,
    testing::Values(find_case("1000 rad/s, E 1e+09 Pa, nu 0.30, dt 0.0001 s, aspect 1e+02"),
                    find_case("pinned at one, E 1e+00 Pa, nu 0.49, dt 1 s, aspect 1e+00"),
                    find_case("random box, E 1e+03 Pa, nu 0.63, dt 0.001 s, aspect 9e+05"),
                    find_case("1000 m/s at random, E 1e+09 Pa, nu 0.49, dt 0.1 s, aspect 1e+02"),
                    find_case("density jump of 1e7, E 1e+00 Pa, nu 0.63, dt 0.0001 s, aspect 1e+04")));

// Sheets spin at 1000 rad/s about the normal for 10,000 steps. The integrators are the default, explicit here, and both
// implicit ones with five Newton steps. With only two, and conjugate gradients to 1e-4, TR-BDF2 leaves the centre 4e-9
// off its place.
TEST(StabilityOfSpin, NeverGainsEnergyNorLeavesItsPlace) {
  struct Spin {
    fem::IntegratorKind kind;
    double youngs_modulus, dt;  // Pa, s
    int newton_iterations = 0;  // 0: as for a new sheet
  };
  constexpr double kTick = 1.0 / 60.0;
  const int num_spin_steps = test::num_trials({.few = 100, .usual = 2'000, .many = 10'000});
  for (const Spin& each :
       {Spin{fem::IntegratorKind::kAutomatic, 1e6, 1e-4}, Spin{fem::IntegratorKind::kAutomatic, 1e6, kTick},
        Spin{fem::IntegratorKind::kAutomatic, 1e9, kTick}, Spin{fem::IntegratorKind::kTrBdf2, 1e6, kTick, 5},
        Spin{fem::IntegratorKind::kImplicitEuler, 1e6, kTick, 5}}) {
    Case spin;
    while (std::string_view(start_kinds()[spin.start].name) != "1000 rad/s") ++spin.start;
    spin.kind = each.kind;
    spin.youngs_modulus = each.youngs_modulus;
    spin.dt = each.dt;
    spin.newton_iterations = each.newton_iterations;
    const Outcome outcome = run(spin, num_spin_steps, {});
    SCOPED_TRACE(spin.name() + ": " + outcome.integrator);
    ASSERT_EQ(outcome.num_steps, num_spin_steps);
    EXPECT_TRUE(outcome.finite);
    EXPECT_NEAR(outcome.simulated, num_spin_steps * each.dt, 1e-6 * outcome.simulated) << "frozen, or cut short";
    EXPECT_LE(outcome.gain, 1e-4);
    EXPECT_LE(outcome.drift, 1e-9);
  }
}

}  // namespace
}  // namespace kerf::stability
