// The quadratic over the energy of a triangle, the step that is solved with it, and where integrators come to it.
#include "server/core/fem/element/majorized_membrane.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "server/core/fem/element/membrane.h"
#include "server/core/fem/step/stage_solver.h"
#include "tests/fem/integrator_cases.h"
#include "tests/fem/no_contact.h"
#include "tests/support/meshes.h"
#include "tests/support/shells.h"

namespace kerf::fem {
namespace {

constexpr double kThickness = 1.0e-3;  // m

// Orthotropic or not, stiff and soft in shear, nu of both signs.
Material random_material(SeededRandom& random, int kind) {
  Material m = isotropic(1.0e6, random.uniform(-0.9, 0.49), kThickness, 300.0);
  m.direction = random.uniform(0.0, 3.0);
  if (kind == 0) return m;
  m.poissons_ratio_12 = 0.63;  // as in the thesis' table 4.1
  m.shear_modulus = 0.51 / 3.1 * m.youngs_modulus_1;
  if (kind == 1) return m;
  m.youngs_modulus_2 = m.youngs_modulus_1 * std::pow(10.0, random.uniform(-2.0, 2.0));
  const double largest_ratio = std::sqrt(m.youngs_modulus_1 / m.youngs_modulus_2);
  m.poissons_ratio_12 = largest_ratio * random.uniform(kind == 2 ? 0.0 : -0.95, 0.95);
  m.shear_modulus = std::sqrt(m.youngs_modulus_1 * m.youngs_modulus_2) * std::pow(10.0, random.uniform(-2.0, 1.0));
  return m;
}
constexpr int kMaterialKinds = 4;

// One triangle, of any shape, and what is asked of it.
struct Triangle {
  explicit Triangle(SeededRandom& random, const Material& material) : model(make_mesh(random), material) {}

  static mesh::TriangleMesh make_mesh(SeededRandom& random) {
    mesh::IndexedMesh one;
    one.rest = Eigen::Matrix2Xd{
        {0.0, random.uniform(0.5, 2.0), random.uniform(-1.0, 1.0)},
        {0.0, 0.0, random.uniform(0.3, 1.0)},
    };
    one.triangles = Eigen::Vector3i(0, 1, 2);
    return mesh::import_mesh(one).value();
  }
  [[nodiscard]] const ElementBlock& block() const { return model.element_blocks()[0]; }
  // Corners with the deformation gradient F, of material axes.
  [[nodiscard]] mesh::VertexField positions(const Eigen::Matrix<double, 3, 2>& F) const {
    const Eigen::Matrix2d Dm_inv{
        {block().g1[0][0], block().g1[1][0]},
        {block().g2[0][0], block().g2[1][0]},
    };
    const Eigen::Matrix<double, 3, 2> edges = F * Dm_inv.inverse();
    mesh::VertexField x = Eigen::Matrix3Xd::Zero(3, 3);
    x.col(block().vertex[1][0]) = edges.col(0);
    x.col(block().vertex[2][0]) = edges.col(1);
    return x;
  }
  [[nodiscard]] MajorizedTriangle majorized(const mesh::VertexField& x) const {
    LaneFrames frames;
    frames_at(block(), x, frames);
    return {block(), 0, frames, model.materials()};
  }
  [[nodiscard]] double energy(const mesh::VertexField& x) const {
    return membrane_energy(model.element_blocks(), model.materials(), x);
  }

  Model model;
};

struct Deformation {
  const char* name;
  Eigen::Matrix<double, 3, 2> F;
  double least_stretch;  // -
};

std::vector<Deformation> deformations(SeededRandom& random) {
  const auto turned = [&](const Eigen::Matrix2d& V) -> Eigen::Matrix<double, 3, 2> {
    return random_rotation(random).leftCols<2>() * V;
  };
  const auto stretched = [&](double v1, double v2) -> Eigen::Matrix2d {
    const Eigen::Matrix2d Q = Eigen::Rotation2Dd(random.uniform(0.0, 3.0)).toRotationMatrix();
    return Q * Eigen::Vector2d(v1, v2).asDiagonal() * Q.transpose();
  };
  const double v = std::pow(10.0, random.uniform(-1.5, 1.0));
  Eigen::Matrix<double, 3, 2> mirrored = Eigen::Matrix<double, 3, 2>::Zero();
  mirrored.topRows<2>() = stretched(random.uniform(0.5, 1.5), -random.uniform(0.5, 1.5));
  return {
      {"at rest", turned(stretched(1.0, 1.0)), 1.0},
      {"strained a little", turned(stretched(random.uniform(0.9, 1.1), random.uniform(0.9, 1.1))), 0.9},
      {"any", turned(stretched(v, std::pow(10.0, random.uniform(-1.5, 1.0)))), 0.03},
      {"mirrored in its plane", mirrored, 0.5},
      {"nearly a line", turned(stretched(v, 1e-3)), 1e-3},
      {"a line", turned(stretched(v, 0.0)), 0.0},
      {"a point", Eigen::Matrix<double, 3, 2>::Zero(), 0.0},
  };
}

Eigen::Matrix<double, 3, 2> random_gradient(SeededRandom& random, double size) {
  Eigen::Matrix<double, 3, 2> F;
  F.col(0) = random_vector(random, size);
  F.col(1) = random_vector(random, size);
  return F;
}

// visit(triangle, deformation, stiffness in J) of all materials and deformations, at random.
template <typename Visit>
void for_triangles(const Visit& visit) {
  constexpr int kTriangles = 60;
  SeededRandom random(7);
  for (int i = 0; i < kTriangles; ++i) {
    const Triangle triangle(random, random_material(random, i % kMaterialKinds));
    const double stiffness = triangle.model.materials().largest_membrane_trace() * triangle.model.elements().area();
    for (const Deformation& each : deformations(random)) {
      SCOPED_TRACE(std::string(each.name) + ", material of kind " + std::to_string(i % kMaterialKinds));
      visit(random, triangle, each, stiffness);
    }
  }
}

TEST(MajorizedTriangle, LiesAboveTheEnergyEverywhere) {
  int num_compared = 0;
  for_triangles([&](SeededRandom& random, const Triangle& triangle, const Deformation& at, double stiffness) {
    const MajorizedTriangle q = triangle.majorized(triangle.positions(at.F));
    // Rounding of H, which is large if the triangle is nearly a line.
    const double rounding = 1e-14 / std::max(at.least_stretch, MajorizedTriangle::kLeastStretch);
    for (int i = 0; i < 200; ++i) {
      Eigen::Matrix<double, 3, 2> F = random_gradient(random, std::pow(10.0, random.uniform(-2.0, 1.0)));
      if (i % 2 == 0) F = at.F + random_gradient(random, std::pow(10.0, random.uniform(-4.0, 0.0)));
      if (i % 5 == 0) F.col(1) = 1e-4 * F.col(1) + random.uniform(-2.0, 2.0) * F.col(0);
      const double size = 1.0 + F.squaredNorm() + at.F.squaredNorm();
      ASSERT_GE(q.energy(F) - triangle.energy(triangle.positions(F)), -rounding * stiffness * size);
      ++num_compared;
    }
  });
  EXPECT_EQ(num_compared, 60 * 7 * 200);
}

TEST(MajorizedTriangle, TouchesWithTheSameForces) {
  for_triangles([&](SeededRandom& /*random*/, const Triangle& triangle, const Deformation& at, double stiffness) {
    const mesh::VertexField x = triangle.positions(at.F);
    const double gap = triangle.majorized(x).energy(at.F) - triangle.energy(x);
    const double size = 1.0 + at.F.squaredNorm();
    const bool touches = at.least_stretch > MajorizedTriangle::kLeastStretch;
    EXPECT_LE(std::abs(gap), (touches ? 1e-11 : MajorizedTriangle::kLeastStretch) * stiffness * size);
    if (!touches) return;
    mesh::VertexField forces = Eigen::Matrix3Xd::Zero(3, 3);
    mesh::VertexField expected = forces;
    add_majorized_forces(triangle.model.element_blocks(), triangle.model.materials(), x, forces);
    add_membrane_forces(triangle.model.element_blocks(), triangle.model.materials(), {}, x, x, expected);
    const double force = stiffness * triangle.model.elements().largest_gradient() * std::sqrt(size);
    EXPECT_LE((forces - expected).norm(), 1e-11 * force);
  });
}

// The second derivative of the energy that it has, and positive semidefinite.
TEST(MajorizedTriangle, IsAConvexQuadraticWithItsStiffness) {
  for_triangles([&](SeededRandom& random, const Triangle& triangle, const Deformation& at, double stiffness) {
    const MajorizedTriangle q = triangle.majorized(triangle.positions(at.F));
    const Eigen::Matrix<double, 3, 2> moved = random_gradient(random, 1.0);
    const mesh::VertexField dx = triangle.positions(moved);
    double expected = 0.0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const auto vertex = [&](int k) { return triangle.block().vertex[static_cast<std::size_t>(k)][0]; };
        expected += q.stiffness(i, j) * dx.col(vertex(i)).dot(dx.col(vertex(j)));
      }
    }
    EXPECT_GE(expected, 0.0);
    const double found = q.energy(at.F + moved) - 2.0 * q.energy(at.F) + q.energy(at.F - moved);
    EXPECT_NEAR(found, expected, 1e-10 * (expected + stiffness * (1.0 + at.F.squaredNorm())));
  });
}

// Holds if no smaller quadratic lies above: nu >= 0, isotropic.
TEST(MajorizedTriangle, IsTheKnownOneOfIsotropicMaterial) {
  SeededRandom random(3);
  const Triangle triangle(random, isotropic(1.0e6, 0.3, kThickness, 300.0));
  const Eigen::Matrix3d& C = triangle.model.materials()[0].membrane;
  const double mu = C(2, 2);
  const double lambda = C(0, 1);
  const double area = triangle.model.elements().area();
  const Eigen::Matrix2d V = Eigen::Vector2d(1.7, 0.4).asDiagonal();
  const Eigen::Matrix<double, 3, 2> R = random_rotation(random).leftCols<2>();
  const MajorizedTriangle q = triangle.majorized(triangle.positions(R * V));
  const auto known = [&](const Eigen::Matrix<double, 3, 2>& F) {
    const Eigen::Matrix2d G = mu * Eigen::Matrix2d::Identity() + 0.5 * lambda * V.trace() * V.inverse();
    return (F * G).cwiseProduct(F).sum() - 2.0 * (mu + lambda) * R.cwiseProduct(F).sum() + 2.0 * (mu + lambda);
  };
  for (int i = 0; i < 20; ++i) {
    const Eigen::Matrix<double, 3, 2> F = random_gradient(random, 2.0);
    EXPECT_NEAR(q.energy(F), area * known(F), 1e-12 * area * C(0, 0) * (1.0 + F.squaredNorm()));
  }
}

// Thrown about, crushed to a point or a line, mirrored, folded, fast.
std::vector<State> bad_states(const mesh::TriangleMesh& mesh) {
  SeededRandom random(11);
  const State rest = rest_state(mesh);
  const Eigen::Index n = rest.x.cols();
  std::vector<State> states;
  const auto add = [&](const mesh::VertexField& x, double speed) {
    states.push_back({x, random_field(random, n, speed)});
  };
  add(random_field(random, n, 1.0), 0.0);
  add(random_field(random, n, 1.0), 1000.0);
  add(rest.x, 1000.0);
  add(Eigen::Matrix3Xd::Zero(3, n), 1.0);
  add(Eigen::Vector3d(1.0, 0.0, 0.0).asDiagonal() * rest.x, 1.0);
  add(Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal() * rest.x, 10.0);
  add(Eigen::Vector3d(5.0, 0.01, 1.0).asDiagonal() * rest.x, 0.0);
  mesh::VertexField folded = rest.x;
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
  const mesh::VertexField none = Eigen::Matrix3Xd::Zero(3, model.num_vertices());
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
  direct.linear_solver = LinearSolverKind::kDirect;
  IntegratorOptions stopped;
  stopped.linear_solver = LinearSolverKind::kBlockJacobiCg;
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
  options.linear_solver = LinearSolverKind::kDirect;
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
    options.linear_solver = LinearSolverKind::kDirect;
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
