// Tests properties of single kinds of integrators. Properties of all: integrator_test.cc. The choice of the automatic
// one: automatic_integrator_test.cc.
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/fem/integrator_cases.h"
#include "tests/support/matrix_near.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

TEST(ExplicitIntegrator, AgreesWithAFinelyResolvedImplicitOne) {
  const mesh::TriangleMesh mesh = square_grid(9);
  const Model model(mesh, soft_cloth());
  State verlet = rest_state(mesh);
  State implicit = verlet;
  const Loads loads = hang_by_corners(9, verlet);
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  const std::unique_ptr<Integrator> first = make_integrator(options);
  first->rebuild(model);
  options.kind = IntegratorKind::kTrBdf2;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  options.newton_iterations = 8;
  const std::unique_ptr<Integrator> second = make_integrator(options);
  second->rebuild(model);
  for (int i = 0; i < 100; ++i) first->step(model, loads, 1e-3, nullptr, verlet);
  for (int i = 0; i < 100; ++i) second->step(model, loads, 1e-3, nullptr, implicit);
  EXPECT_THAT(verlet.x, test::MatrixNear(implicit.x, 2e-4));
  EXPECT_LT(verlet.x.row(2).minCoeff(), -0.04);
}

// Energy of motion after 1000 ticks of a square sheet of this thickness, m, stretched and held along its border, over
// that at the start.
double energy_of_a_taut_sheet(const IntegratorOptions& options, double thickness, double strain) {
  const mesh::TriangleMesh mesh = square_grid(11);
  const Model model(mesh, isotropic(1e6, 0.3, thickness, 1000.0));
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  State state = rest_state(mesh);
  state.x *= 1.0 + strain;
  Loads loads;
  loads.gravity.setZero();
  const double elastic = model.energies(state, loads.gravity).total();
  SeededRandom random(7);
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const Eigen::Array2d at = mesh.rest_position(i);
    if ((at > 1e-6 && at < 1.0 - 1e-6).all()) {
      state.v(2, i) = random.uniform(-1e-2, 1e-2);
    } else {
      loads.pins.push_back(Pin{i, state.x.col(i)});
    }
  }
  const double kinetic = model.energies(state, loads.gravity).kinetic;
  for (int i = 0; i < 1000; ++i) integrator->step(model, loads, kTick, nullptr, state);
  return (model.energies(state, loads.gravity).total() - elastic) / kinetic;
}

// Kicks by bending forces that come once in several substeps push modes that swing at their pace.
TEST(ExplicitIntegrator, BendsATautSheetWithoutResonance) {
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  for (const double thickness : {5e-3, 12.5e-3, 13e-3, 30e-3}) {
    for (const double strain : {0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.13}) {
      EXPECT_LT(energy_of_a_taut_sheet(options, thickness, strain), 1.1) << thickness << " m, stretched by " << strain;
    }
  }
}

// Undamped modes of the pace of substeps are swung up by others in a sheet that strains a little everywhere, unless
// substeps are shorter.
TEST(ExplicitIntegrator, KeepsAShakenSheetBoundedWithoutDamping) {
  constexpr double kPeriod = 1.0 / 3.0;  // s
  constexpr int kTicksASpan = 3;         // between changes of the border's velocity
  const mesh::TriangleMesh mesh = jittered_square(12, 1.0, 4);
  const Model model(mesh, isotropic(1e9, 0.45, 5e-4, 500.0));
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  options.precision = Precision::kDouble;
  options.highest_mode_damping = 0.0;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  State state = rest_state(mesh);
  const auto swing = [](int span) -> Eigen::Vector3d {
    return std::sin(2.0 * std::numbers::pi / kPeriod * kTick * kTicksASpan * span) * Eigen::Vector3d(0.0, 0.3, 0.2);
  };
  const int num_steps = test::num_trials({.few = 60, .usual = 420, .many = 420});
  for (int i = 0; i < num_steps; ++i) {
    const int span = i / kTicksASpan;
    const Eigen::Vector3d velocity = (swing(span + 1) - swing(span)) / (kTick * kTicksASpan);
    const Eigen::Vector3d moved = swing(span) + kTick * (i + 1 - span * kTicksASpan) * velocity;
    Loads loads;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d at = mesh.rest_position(v);
      if (at.x() < 1e-6) loads.pins.push_back(Pin{v, Eigen::Vector3d(at.x(), at.y(), 0.0) + moved, velocity});
    }
    integrator->step(model, loads, kTick, nullptr, state);
  }
  EXPECT_LT(internal_energy(model, state), 500.0);  // J
}

TEST(ExplicitIntegrator, TakesMoreSubstepsOfASheetThatIsStretchedFar) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Model model(mesh, isotropic(1e6, 0.49, 1e-4, 1000.0));
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  const auto substeps = [&](double stretch) {
    State state = rest_state(mesh);
    state.x *= stretch;
    Loads loads;
    for (int v = 0; v < mesh.num_vertices(); ++v) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
    return integrator->step(model, loads, 0.1, nullptr, state).substeps;
  };
  EXPECT_EQ(substeps(1.2), substeps(1.0));
  EXPECT_NEAR(substeps(2.0), (1.0 + 1.0 / 8) * substeps(1.0), 0.03 * substeps(1.0));
}

TEST(ExplicitIntegrator, ShortensTheStepItCannotAffordAndSaysSo) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, find_preset("wool").value());
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  options.max_substeps = 10;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  State state = rest_state(mesh);
  const StepStats stats = integrator->step(model, Loads{}, kTick, nullptr, state);
  EXPECT_NE(stats.flags & kSubstepLimit, 0U);
  EXPECT_EQ(stats.substeps, 10);
  EXPECT_LT(stats.simulated, kTick);
  EXPECT_NEAR(state.v(2, 0), -9.81 * stats.simulated, 1e-12);
}

TEST(ImplicitIntegrator, SaysWhenItDidNotConvergeAndStepsAllTheSame) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, soft_cloth());
  struct Case {
    int newton_iterations, linear_iterations;
    bool converges;
  };
  for (const Case& tested : {Case{30, 1000, true}, Case{1, 1000, false}, Case{30, 2, false}}) {
    IntegratorOptions options;
    options.kind = IntegratorKind::kImplicitEuler;
    options.newton_iterations = tested.newton_iterations;
    options.max_linear_iterations = tested.linear_iterations;
    options.newton_tolerance = 1e-6;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    SeededRandom random(5);
    State state = rest_state(mesh);
    state.x += random_field(random, state.x.cols(), 0.05);
    const StepStats stats = integrator->step(model, no_loads(), kTick, nullptr, state);
    EXPECT_EQ((stats.flags & kNotConverged) == 0, tested.converges) << stats.residual;
    EXPECT_EQ(stats.residual <= options.newton_tolerance, tested.converges) << stats.residual;
    EXPECT_EQ(stats.flags & kFrozen, 0U);
    EXPECT_EQ(stats.simulated, kTick);
    EXPECT_TRUE(is_finite(state));
  }
}

// Returns the error of a hanging cloth after 0.1 s, relative to the explicit integrator in steps of 10 us.
double error_of(IntegratorKind kind, double dt) {
  const mesh::TriangleMesh mesh = square_grid(9);
  Material material = soft_cloth();
  material.bending_scale = 0.0;
  const Model model(mesh, material);
  const auto run = [&](IntegratorKind tested, double step) {
    State state = rest_state(mesh);
    const Loads loads = hang_by_corners(9, state);
    IntegratorOptions options;
    options.kind = tested;
    options.linear_solver = linear::LinearSolverKind::kDirect;
    options.newton_iterations = 20;
    options.newton_tolerance = 1e-9;
    options.highest_mode_damping = 0.0;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    for (long i = 0; i < std::lround(0.1 / step); ++i) integrator->step(model, loads, step, nullptr, state);
    return state;
  };
  return (run(kind, dt).x - run(IntegratorKind::kExplicit, 1e-5).x).norm();
}

TEST(ImplicitIntegrator, IsOfItsOrder) {
  struct Case {
    IntegratorKind kind;
    double dt;
    int order;
  };
  for (const Case& tested : {Case{IntegratorKind::kImplicitEuler, 1e-3, 1}, Case{IntegratorKind::kTrBdf2, 2e-3, 2},
                             Case{IntegratorKind::kTrapezoidal, 1e-3, 2}, Case{IntegratorKind::kBdf2, 4e-3, 2},
                             Case{IntegratorKind::kSdirk2, 2e-3, 2}}) {
    const double coarse = error_of(tested.kind, tested.dt);
    const double fine = error_of(tested.kind, 0.5 * tested.dt);
    const double ratio = coarse / fine;
    std::printf("order %d: errors %.2e, %.2e, ratio %.2f\n", tested.order, coarse, fine, ratio);
    EXPECT_GT(ratio, tested.order == 1 ? 1.7 : 3.2);
    EXPECT_LT(ratio, tested.order == 1 ? 2.4 : 5.5);
  }
}

// Thrown together at random, stiff, in steps that resolve nothing.
State tangle(const mesh::TriangleMesh& mesh) {
  SeededRandom random(17);
  State state = rest_state(mesh);
  state.x = random_field(random, state.x.cols(), 1.0);
  return state;
}

TEST(ImplicitIntegrator, LeavesWhatSecondOrderFailsAtToImplicitEulerAndSaysSo) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, isotropic(1e9, 0.3, 5.0e-4, 1000.0));
  const auto step = [&](IntegratorKind kind, State& state) {
    IntegratorOptions options;
    options.kind = kind;
    options.linear_solver = linear::LinearSolverKind::kDirect;
    options.newton_iterations = 1;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    return integrator->step(model, no_loads(), 0.1, nullptr, state);
  };
  State euler = tangle(mesh);
  EXPECT_EQ(step(IntegratorKind::kImplicitEuler, euler).flags & kDamped, 0U);
  State tr_bdf2 = tangle(mesh);
  EXPECT_NE(step(IntegratorKind::kTrBdf2, tr_bdf2).flags & kDamped, 0U);
  EXPECT_EQ(tr_bdf2.x, euler.x);
  EXPECT_EQ(tr_bdf2.v, euler.v);
}

// Accelerations of 1e10 m/s^2 and more add up to nothing but rounding, which must not become momentum.
TEST(ImplicitIntegrator, KeepsTheMomentumOfAStiffSheetThatIsLetGo) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, isotropic(1e12, 0.3, 5.0e-4, 1000.0));
  for (const IntegratorKind kind :
       {IntegratorKind::kTrBdf2, IntegratorKind::kTrapezoidal, IntegratorKind::kBdf2, IntegratorKind::kSdirk2}) {
    IntegratorOptions options;
    options.kind = kind;
    options.linear_solver = linear::LinearSolverKind::kDirect;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    State state = rest_state(mesh);
    state.x.row(0) *= 1.5;
    int damped = 0;
    for (int i = 0; i < 20; ++i) {
      damped += (integrator->step(model, no_loads(), kTick, nullptr, state).flags & kDamped) != 0 ? 1 : 0;
    }
    EXPECT_LT(damped, 20);
    EXPECT_LT(model.momentum(state).linear.norm(), 1e-11 * model.masses().total()) << "kind " << static_cast<int>(kind);
  }
}

TEST(TrapezoidalRule, KeepsTheEnergyOfASheetThatVibrates) {
  const mesh::TriangleMesh mesh = square_grid(7);
  const Model model(mesh, soft_cloth());
  State state = rest_state(mesh);
  state.x.row(0) *= 1.01;  // within its plane
  IntegratorOptions options;
  options.kind = IntegratorKind::kTrapezoidal;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  options.newton_iterations = 20;
  options.newton_tolerance = 1e-10;
  const std::unique_ptr<Integrator> integrator = make_integrator(options);
  integrator->rebuild(model);
  const double before = internal_energy(model, state);
  for (int i = 0; i < 500; ++i) integrator->step(model, no_loads(), 2e-3, nullptr, state);
  EXPECT_NEAR(internal_energy(model, state), before, 2e-2 * before);
}

}  // namespace
}  // namespace kerf::fem
