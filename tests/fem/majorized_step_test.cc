// The step that is solved with quadratics over the energy of triangles, and integrators that resort to it.
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "server/core/fem/step/stage_solver.h"
#include "tests/fem/integrator_cases.h"
#include "tests/fem/no_contact.h"
#include "tests/fem/random_material.h"
#include "tests/support/meshes.h"
#include "tests/support/shells.h"

namespace kerf::fem {
namespace {

// Thrown about, crushed to a point or a line, mirrored, folded, fast.
std::vector<State> bad_states(const mesh::TriangleMesh& mesh) {
  SeededRandom random(11);
  const State rest = rest_state(mesh);
  const Eigen::Index n = rest.x.cols();
  std::vector<State> states;
  const auto add = [&](const linear::VertexField& x, double speed) {
    states.push_back({x, random_field(random, n, speed)});
  };
  add(random_field(random, n, 1.0), 0.0);
  add(random_field(random, n, 1.0), 1000.0);
  add(rest.x, 1000.0);
  add(Eigen::Matrix3Xd::Zero(3, n), 1.0);
  add(Eigen::Vector3d(1.0, 0.0, 0.0).asDiagonal() * rest.x, 1.0);
  add(Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal() * rest.x, 10.0);
  add(Eigen::Vector3d(5.0, 0.01, 1.0).asDiagonal() * rest.x, 0.0);
  linear::VertexField folded = rest.x;
  folded.row(0) = (rest.x.row(0).array() - 0.5).abs().matrix();
  add(folded, 0.1);
  // About the smallest height that the bound distinguishes from 0.
  add(Eigen::Vector3d(1.0, 1e-5, 1.0).asDiagonal() * rest.x, 0.1);
  add(Eigen::Vector3d(1.0, 1e-7, 1.0).asDiagonal() * rest.x, 0.1);  // and thinner
  // Thrown as a whole: what a solve that stops early leaves of its momentum must not be made up for afterwards.
  State thrown{rest.x, Eigen::Matrix3Xd::Zero(3, n)};
  thrown.v.row(2).setConstant(10.0);
  states.push_back(thrown);
  return states;
}

struct MajorizedStep {
  State end;
  StepStats stats;
};

MajorizedStep step_majorized(const Model& model, const Loads& loads, double dt, const IntegratorOptions& options,
                             const State& start) {
  StageSolver solver(options);
  solver.rebuild(model);
  Stage stage;
  stage.base = start;
  stage.momentum = model.momentum(start).linear;
  stage.d = dt;
  MajorizedStep step{start, {}};
  const linear::VertexField none = Eigen::Matrix3Xd::Zero(3, model.num_vertices());
  EXPECT_TRUE(solver.solve_majorized(model, loads, none, stage, step.end, step.stats));
  return step;
}

// Checks one step without loads.
void expect_no_gain(const Model& model, double dt, const IntegratorOptions& options, const State& start) {
  const double before = internal_energy(model, start);
  const auto [end, stats] = step_majorized(model, no_loads(), dt, options, start);
  ASSERT_TRUE(is_finite(end));
  EXPECT_LE(internal_energy(model, end), before * (1.0 + 1e-9));
  const double lost = (model.momentum(end).linear - model.momentum(start).linear).norm();
  double scale = 0.0;
  for (Eigen::Index i = 0; i < end.v.cols(); ++i) {
    scale += model.mass()[static_cast<std::size_t>(i)] *
             (start.v.col(i).norm() + end.v.col(i).norm() + end.x.cwiseAbs().maxCoeff() / dt);
  }
  EXPECT_LE(lost, 1e-13 * scale);
}

// Exactly solved and, of conjugate gradients, stopped at once: neither gains energy.
TEST(MajorizedStep, NeverGainsEnergyAndKeepsMomentum) {
  const mesh::TriangleMesh mesh = jittered_square(6);
  IntegratorOptions direct;
  direct.linear_solver = linear::LinearSolverKind::kDirect;
  IntegratorOptions stopped;
  stopped.linear_solver = linear::LinearSolverKind::kBlockJacobiCg;
  stopped.max_linear_iterations = 4;
  SeededRandom random(5);
  for (int i = 0; i < 5 * kMaterialKinds; ++i) {
    Material material = random_material(random, i % kMaterialKinds);
    const double scale = std::pow(1e3, i / kMaterialKinds) / material.youngs_modulus_1;  // 1 to 1e12 Pa
    for (double* modulus : {&material.youngs_modulus_1, &material.youngs_modulus_2, &material.shear_modulus}) {
      *modulus *= scale;
    }
    const Model model(mesh, material);
    for (const double dt : {1e-4, 1e-3, 1.0 / 60.0, 0.1, 1.0}) {
      for (const State& start : bad_states(mesh)) {
        SCOPED_TRACE("kind " + std::to_string(i % kMaterialKinds) + ", E " + std::to_string(material.youngs_modulus_1) +
                     ", dt " + std::to_string(dt));
        expect_no_gain(model, dt, direct, start);
        expect_no_gain(model, dt, stopped, start);
      }
    }
  }
}

TEST(MajorizedStep, GainsNoMoreThanTheWorkOfLoadsOnAPinnedSheet) {
  const mesh::TriangleMesh mesh = jittered_square(6);
  const Model model(mesh, orthotropic_cloth());
  IntegratorOptions options;
  options.linear_solver = linear::LinearSolverKind::kDirect;
  for (const double dt : {1e-3, 1.0 / 60.0, 1.0}) {
    int moved = 0;  // where nothing holds it; a sheet squashed to 1e-7 of its width is too stiff to
    for (const State& start : bad_states(mesh)) {
      Loads loads;
      State held = start;
      for (const int v : {0, 7}) {
        loads.pins.push_back({v, held.x.col(v), Eigen::Vector3d::Zero(), {true, v == 0, true}});
        held.v.col(v).setZero();
      }
      const auto [end, stats] = step_majorized(model, loads, dt, options, held);
      const double before = model.energies(held, loads.gravity).total();
      EXPECT_LE(model.energies(end, loads.gravity).total(), before + 1e-9 * (1.0 + std::abs(before))) << dt;
      EXPECT_EQ(end.x.col(0), held.x.col(0));
      EXPECT_EQ(end.x(2, 7), held.x(2, 7));
      moved += end.x(1, 7) != held.x(1, 7) ? 1 : 0;
    }
    EXPECT_GT(moved, 5);
  }
}

// 1000 m/s at random, in steps that resolve nothing and are hardly divided.
struct Thrown {
  explicit Thrown(IntegratorKind kind, MembraneLaw law = MembraneLaw::kCorotational)
      : mesh(square_grid(6)), model(mesh, isotropic(1.0e9, 0.3, 5.0e-4, 1000.0), law) {
    IntegratorOptions options;
    options.kind = kind;
    options.linear_solver = linear::LinearSolverKind::kDirect;
    options.newton_iterations = 1;
    options.max_halvings = 1;
    integrator = make_integrator(options);
    integrator->rebuild(model);
    SeededRandom random(17);
    state = rest_state(mesh);
    state.v = random_field(random, state.x.cols(), 1000.0);
  }
  StepStats step(const Loads& loads, ContactConstraint* contact = nullptr) {
    return integrator->step(model, loads, 1.0, contact, state);
  }

  mesh::TriangleMesh mesh;
  Model model;
  std::unique_ptr<Integrator> integrator;
  State state;
};
constexpr int kThrownSteps = 50;

TEST(MajorizedStep, TakesThePlaceOfStepsThatNoDivisionKeepsFromGaining) {
  for (const IntegratorKind kind : {IntegratorKind::kImplicitEuler, IntegratorKind::kTrBdf2, IntegratorKind::kBdf2}) {
    Thrown sheet(kind);
    FlagCounts counts{};
    double before = internal_energy(sheet.model, sheet.state);
    const Eigen::Vector3d momentum = sheet.model.momentum(sheet.state).linear;
    for (int i = 0; i < kThrownSteps; ++i) {
      const StepStats stats = sheet.step(no_loads());
      count_flags(stats.flags, counts);
      if ((stats.flags & kMajorized) != 0) {
        EXPECT_EQ(stats.flags & (kEnergyLimited | kSubstepped | kFrozen), 0U);
        EXPECT_EQ(stats.substeps, 1);
        EXPECT_EQ((stats.flags & kDamped) != 0, kind != IntegratorKind::kImplicitEuler);
      }
      const double after = internal_energy(sheet.model, sheet.state);
      EXPECT_LE(after, before * (1.0 + 1e-7));
      before = after;
    }
    EXPECT_GT(counts[std::countr_zero(static_cast<unsigned>(kMajorized))], 5) << "kind " << static_cast<int>(kind);
    EXPECT_LT((sheet.model.momentum(sheet.state).linear - momentum).norm(), 1e-9 * momentum.norm());
  }
}

TEST(MajorizedStep, WhatItCannotStepEitherStaysAsItWas) {
  Thrown sheet(IntegratorKind::kImplicitEuler);
  sheet.state.x(0, 0) = 1e300;  // m
  const State before = sheet.state;
  const StepStats stats = sheet.step(no_loads());
  EXPECT_NE(stats.flags & kFrozen, 0U);
  EXPECT_EQ(stats.flags & kMajorized, 0U);
  EXPECT_EQ(sheet.state.x, before.x);
  EXPECT_EQ(sheet.state.v, before.v);
}

TEST(MajorizedStep, IsNotTakenWhereItHoldsNothing) {
  const auto majorized = [](Thrown sheet, const Loads& loads, ContactConstraint* contact) {
    int count = 0;
    for (int i = 0; i < kThrownSteps; ++i) count += (sheet.step(loads, contact).flags & kMajorized) != 0 ? 1 : 0;
    return count;
  };
  constexpr IntegratorKind kEuler = IntegratorKind::kImplicitEuler;
  EXPECT_GT(majorized(Thrown(kEuler), no_loads(), nullptr), 0);
  EXPECT_EQ(majorized(Thrown(kEuler, MembraneLaw::kGreen), no_loads(), nullptr), 0);
  NoContact contact;
  EXPECT_EQ(majorized(Thrown(kEuler), no_loads(), &contact), 0);

  const mesh::TriangleMesh flat = square_grid(4);
  Loads pressed = no_loads();
  pressed.pressure.assign(static_cast<std::size_t>(flat.num_triangle_slots()), 1.0);
  EXPECT_TRUE(StageSolver::can_majorize(Model(flat, soft_cloth()), no_loads()));
  EXPECT_FALSE(StageSolver::can_majorize(Model(flat, soft_cloth()), pressed));
  Loads bent = no_loads();
  bent.edge_moments.emplace_back().moment = 1.0;
  EXPECT_FALSE(StageSolver::can_majorize(Model(flat, soft_cloth()), bent));
  Model by_angles(flat, soft_cloth());
  by_angles.bend_by_angles(flat);
  EXPECT_FALSE(StageSolver::can_majorize(by_angles, no_loads()));
  const mesh::TriangleMesh curved = test::must(mesh::import_mesh(test::rolled_square(6, 0.3)));
  EXPECT_FALSE(StageSolver::can_majorize(Model(curved, soft_cloth()), no_loads()));
  EXPECT_TRUE(StageSolver::can_majorize(Model(curved, without_bending(soft_cloth())), no_loads()));
}

}  // namespace
}  // namespace kerf::fem
