// The explicit integrator in mixed precision: as near as in double, and in double where it cannot be.
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "tests/fem/leapfrog_cases.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/matrix_near.h"
#include "tests/support/random_cuts.h"

namespace kerf::fem {
namespace {

void expect_mixed_follows_double(MembraneLaw law) {
  for (const mesh::TriangleMesh& mesh : meshes()) {
    const Model model(mesh, soft_cloth(), law);
    State start = rest_state(mesh);
    Loads loads;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      if (mesh.rest_position(v).y() > 1.0 - 1e-9) loads.pins.push_back({v, start.x.col(v), Eigen::Vector3d::Zero()});
    }
    constexpr int kTicks = 6;
    std::vector<State> results;
    for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
      const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
      integrator->rebuild(model);
      results.push_back(stepped(model, *integrator, start, kTicks, loads));
    }
    EXPECT_LT(results[0].x.row(2).minCoeff(), -0.04);
    // Each substep rounds velocities of at most 1 m/s to 2^-24 of them, and forces, whose kicks are no larger, a few
    // times.
    constexpr double kMostSubsteps = 100.0 * kTicks;
    const double velocity_error = 7.0 * kMostSubsteps * 0x1p-24;  // m/s
    const double way_error = velocity_error * kTicks * kTick;     // m
    EXPECT_LT(results[0].v.cwiseAbs().maxCoeff(), 1.1);
    EXPECT_THAT(results[0].x, test::MatrixNear(results[1].x, way_error));
    const double mass = model.masses().total();
    EXPECT_NEAR(model.energies(results[1], loads.gravity).total(), model.energies(results[0], loads.gravity).total(),
                mass * velocity_error + mass * 9.81 * way_error);
  }
}

// The constants of triangles are kept in the unit of positions, which follows from extent and speed.
TEST(MixedPrecision, GivesTheBitsOfAFreshStartWhateverItsUnitWas) {
  for (const MembraneLaw law : kLaws) {
    for (const mesh::TriangleMesh& mesh : meshes()) {
      const Model model(mesh, soft_cloth(), law);
      const State slow = crumpled_state(mesh);
      State fast = slow;
      fast.v.colwise() += Eigen::Vector3d(90.0, 0.0, -40.0);
      const std::unique_ptr<Integrator> kept = make_integrator(options_of(Precision::kMixed));
      kept->rebuild(model);
      for (const State& start : {slow, fast, slow}) {
        const std::unique_ptr<Integrator> fresh = make_integrator(options_of(Precision::kMixed));
        fresh->rebuild(model);
        EXPECT_TRUE(equal_bits(stepped(model, *kept, start, 1), stepped(model, *fresh, start, 1)));
      }
    }
  }
}

TEST(MixedPrecision, FollowsDoubleThroughASwing) {
  for (const MembraneLaw law : kLaws) expect_mixed_follows_double(law);
}

// Forces that move nothing: what the sheet does by itself is not put right by where its centre must be (FreeFlight).
Loads pushed_by_nothing(const State& state) {
  Loads loads = no_loads();
  loads.external_forces = linear::VertexField(state.x.cols());
  loads.external_forces.setConstant(std::numeric_limits<double>::denorm_min());
  return loads;
}

TEST(MixedPrecision, KeepsMotionSlowerThanItsUnitOfLength) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, isotropic(1e-3, 0.3, 5.0e-4, 400.0));  // so soft that this is not slow
  const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
  integrator->rebuild(model);
  State state = rest_state(mesh);
  const linear::VertexField start = state.x;
  const Eigen::Vector3d velocity(1e-7, -3e-8, 7e-8);  // m/s; about a unit of 2^-30 m in a tick
  state.v.colwise() = velocity;
  constexpr int kTicks = 600;
  state = stepped(model, *integrator, state, kTicks, pushed_by_nothing(state));
  const Eigen::Vector3d way = kTicks * kTick * velocity;
  const linear::VertexField moved = state.x - start;
  EXPECT_LT((model.centre_of_mass(moved) - way).norm(), 1e-2 * way.norm());
  // Rounded constants make the rest shape, 1 m wide, another one by some 2^-24 of it.
  EXPECT_THAT(moved, test::MatrixNear(way.replicate(1, moved.cols()), 1e-2 * way.norm() + 2.0 * 0x1p-24));
}

// Some 100,000 substeps: what rounding takes off each change of velocity must not add up.
TEST(MixedPrecision, FallsAsFastInManySubstepsAsInFew) {
  const mesh::TriangleMesh mesh = square_grid(6);
  const Model model(mesh, isotropic(1e12, 0.3, 5.0e-4, 1000.0));
  const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
  integrator->rebuild(model);
  State state = rest_state(mesh);
  const double height = model.centre_of_mass(state.x).z();
  constexpr int kTicks = 18;
  long substeps = 0;
  Loads loads = pushed_by_nothing(state);
  loads.gravity = Loads().gravity;
  for (int i = 0; i < kTicks; ++i) substeps += integrator->step(model, loads, kTick, nullptr, state).substeps;
  EXPECT_GT(substeps, 50'000);
  const double time = kTicks * kTick;
  const double way = 0.5 * loads.gravity.z() * time * time;
  EXPECT_NEAR(model.centre_of_mass(state.x).z() - height, way, 4.0 * 0x1p-24 * std::abs(way));
  EXPECT_NEAR(state.v.row(2).mean(), loads.gravity.z() * time, 4.0 * 0x1p-24 * std::abs(loads.gravity.z() * time));
}

TEST(MixedPrecision, IsTheSameFarFromTheOrigin) {
  const mesh::TriangleMesh mesh = square_grid(9);
  const Model model(mesh, soft_cloth());
  const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
  integrator->rebuild(model);
  const State near = rest_state(mesh);
  State far = near;
  const Eigen::Vector3d there(1e4, -1e4, 5e3);
  far.x.colwise() += there;
  const State moved = stepped(model, *integrator, near, 30, hang_by_corners(9, near));
  const State far_moved = stepped(model, *integrator, far, 30, hang_by_corners(9, far));
  EXPECT_LT(moved.x.row(2).minCoeff(), -0.2);
  // Positions there are rounded to 1e-12 m, edges as well.
  EXPECT_THAT(far_moved.x.colwise() - there, test::MatrixNear(moved.x, 1e-5));
}

// Forces a thousand times its weight, whose rounding does not add up to 0.
TEST(MixedPrecision, KeepsTheWayAndTheSpinOfAFreeSheetToRoundOff) {
  for (const mesh::TriangleMesh& mesh : meshes()) {
    Material material = soft_cloth();
    material.mass_damping = 0.7;
    const Model model(mesh, material);
    std::vector<State> results;
    for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
      const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
      integrator->rebuild(model);
      results.push_back(stepped(model, *integrator, crumpled_state(mesh), 60));
    }
    const auto apart = [&](auto what) { return (what(results[1]) - what(results[0])).norm(); };
    EXPECT_GT((results[1].x - results[0].x).norm(), 1e-6);
    EXPECT_LT(apart([&](const State& s) { return model.centre_of_mass(s.x); }), 1e-12);
    EXPECT_LT(apart([&](const State& s) { return model.momentum(s).linear; }), 1e-12 * model.masses().total());
    EXPECT_LT(apart([&](const State& s) { return model.momentum(s).angular; }), 1e-12 * model.masses().total());
  }
}

// Which momentum cannot put right: bending that is damped brakes the spin of a sheet that is bent.
TEST(MixedPrecision, LosesTheSpinThatBendingDampingTakes) {
  const mesh::TriangleMesh mesh = square_grid(10);
  Material material = soft_cloth();
  material.stiffness_damping = 0.02;
  material.bending_scale = 100.0;
  const Model model(mesh, material);
  State start = rest_state(mesh);
  const Eigen::Vector3d turn(0.0, 6.0, 0.0);
  for (Eigen::Index i = 0; i < start.x.cols(); ++i) {
    start.x(2, i) = 0.3 * std::sin(3.0 * start.x(0, i));
    start.v.col(i) = turn.cross(Eigen::Vector3d(start.x.col(i)));
  }
  const auto spin = [&](const State& state) {
    const Momentum momentum = model.momentum(state);
    return Eigen::Vector3d(momentum.angular - model.centre_of_mass(state.x).cross(momentum.linear));
  };
  std::vector<Eigen::Vector3d> left;
  for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
    const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
    integrator->rebuild(model);
    left.push_back(spin(stepped(model, *integrator, start, 20)));
  }
  const double before = spin(start).norm();
  EXPECT_GT((left[0] - spin(start)).norm(), 1e-4 * before);
  EXPECT_LT((left[1] - left[0]).norm(), 1e-6 * before);
}

// Hangs in its own plane by two corners.
struct StiffSheet {
  StiffSheet() { loads.gravity = {0.0, -9.81, 0.0}; }
  static Material material() {
    Material stiff = isotropic(3e9, 0.3, 5.0e-4, 1300.0);
    stiff.mass_damping = 20.0;
    return stiff;
  }
  mesh::TriangleMesh mesh = square_grid(8);
  Model model{mesh, material()};
  State start = rest_state(mesh);
  Loads loads = hang_by_corners(8, start);
};

// Its rounding alone would keep a stiff sheet moving.
TEST(MixedPrecision, LetsAStiffSheetComeToRest) {
  const StiffSheet sheet;
  const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
  integrator->rebuild(sheet.model);
  const State state = stepped(sheet.model, *integrator, sheet.start, 120, sheet.loads);
  EXPECT_LT(state.v.colwise().norm().maxCoeff(), 1e-6);
}

// A sweep asks before each substep and after the last, so that one that is thrown away would show.
TEST(MixedPrecision, MakesEachStepOfASheetThatComesToRestOnce) {
  const StiffSheet sheet;
  const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
  integrator->rebuild(sheet.model);
  int times_asked = 0;
  const StopCondition stop = [&] {
    ++times_asked;
    return false;
  };
  integrator->set_stop_condition(&stop);
  State state = sheet.start;
  constexpr int kPerStep = 2;  // of the closing half kick, and after it
  for (int i = 0; i < 60; ++i) {
    times_asked = 0;
    const StepStats stats = integrator->step(sheet.model, sheet.loads, kTick, nullptr, state);
    EXPECT_EQ(times_asked, stats.substeps + kPerStep) << i;
  }
}

// A sheet at rest is stepped otherwise than one that falls: by the state, the model and the loads alone.
TEST(MixedPrecision, StepsASheetAtRestWhateverWasSteppedBefore) {
  const StiffSheet sheet;
  const std::unique_ptr<Integrator> exact = make_integrator(options_of(Precision::kDouble));
  exact->rebuild(sheet.model);
  const State at_rest = stepped(sheet.model, *exact, sheet.start, 120, sheet.loads);
  State still = at_rest;
  still.v.setZero();
  Loads let_go = sheet.loads;
  let_go.pins.clear();
  const std::unique_ptr<Integrator> mixed = make_integrator(options_of(Precision::kMixed));
  mixed->rebuild(sheet.model);
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (const State& start : {at_rest, still}) {
      for (const Loads& loads : {sheet.loads, let_go}) {
        const std::unique_ptr<Integrator> fresh = make_integrator(options_of(Precision::kMixed));
        fresh->rebuild(sheet.model);
        const State found = stepped(sheet.model, *mixed, start, 1, loads);
        EXPECT_TRUE(equal_bits(found, stepped(sheet.model, *fresh, start, 1, loads)));
        const State expected = stepped(sheet.model, *exact, start, 1, loads);
        EXPECT_THAT(found.x, test::MatrixNear(expected.x, 1e-7));
      }
    }
  }
}

// Triangles too flat for fixed point, clusters, bending that is damped, and a sheet that a pin pulls.
TEST(MixedPrecision, StepsACutSheetNearlyAtRestAlmostAsInDouble) {
  mesh::TriangleMesh mesh = square_grid(50);
  Material material = *find_preset("wool");
  material.stiffness_damping = 1e-6;
  Model model(mesh, material);
  test::RandomCuts cuts(1, mesh, model);
  cuts.make(20);
  State start = rest_state(mesh);
  SeededRandom random(14);
  start.v = random_field(random, start.x.cols(), 1e-3);
  Loads loads = no_loads();
  loads.pins.push_back({0, start.x.col(0) + Eigen::Vector3d(1e-6, 0.0, 2e-6), Eigen::Vector3d(1e-3, 0.0, 2e-3)});
  constexpr double kDuration = 1e-3;  // s
  std::vector<State> results;
  for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
    const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
    integrator->rebuild(model);
    State state = start;
    const std::size_t before = test::num_allocations();
    EXPECT_EQ(integrator->step(model, loads, kDuration, nullptr, state).flags, kNoFlags);
    EXPECT_EQ(test::num_allocations(), before);
    results.push_back(state);
  }
  EXPECT_GT((results[0].x - start.x).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_THAT(results[0].x, test::MatrixNear(results[1].x, 1e-10));
  EXPECT_THAT(results[0].v, test::MatrixNear(results[1].v, 1e-6));
}

// Two strips, of which the lower one has fallen by `way`, m.
State fallen(const mesh::TriangleMesh& mesh, double way) {
  SeededRandom random(17);
  State state = rest_state(mesh);
  state.v = random_field(random, state.x.cols(), 0.2);
  std::vector<bool> is_lower(static_cast<std::size_t>(mesh.num_vertices()));
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    double y = 0.0;
    for (const mesh::VertexId v : mesh.vertices(t)) y += mesh.rest_position(v).y() / 3.0;
    for (const mesh::VertexId v : mesh.vertices(t)) is_lower[static_cast<std::size_t>(v)] = y < 0.5;
  }
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (!is_lower[static_cast<std::size_t>(v)]) continue;
    state.x(2, v) -= way;
    state.v(2, v) -= std::sqrt(2.0 * 9.81 * way);
  }
  return state;
}

TEST(MixedPrecision, HoldsPiecesThatAreFarApart) {
  mesh::TriangleMesh mesh = mesh::make_grid({.num_x = 41, .num_y = 6, .width = 1.0, .height = 1.0}).value();
  const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{{-0.1, 0.5}, {1.1, 0.5}}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  ASSERT_TRUE(cut::apply(mesh, *plan).ok());
  for (const MembraneLaw law : kLaws) {
    const Model model(mesh, soft_cloth(), law);
    for (const double way : {0.0, 3.0, 60.0}) {
      std::vector<State> results;
      for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
        const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
        integrator->rebuild(model);
        results.push_back(stepped(model, *integrator, fallen(mesh, way), 3));
      }
      EXPECT_THAT(results[0].x, test::MatrixNear(results[1].x, 1e-7)) << way;
      EXPECT_THAT(results[0].v, test::MatrixNear(results[1].v, 1e-4)) << way;
    }
    // A step does not depend on the one before.
    const std::unique_ptr<Integrator> kept = make_integrator(options_of(Precision::kMixed));
    kept->rebuild(model);
    for (const double way : {60.0, 0.0, 60.0}) {
      const std::unique_ptr<Integrator> fresh = make_integrator(options_of(Precision::kMixed));
      fresh->rebuild(model);
      const State start = fallen(mesh, way);
      EXPECT_TRUE(equal_bits(stepped(model, *kept, start, 1), stepped(model, *fresh, start, 1))) << way;
    }
  }
}

// Pulls triangles that are nearly too small to 1.6 times their length, as strips are after many cuts.
TEST(MixedPrecision, HoldsWhatIsStretchedFar) {
  const mesh::TriangleMesh mesh = mesh::make_grid({.num_x = 41, .num_y = 2, .width = 1.0, .height = 4e-4}).value();
  const Model model(mesh, soft_cloth());
  State start = rest_state(mesh);
  start.x.row(0) *= 1.6;
  std::vector<State> results;
  for (const Precision precision : {Precision::kDouble, Precision::kMixed}) {
    const std::unique_ptr<Integrator> integrator = make_integrator(options_of(precision));
    integrator->rebuild(model);
    State state = start;
    EXPECT_EQ(integrator->step(model, Loads(), 1e-3, nullptr, state).flags & kWidened, 0U);
    results.push_back(state);
  }
  EXPECT_GT((results[0].x - start.x).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_THAT(results[0].x, test::MatrixNear(results[1].x, 1e-6));
}

TEST(MixedPrecision, MakesAStepInDoubleWhereATriangleIsTooFlat) {
  for (const double width : {0.1, 5e-5}) {
    const mesh::TriangleMesh mesh = mesh::make_grid({.num_x = 5, .num_y = 2, .width = 1.0, .height = width}).value();
    const Model model(mesh, soft_cloth());
    const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
    integrator->rebuild(model);
    State state = rest_state(mesh);
    state.v.row(0).setConstant(1.0);
    const StepStats stats = integrator->step(model, Loads(), 1e-4, nullptr, state);
    EXPECT_EQ(stats.flags, width < 1e-3 ? kWidened : kNoFlags) << width;
  }
}

TEST(MixedPrecision, MakesAStepInDoubleWhereItCannotHoldTheSheet) {
  const mesh::TriangleMesh mesh = square_grid(9);
  for (const double youngs_modulus : {1e5, 1e6, 1e7}) {
    Material material = soft_cloth();
    material.youngs_modulus_1 = material.youngs_modulus_2 = youngs_modulus;
    const Model model(mesh, material);
    const std::unique_ptr<Integrator> mixed = make_integrator(options_of(Precision::kMixed));
    const std::unique_ptr<Integrator> exact = make_integrator(options_of(Precision::kDouble));
    mixed->rebuild(model);
    exact->rebuild(model);
    for (const double dt : {1.0 / 37.0, kTick, 1.0 / 97.0}) {
      State state = rest_state(mesh);
      state.v.row(0).setConstant(1e7);  // m/s
      State expected = state;
      const StepStats stats = mixed->step(model, Loads(), dt, nullptr, state);
      EXPECT_EQ(stats.flags & kWidened, kWidened);
      EXPECT_EQ(stats.substeps, exact->step(model, Loads(), dt, nullptr, expected).substeps);
      EXPECT_TRUE(equal_bits(state, expected));
    }
  }
}

// A material that no triangle has is not asked.
TEST(MixedPrecision, StepsASlowSheetAsItsOwnMaterialWants) {
  const mesh::TriangleMesh mesh = square_grid(9);
  std::array<Material, 2> materials{soft_cloth(), soft_cloth()};
  materials[1].youngs_modulus_1 = materials[1].youngs_modulus_2 = 1e11;
  State start = rest_state(mesh);
  start.v.row(2).setConstant(1e-2);  // m/s
  const auto stepped_with = [&](std::size_t num_materials) {
    const Model model(mesh, std::span<const Material>(materials).first(num_materials));
    const std::unique_ptr<Integrator> integrator = make_integrator(options_of(Precision::kMixed));
    integrator->rebuild(model);
    return stepped(model, *integrator, start, 1, pushed_by_nothing(start));
  };
  EXPECT_TRUE(equal_bits(stepped_with(1), stepped_with(2)));
}

}  // namespace
}  // namespace kerf::fem
