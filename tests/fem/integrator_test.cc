// The contract of every integrator: motion, loads and reports. Contact: integrator_contact_test.cc. What happens
// under abuse: stress_test.cc.
#include <algorithm>
#include <cmath>

#include "server/core/fem/statics/equilibrium.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/matrix_near.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

class IntegratorContract : public IntegratorTest {};

TEST_P(IntegratorContract, FreeFallIsTheExactParabolaOfTheScheme) {
  const mesh::TriangleMesh mesh = jittered_square(7);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  const State start = [&] {
    State state = rest_state(mesh);
    state.v.colwise() = Eigen::Vector3d(1.0, 0.5, 2.0);
    return state;
  }();
  State state = start;
  const Loads loads;
  constexpr int kTicks = 30;
  int substeps = 0;
  for (int i = 0; i < kTicks; ++i) {
    const StepStats stats = integrator->step(model, loads, kTick, nullptr, state);
    substeps += stats.substeps + 1;
    EXPECT_EQ(stats.flags & ~kSubstepLimit, 0U);
    EXPECT_NEAR(stats.simulated, kTick, 1e-15);
  }
  const double t = kTicks * kTick;
  // Implicit Euler: z = v t - g t (t + dt) / 2. The others are of second order: exact.
  const double late = is(IntegratorKind::kImplicitEuler) ? kTick : 0.0;
  const Eigen::Vector3d expected = Eigen::Vector3d(1.0, 0.5, 2.0) * t + 0.5 * t * (t + late) * loads.gravity;
  const linear::VertexField moved = state.x - start.x;
  const double lost = rounding(substeps, 5.0);
  EXPECT_THAT(moved, test::MatrixNear(expected.replicate(1, moved.cols()), 1e-11 + t * lost));
  const Eigen::Vector3d velocity = start.v.col(0) + t * loads.gravity;
  EXPECT_THAT(state.v, test::MatrixNear(velocity.replicate(1, state.v.cols()), 1e-10 + lost));
}

TEST_P(IntegratorContract, ConservesMomentumOfAStrainedTumblingSheet) {
  const mesh::TriangleMesh mesh = jittered_square(8);
  // Bending without damping, and damping without bending: damped bending brakes the rotation of a bent sheet.
  Material bending = orthotropic_cloth();
  Material damped = orthotropic_cloth();
  damped.bending_scale = 0.0;
  damped.stiffness_damping = 1e-4;
  for (const Material& material : {bending, damped}) {
    const Model model(mesh, material);
    const std::unique_ptr<Integrator> integrator = make(model);
    State state = rest_state(mesh);
    SeededRandom random(21);
    state.x += random_field(random, state.x.cols(), 0.01);
    const Eigen::Vector3d omega(3.0, -2.0, 5.0);
    for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
      state.v.col(i) = omega.cross(state.x.col(i)) + Eigen::Vector3d(0.3, 0.2, 0.1);
    }
    const Momentum before = model.momentum(state);
    const Loads loads = no_loads();
    int substeps = 0;
    for (int i = 0; i < 60; ++i) substeps += integrator->step(model, loads, 1e-3, nullptr, state).substeps + 1;
    const Momentum after = model.momentum(state);
    const double lost = rounding(substeps, state.v.colwise().norm().maxCoeff()) * model.masses().total();
    EXPECT_LT((after.linear - before.linear).norm(), 1e-12 * before.linear.norm() + lost);
    // Verlet keeps angular momentum exactly; implicit Euler loses some, a second-order scheme little.
    const double allowed = is(IntegratorKind::kExplicit) ? 1e-12 : is(IntegratorKind::kTrBdf2) ? 2e-3 : 5e-2;
    const double reach = state.x.colwise().norm().maxCoeff();
    EXPECT_LT((after.angular - before.angular).norm(), allowed * before.angular.norm() + lost * reach);
  }
}

TEST_P(IntegratorContract, PinsAreWhereTheyShouldBeAtTheEndOfEveryStep) {
  const mesh::TriangleMesh mesh = square_grid(7);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = hang_by_corners(7, state);
  const Eigen::Vector3d velocity(0.2, 0.0, 0.4);
  loads.pins[1].velocity = velocity;
  for (int i = 0; i < 20; ++i) {
    loads.pins[1].target += kTick * velocity;
    integrator->step(model, loads, kTick, nullptr, state);
    for (const Pin& pin : loads.pins) {
      EXPECT_LT((state.x.col(pin.vertex) - pin.target).norm(), 1e-14);
      EXPECT_EQ(Eigen::Vector3d(state.v.col(pin.vertex)), pin.velocity);
    }
  }
  EXPECT_LT(state.x(2, 3), -0.01);  // the free rest has fallen
}

TEST_P(IntegratorContract, HangsAtRestWhereForcesBalance) {
  if (is(IntegratorKind::kTrapezoidal)) GTEST_SKIP() << "damps nothing";
  const mesh::TriangleMesh mesh = square_grid(9);
  Material material = soft_cloth();
  material.mass_damping = 8.0;
  const Model model(mesh, material);
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  // Hanging straight down from its upper edge.
  state.x.row(2) = state.x.row(1).eval();
  state.x.row(1).setZero();
  Loads loads;
  for (int i = 72; i < 81; ++i) loads.pins.push_back({i, state.x.col(i), Eigen::Vector3d::Zero()});
  for (int i = 0; i < 240; ++i) integrator->step(model, loads, kTick, nullptr, state);
  EXPECT_LT(state.v.cwiseAbs().maxCoeff(), 1e-4);
  linear::VertexField f(state.x.cols());
  model.internal_forces(state.x, f);
  for (int i = 0; i < 72; ++i) {
    EXPECT_LT((f.col(i) + model.mass()[static_cast<std::size_t>(i)] * loads.gravity).norm(),
              4e-3 * model.mass()[40] * 9.81);
  }
  // Stretch of the centre line under its own weight, in one dimension: rho g L^2 / (2 E).
  const double sag = 400.0 * 9.81 / (2.0 * 4.0e5);
  EXPECT_NEAR(0.0 - state.x(2, 4), sag, 0.15 * sag);
}

TEST_P(IntegratorContract, MassDampingSlowsASheetExponentially) {
  const mesh::TriangleMesh mesh = square_grid(4);
  Material material = soft_cloth();
  material.mass_damping = 2.0;
  const Model model(mesh, material);
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  state.v.row(0).setConstant(3.0);
  for (int i = 0; i < 100; ++i) integrator->step(model, no_loads(), 5e-3, nullptr, state);
  const double tolerance = is(IntegratorKind::kImplicitEuler) ? 0.03 : 1e-4;
  EXPECT_NEAR(state.v(0, 5), 3.0 * std::exp(-1.0), tolerance);
}

TEST_P(IntegratorContract, TerminalVelocityBalancesDragAndWeight) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads;
  loads.wind.air_density = 1.2;
  loads.wind.normal_drag = 1.0;
  for (int i = 0; i < 300; ++i) integrator->step(model, loads, kTick, nullptr, state);
  const double terminal = std::sqrt(0.2 * 9.81 / (0.5 * 1.2));  // 0.2 kg/m^2
  EXPECT_NEAR(-state.v.row(2).mean(), terminal, 0.01 * terminal);
}

TEST_P(IntegratorContract, EvenAGaleNeverBlowsTheSheetFasterThanTheAir) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = no_loads();
  loads.wind.air_density = 100.0;
  loads.wind.velocity = Eigen::Vector3d(0.0, 0.0, 300.0);
  for (int i = 0; i < 60; ++i) {
    const double before = state.v.row(2).mean();
    integrator->step(model, loads, kTick, nullptr, state);
    ASSERT_TRUE(is_finite(state));
    const double now = state.v.row(2).mean();
    // BDF2 looks ahead by a third of the last change, which in the first step is great; from then on it only falls.
    const bool looks_ahead = is(IntegratorKind::kBdf2);
    ASSERT_LT(now, looks_ahead && i == 0 ? 300.0 * (1.0 + 1e-4) : std::max(before, 300.0 * (1.0 + 1e-6)));
  }
  EXPECT_GT(state.v.row(2).mean(), 250.0);
}

TEST_P(IntegratorContract, ExternalForcesAccelerateTheWholeSheet) {
  const mesh::TriangleMesh mesh = square_grid(4);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = no_loads();
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  loads.external_forces.col(3) = Eigen::Vector3d(0.0, 0.01, 0.02);
  int substeps = 0;
  for (int i = 0; i < 10; ++i) substeps += integrator->step(model, loads, 1e-3, nullptr, state).substeps + 1;
  const double lost = rounding(substeps, state.v.colwise().norm().maxCoeff()) * model.masses().total();
  EXPECT_LT((model.momentum(state).linear - 0.01 * Eigen::Vector3d(0.0, 0.01, 0.02)).norm(), 1e-12 + lost);
}

TEST_P(IntegratorContract, PressureAcceleratesAFreeSheetAsAWhole) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  SeededRandom random(3);
  const Eigen::Matrix3d turn = random_rotation(random);
  State state = rest_state(mesh);
  state.x = turn * state.x;
  Loads loads = no_loads();
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 3.0);
  int substeps = 0;
  for (int i = 0; i < 10; ++i) substeps += integrator->step(model, loads, 1e-2, nullptr, state).substeps + 1;
  // 3 Pa on 0.2 kg/m^2 for 0.1 s.
  const Eigen::Vector3d expected = turn * Eigen::Vector3d(0.0, 0.0, 1.5);
  EXPECT_LT((model.momentum(state).linear / model.masses().total() - expected).norm(), 1e-6);
  const double tolerance = is(IntegratorKind::kExplicit) ? 1e-9 : 5e-4;  // of Newton's method
  EXPECT_THAT(state.v, test::MatrixNear(expected.replicate(1, state.v.cols()), tolerance + rounding(substeps, 1.5)));
}

TEST_P(IntegratorContract, MomentsTurnAFreeSheetWithoutPushingIt) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, isotropic(4.0e7, 0.3, 5.0e-3, 40.0));
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = no_loads();
  const double moment = 1e-3;  // N m/m
  for (const EdgeMoment& each : border_moments(model, mesh, moment)) {
    const Eigen::Vector2d middle = 0.5 * (mesh.rest_position(each.vertex[(each.edge + 1) % 3]) +
                                          mesh.rest_position(each.vertex[(each.edge + 2) % 3]));
    if (middle.x() > 1.0 - 1e-9) loads.edge_moments.push_back(each);
  }
  ASSERT_EQ(loads.edge_moments.size(), 4U);
  int substeps = 0;
  for (int i = 0; i < 20; ++i) substeps += integrator->step(model, loads, 1e-3, nullptr, state).substeps + 1;
  const Momentum momentum = model.momentum(state);
  const double lost = rounding(substeps, state.v.colwise().norm().maxCoeff()) * model.masses().total();
  EXPECT_LT(momentum.linear.norm(), 1e-12 + lost);
  // The edge of 1 m runs along y; its outside rises, against the turn about y. Linear momentum is 0: any origin will
  // do.
  const double reach = state.x.colwise().norm().maxCoeff();
  EXPECT_LT((momentum.angular - Eigen::Vector3d(0.0, -moment * 0.02, 0.0)).norm(), 1e-3 * moment * 0.02 + lost * reach);
}

TEST_P(IntegratorContract, AnInflatedSheetComesToRestInItsEquilibrium) {
  if (is(IntegratorKind::kTrapezoidal)) GTEST_SKIP() << "damps nothing";
  const mesh::TriangleMesh mesh = square_grid(9);
  Material material = soft_cloth();
  material.mass_damping = 8.0;
  const Model model(mesh, material);
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = no_loads();
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 10.0);
  // Two sides are free: there the tangent is not symmetric.
  for (int i = 0; i < 9; ++i) {
    for (const int v : {9 * i, 9 * i + 8}) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  }
  std::uint32_t flags = 0;
  for (int i = 0; i < 240; ++i) flags |= integrator->step(model, loads, kTick, nullptr, state).flags;
  EXPECT_EQ(flags & (kFrozen | kRepaired), 0U);
  EquilibriumSolver solver({});
  solver.rebuild(model);
  linear::VertexField x = state.x;
  EXPECT_TRUE(solver.solve(model, loads, nullptr, x).converged);
  EXPECT_GT(x(2, 40), 0.1);
  EXPECT_THAT(state.x, test::MatrixNear(x, 1e-5));
}

TEST_P(IntegratorContract, AGrabOfAnyStiffnessPullsItsPointToTheTarget) {
  if (is(IntegratorKind::kTrapezoidal)) GTEST_SKIP() << "damps nothing";
  const mesh::TriangleMesh mesh = square_grid(7);
  // Sanitizers make this some twenty times as slow: there it comes to rest in fewer steps.
  const int num_steps = test::num_trials({.few = 100, .usual = 300, .many = 300});
  Material material = soft_cloth();
  material.mass_damping = 1500.0 / num_steps;
  const Model model(mesh, material);
  const std::unique_ptr<Integrator> integrator = make(model);
  for (const double stiffness : {10.0, 1e3, 1e6, 1e12}) {
    State state = rest_state(mesh);
    Loads loads = no_loads();
    Grab grab;
    const std::array<mesh::VertexId, 3> corners = mesh.vertices(30);
    grab.vertices = corners;
    grab.weights = Eigen::Vector3d(0.5, 0.25, 0.25);
    grab.target = Eigen::Vector3d(0.5, 0.5, 0.3);
    grab.stiffness = stiffness;
    grab.damping = 0.5;
    loads.grabs.push_back(grab);
    for (int i = 0; i < num_steps; ++i) {
      integrator->step(model, loads, kTick, nullptr, state);
      ASSERT_TRUE(is_finite(state)) << stiffness;
    }
    const Eigen::Vector3d point =
        0.5 * state.x.col(corners[0]) + 0.25 * state.x.col(corners[1]) + 0.25 * state.x.col(corners[2]);
    EXPECT_LT((point - grab.target).norm(), 2e-3) << stiffness;
  }
}

TEST_P(IntegratorContract, RepeatsBitForBitWhateverWasSteppedBefore) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Model model(mesh, orthotropic_cloth());
  const std::unique_ptr<Integrator> used = make(model);
  State state = rest_state(mesh);
  Loads loads = hang_by_corners(9, state);
  loads.wind.air_density = 1.2;
  for (int i = 0; i < 5; ++i) used->step(model, loads, kTick, nullptr, state);
  State other = state;
  used->step(model, loads, kTick, nullptr, state);
  const std::unique_ptr<Integrator> fresh = make(model);
  fresh->step(model, loads, kTick, nullptr, other);
  EXPECT_TRUE(equal_bits(state, other));
}

TEST_P(IntegratorContract, NeverAllocatesInAStep) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const mesh::TriangleMesh mesh = square_grid(10);
  const Model model(mesh, orthotropic_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  Loads loads = hang_by_corners(10, state);
  loads.wind.air_density = 1.2;
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 2.0);
  loads.edge_moments = border_moments(model, mesh, 1e-3);
  loads.grabs.push_back({{5, mesh::kNone, mesh::kNone}, {1.0, 0.0, 0.0}, {0.5, 0.0, 0.2}, {0.0, 0.0, 0.0}, 50.0, 0.1});
  const std::size_t before = test::num_allocations();
  std::uint32_t flags = 0;
  for (int i = 0; i < 10; ++i) flags |= integrator->step(model, loads, kTick, nullptr, state).flags;
  state.x.row(0).setZero();  // collapse it, so that the repairs run as well
  state.x.row(1).setZero();
  for (int i = 0; i < 3; ++i) flags |= integrator->step(model, loads, kTick, nullptr, state).flags;
  EXPECT_EQ(test::num_allocations(), before);
  const std::vector<int> proof(100);
  EXPECT_EQ(test::num_allocations(), before + 1) << "the counter counts";
}

// 1000 m/s at random, in steps that resolve nothing and are hardly divided.
TEST(ImplicitIntegrator, NeverAllocatesInAMajorizedStep) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, isotropic(1.0e9, 0.3, 5.0e-4, 1000.0));
  IntegratorOptions options;
  options.kind = IntegratorKind::kImplicitEuler;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  options.newton_iterations = 1;
  options.max_halvings = 1;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  SeededRandom random(17);
  State state = rest_state(mesh);
  state.v = random_field(random, state.x.cols(), 1000.0);
  const Loads loads = no_loads();
  const std::size_t before = test::num_allocations();
  std::uint32_t flags = 0;
  for (int i = 0; i < 50; ++i) flags |= integrator->step(model, loads, 1.0, nullptr, state).flags;
  EXPECT_EQ(test::num_allocations(), before);
  EXPECT_NE(flags & kMajorized, 0U);
}

TEST_P(IntegratorContract, ReportsTheShareThatIsStrainedBeyondTheMaterialsLimit) {
  const mesh::TriangleMesh mesh = square_grid(5);
  Material material = soft_cloth();
  material.strain_limit = 0.8;
  const Model model(mesh, material);
  const std::unique_ptr<Integrator> integrator = make(model);
  State state = rest_state(mesh);
  EXPECT_EQ(integrator->step(model, no_loads(), 1e-5, nullptr, state).strained_share, 0.0);
  // Twice as long beyond the middle: half of the area.
  const double middle = 0.5 * (state.x.row(0).minCoeff() + state.x.row(0).maxCoeff());
  state.x.row(0) = state.x.row(0).unaryExpr([middle](double x) { return x > middle ? 2.0 * x - middle : x; });
  const StepStats stats = integrator->step(model, no_loads(), 1e-5, nullptr, state);
  EXPECT_NEAR(stats.max_strain, 1.0, 0.2);
  EXPECT_NEAR(stats.strained_share, 0.5, 1e-9);
}

TEST_P(IntegratorContract, SaysWhatItIs) {
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  EXPECT_EQ(integrator->kind(), GetParam().options.kind);
  EXPECT_FALSE(integrator->explanation().empty());
}

INSTANTIATE_TEST_SUITE_P(All, IntegratorContract, testing::ValuesIn(all_integrators()), case_name);
INSTANTIATE_TEST_SUITE_P(Undamped, IntegratorContract, testing::ValuesIn(undamped_integrators()), case_name);

}  // namespace
}  // namespace kerf::fem
