// Integrators under abuse: every start there is, stiff and soft, short and long steps. Always finite; energy never
// above what it was; on bad input the state stays as it was, and the step says so.
#include <cmath>
#include <cstring>
#include <limits>

#include "tests/fem/integrator_cases.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

struct Start {
  std::string name;
  State state;
};

std::vector<Start> bad_starts(const mesh::TriangleMesh& mesh) {
  const State rest = rest_state(mesh);
  const Eigen::Index n = rest.x.cols();
  const linear::VertexField centred = rest.x.colwise() - Eigen::Vector3d(0.5, 0.5, 0.0);
  SeededRandom random(77);
  std::vector<Start> starts;
  const auto add = [&](std::string name, const linear::VertexField& x, const linear::VertexField& v) {
    starts.push_back({std::move(name), {x, v}});
  };
  const linear::VertexField still = Eigen::Matrix3Xd::Zero(3, n);
  add("random box", random_field(random, n, 1.0), still);
  add("point", still, still);
  add("line", Eigen::Vector3d(1.0, 0.0, 0.0).asDiagonal() * rest.x, still);
  add("stretched five times", 5.0 * rest.x, still);
  add("squashed", Eigen::Vector3d(1.0, 0.01, 1.0).asDiagonal() * rest.x, still);
  add("mirrored patch", Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal() * rest.x, still);
  linear::VertexField sheared = rest.x;
  sheared.row(0) += 10.0 * rest.x.row(1);
  add("sheared ten times", sheared, still);
  linear::VertexField folded = rest.x;
  folded.row(0) = (rest.x.row(0).array() - 0.5).abs().matrix();
  add("folded flat", folded, still);
  linear::VertexField inverted = rest.x;
  inverted.col(n / 2).head<2>() += Eigen::Vector2d(0.4, 0.3);
  add("inverted triangles", inverted, still);
  linear::VertexField spin(n);
  for (Eigen::Index i = 0; i < n; ++i) spin.col(i) = Eigen::Vector3d(0.0, 0.0, 1000.0).cross(centred.col(i));
  add("1000 rad/s", centred, spin);
  add("1000 m/s at random", rest.x, random_field(random, n, 1000.0));
  return starts;
}

class IntegratorStress : public IntegratorTest {};

TEST_P(IntegratorStress, StaysFiniteAndNeverGainsEnergyFromAnyStart) {
  const mesh::TriangleMesh mesh = jittered_square(6);
  Loads loads;
  loads.gravity.setZero();
  // Implicit Euler dissipates. Verlet swings by what its step resolves of a collapse; the trapezoidal stage of TR-BDF2
  // may overshoot once where the stiffness falls as the sheet moves.
  const double allowed_gain = is(IntegratorKind::kImplicitEuler) ? 1e-4 : is(IntegratorKind::kExplicit) ? 1e-2 : 0.1;
  const int num_steps = test::num_trials({.few = 3, .usual = 10, .many = 10});
  int num_runs = 0;
  for (const double youngs_modulus : {1.0e3, 1.0e6, 1.0e9}) {
    const Model model(mesh, isotropic(youngs_modulus, 0.3, 1e-3, 300.0));
    const std::unique_ptr<Integrator> integrator = make(model);
    // J: strains of floats come in steps of 2^-23; so does the work done on vertices as they move. Sheet of 1 m^2, 1
    // mm.
    const bool is_mixed = GetParam().options.precision == Precision::kMixed;
    const double strain_step = is_mixed ? 4.0 * 0x1p-23 : 0.0;
    const double noise = youngs_modulus * 1e-3 * strain_step * strain_step;
    for (const double dt : {1e-4, 1.0 / 60.0, 0.1}) {
      const bool affordable = !is(IntegratorKind::kExplicit) || youngs_modulus * dt <= 1e7;
      if (!affordable) continue;
      for (const Start& start : bad_starts(mesh)) {
        State state = start.state;
        const double before = internal_energy(model, state);
        double highest = before;
        for (int i = 0; i < num_steps; ++i) {
          integrator->step(model, loads, dt, nullptr, state);
          ASSERT_TRUE(is_finite(state)) << start.name << " E " << youngs_modulus << " dt " << dt << " step " << i;
          highest = std::max(highest, internal_energy(model, state));
        }
        EXPECT_LE(highest, before * (1.0 + allowed_gain) + 1e-12 + noise)
            << start.name << " E " << youngs_modulus << " dt " << dt;
        ++num_runs;
      }
    }
  }
  EXPECT_GE(num_runs, 77);
}

TEST_P(IntegratorStress, OneTriangleAndOnePinnedAndAllPinned) {
  mesh::IndexedMesh one;
  one.rest = Eigen::Matrix2Xd{
      {0.0, 1.0, 0.0},
      {0.0, 0.0, 1.0},
  };
  one.triangles = Eigen::Vector3i(0, 1, 2);
  const mesh::TriangleMesh mesh = mesh::import_mesh(one).value();
  const Model model(mesh, isotropic(1e5, 0.3, 1e-3, 300.0));
  const std::unique_ptr<Integrator> integrator = make(model);
  const State rest = rest_state(mesh);
  Loads loads;
  for (int num_pins = 0; num_pins <= 3; ++num_pins) {
    State state = rest;
    for (int i = 0; i < 100; ++i) {
      integrator->step(model, loads, 1.0 / 60.0, nullptr, state);
      ASSERT_TRUE(is_finite(state));
    }
    if (num_pins == 3) {
      EXPECT_EQ(state.x, rest.x);
      break;
    }
    loads.pins.push_back({num_pins, rest.x.col(num_pins), Eigen::Vector3d::Zero()});
  }
}

TEST_P(IntegratorStress, LeavesANotFiniteStateAsItWasAndSaysSo) {
  const mesh::TriangleMesh mesh = square_grid(4);
  const Model model(mesh, isotropic(1e5, 0.3, 1e-3, 300.0));
  const std::unique_ptr<Integrator> integrator = make(model);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300}) {
    State state = rest_state(mesh);
    state.x(1, 5) = bad;
    const State before = state;
    const StepStats stats = integrator->step(model, Loads{}, 1.0 / 60.0, nullptr, state);
    EXPECT_NE(stats.flags & kFrozen, 0U) << bad;
    EXPECT_EQ(stats.simulated, 0.0);
    EXPECT_EQ(std::memcmp(state.x.data(), before.x.data(), sizeof(double) * static_cast<std::size_t>(state.x.size())),
              0);
    EXPECT_EQ(std::memcmp(state.v.data(), before.v.data(), sizeof(double) * static_cast<std::size_t>(state.v.size())),
              0);
  }
  // Continues with a good one as if nothing had happened.
  State state = rest_state(mesh);
  State fresh_state = state;
  integrator->step(model, Loads{}, 1.0 / 60.0, nullptr, state);
  make(model)->step(model, Loads{}, 1.0 / 60.0, nullptr, fresh_state);
  EXPECT_TRUE(equal_bits(state, fresh_state));
}

TEST_P(IntegratorStress, AHangingClothStaysBoundedThroughItsWildestSwing) {
  constexpr int kSide = 11;
  const mesh::TriangleMesh mesh = square_grid(kSide);
  const Model model(mesh, find_preset("demo").value());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads;
  for (const int v : {kSide * (kSide - 1), kSide * kSide - 1}) {
    loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
  const double start = model.energies(state, loads.gravity).total();
  for (int i = 0; i < 120; ++i) {
    const StepStats stats = integrator->step(model, loads, 1.0 / 60.0, nullptr, state);
    ASSERT_EQ(stats.flags & kFrozen, 0U);
    ASSERT_LE(model.energies(state, loads.gravity).total(), start + 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(All, IntegratorStress, testing::ValuesIn(all_integrators()), case_name);

}  // namespace
}  // namespace kerf::fem
