// The law with Green's strain beside the co-rotational one: what both share and what sets them apart. Its contract as
// an element: element_test.cc; its vector code: leapfrog_test.cc.
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/LU>

#include "server/core/fem/element/membrane.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/recovered_fields.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

constexpr MembraneLaw kGreen = MembraneLaw::kGreen;

// Stretched to `lambda` along axis 1, free across: at Green's strain e across it has -nu e.
Eigen::Matrix3d uniaxial(double lambda, const Material& material) {
  const double e = 0.5 * (lambda * lambda - 1.0);
  const double across = std::sqrt(1.0 - 2.0 * material.poissons_ratio_12 * e);
  return Eigen::Vector3d(lambda, across, 1.0).asDiagonal();
}

linear::VertexField forces_at(const Model& model, const linear::VertexField& x) {
  linear::VertexField f(x.cols());
  model.internal_forces(x, f);
  return f;
}

TEST(GreenMembrane, IsTheCorotationalOneForSmallStrains) {
  const mesh::TriangleMesh mesh = jittered_square(5);
  const Model corotational(mesh, orthotropic_cloth());
  const Model green(mesh, orthotropic_cloth(), kGreen);
  SeededRandom random(5);
  const Eigen::Matrix3d R = random_rotation(random);
  // In the plane: out of it displacements strain the sheet by their squares alone.
  linear::VertexField field = random_field(random, mesh.num_vertices(), 1.0);
  field.row(2).setZero();
  for (const double size : {1e-3, 1e-4}) {
    const linear::VertexField x = R * (rest_state(mesh).x + size * field);
    const linear::VertexField expected = forces_at(corotational, x);
    const double scale = expected.cwiseAbs().maxCoeff();
    EXPECT_THAT(forces_at(green, x), test::MatrixNear(expected, 30.0 * size * scale));  // edges are 0.25 m
    EXPECT_GT((forces_at(green, x) - expected).cwiseAbs().maxCoeff(), 0.1 * size * scale);
    const double energy = membrane_energy(corotational.element_blocks(), corotational.materials(), x);
    EXPECT_NEAR(membrane_energy(green.element_blocks(), green.materials(), x), energy, 30.0 * size * energy);
  }
}

TEST(GreenMembrane, UniaxialStretchPullsAsTheFormulaSays) {
  Material material = orthotropic_cloth();
  material.direction = 0.0;
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, material, kGreen);
  for (const double lambda : {0.4, 0.58, 0.9, 1.01, 1.05, 1.2, 2.0}) {
    const linear::VertexField x = uniaxial(lambda, material) * rest_state(mesh).x;
    const linear::VertexField f = forces_at(model, x);
    const double linear = material.youngs_modulus_1 * material.thickness * (lambda - 1.0);  // the co-rotational one
    const double pull = f(0, 0) + f(0, 3) + f(0, 6);
    std::printf("stretched to %.2f: %.4f times the co-rotational pull\n", lambda, pull / linear);
    EXPECT_NEAR(pull, linear * 0.5 * lambda * (lambda + 1.0), 1e-9) << lambda;
    EXPECT_LT(f.row(1).cwiseAbs().maxCoeff(), 1e-9) << lambda;
    EXPECT_NEAR(membrane_energy(model.element_blocks(), model.materials(), x),
                0.125 * material.youngs_modulus_1 * material.thickness * std::pow(lambda * lambda - 1.0, 2), 1e-9);
  }
}

TEST(GreenMembrane, ResistsShorteningLessAndLessBelowPointFiveEight) {
  Material material = isotropic(1.0e6, 0.0, 1.0e-3, 300.0);
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, material, kGreen);
  const auto push = [&](double lambda) {
    const linear::VertexField f = forces_at(model, uniaxial(lambda, material) * rest_state(mesh).x);
    return -(f(0, 0) + f(0, 3) + f(0, 6));
  };
  const double softest = 1.0 / std::numbers::sqrt3;
  EXPECT_GT(push(softest), push(softest + 0.02));
  EXPECT_GT(push(softest), push(softest - 0.02));
  EXPECT_NEAR(push(1e-9), 0.0, 1e-6);
}

TEST(GreenStretch, IsWhatAUniformStretchMakesOfTheStiffness) {
  const Material material = isotropic(1.0e6, 0.0, 1.0e-3, 300.0);
  const mesh::TriangleMesh mesh = jittered_square(5);
  const Model model(mesh, material, kGreen);
  const auto stiffening = [&](const linear::VertexField& x) {
    return green_stretch(model.element_blocks(), model.materials(), x).stiffening;
  };
  EXPECT_NEAR(stiffening(rest_state(mesh).x), 1.0, 1e-12);
  for (const double lambda : {1.05, 1.5, 3.0}) {
    EXPECT_NEAR(stiffening(uniaxial(lambda, material) * rest_state(mesh).x), 0.5 * (3.0 * lambda * lambda - 1.0), 1e-9);
  }
  EXPECT_EQ(stiffening(0.9 * rest_state(mesh).x), 1.0);
}

TEST(GreenStretch, BoundsTheStiffnessOfAnyShape) {
  SeededRandom random(17);
  for (const bool jittered : {false, true}) {
    const mesh::TriangleMesh mesh = jittered ? jittered_square(7) : square_grid(7);
    for (Material material : {orthotropic_cloth(), soft_cloth(), find_preset("cotton").value()}) {
      material.bending_scale = 0.0;
      const Model model(mesh, material, kGreen);
      for (int trial = 0; trial < 8; ++trial) {
        const Eigen::Matrix3d F = Eigen::Matrix3d::Identity() + 0.5 * random_field(random, 3, 1.0);
        const linear::VertexField x = F * rest_state(mesh).x + random_field(random, mesh.num_vertices(), 0.01);
        const double bound =
            model.stiffness_bound().value() * green_stretch(model.element_blocks(), model.materials(), x).stiffening;
        const double largest = largest_eigenvalue(model, x, 100);
        EXPECT_LE(largest, bound);
        // If the sheet is folded so hard that it is unstable, the largest of all is negative.
        EXPECT_TRUE(largest < 0.0 || largest > 0.05 * bound) << largest << " of " << bound;
      }
    }
  }
}

TEST(GreenFields, StressesAreThoseThatThePullMakes) {
  Material material = orthotropic_cloth();
  material.direction = 0.0;
  const mesh::TriangleMesh mesh = square_grid(4);
  const Model model(mesh, material, kGreen);
  constexpr double kStretch = 1.3;
  const Eigen::Matrix3d F = uniaxial(kStretch, material);
  SeededRandom random(3);
  const linear::VertexField x = random_rotation(random) * F * rest_state(mesh).x;
  const double pull = material.youngs_modulus_1 * 0.5 * (kStretch * kStretch - 1.0) * kStretch;  // Pa at rest
  const auto expect_everywhere = [&](MembraneField field, const Eigen::Vector3d& expected, double tolerance) {
    const std::vector<Eigen::Vector3d> values = triangle_field(model, x, field, FieldAxes::kMaterial);
    for (mesh::TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
      if (!mesh.is_solid(slot)) continue;
      EXPECT_LT((values[static_cast<std::size_t>(slot)] - expected).norm(), tolerance);
    }
  };
  expect_everywhere(MembraneField::kBiotStress, {pull, 0.0, 0.0}, 1e-9 * pull);
  expect_everywhere(MembraneField::kCauchyStress, {pull / F(1, 1), 0.0, 0.0}, 1e-9 * pull);
  expect_everywhere(MembraneField::kBiotStrain, {kStretch - 1.0, F(1, 1) - 1.0, 0.0}, 1e-12);
}

TEST(GreenEquilibrium, OfAPulledStripIsTheExactOne) {
  Material material = isotropic(2.0e4, 0.0, 1.0e-3, 300.0);
  constexpr int kSide = 9;
  const mesh::TriangleMesh mesh = square_grid(kSide);
  const Model model(mesh, material, kGreen);
  State state = rest_state(mesh);
  Loads loads = no_loads();
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  constexpr double kPull = 10.0;  // N/m
  for (int i = 0; i < kSide; ++i) {
    const int upper = kSide * (kSide - 1) + i;
    loads.pins.push_back({upper, state.x.col(upper), Eigen::Vector3d::Zero()});
    loads.external_forces(1, i) = -kPull / (kSide - 1) * (i == 0 || i == kSide - 1 ? 0.5 : 1.0);
  }
  EquilibriumSolver solver({});
  solver.rebuild(model);
  const EquilibriumStats stats = solver.solve(model, loads, {}, state.x);
  EXPECT_TRUE(stats.converged) << stats.residual;
  EXPECT_EQ(stats.shift, 0.0);
  for (int i = 0; i < kSide; ++i) {
    const double lambda = 1.0 - state.x(1, i);
    EXPECT_GT(lambda, 1.3);
    EXPECT_NEAR(20.0 * 0.5 * lambda * (lambda * lambda - 1.0), kPull, 1e-7 * kPull);
  }
}

class GreenIntegrators : public IntegratorTest {};

// Explicit substeps and solved steps meet where steps are short, though their forces are written apart.
TEST_P(GreenIntegrators, SwingAlike) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Model model(mesh, soft_cloth(), kGreen);
  const Loads loads = hang_by_corners(9, rest_state(mesh));
  IntegratorOptions exact;
  exact.kind = IntegratorKind::kExplicit;
  exact.cfl = 0.2;
  exact.precision = Precision::kDouble;
  exact.highest_mode_damping = 0.0;
  const auto swing = [&](Integrator& integrator) {
    integrator.rebuild(model);
    State state = rest_state(mesh);
    constexpr int kSteps = 96;
    for (int i = 0; i < kSteps; ++i) {
      EXPECT_EQ(integrator.step(model, loads, 0.2 / kSteps, nullptr, state).flags & ~kNotConverged, 0U);
    }
    return state;
  };
  const State expected = swing(*make_integrator(exact));
  const State state = swing(*make_integrator(GetParam().options));
  EXPECT_LT(expected.x.row(2).minCoeff(), -0.15);
  const double tolerance = is(IntegratorKind::kImplicitEuler) ? 5e-3 : 5e-4;  // m
  EXPECT_THAT(state.x, test::MatrixNear(expected.x, tolerance));
}

// Steps that are stable at rest are not when the sheet is stretched to three times its length. Implicit steps do not
// resolve that at all, and may gain as much as their guard permits in each.
TEST_P(GreenIntegrators, KeepTheEnergyOfASheetLetGoWhenStretched) {
  const mesh::TriangleMesh mesh = square_grid(9);
  Material material = soft_cloth();
  material.bending_scale = 0.0;
  const Model model(mesh, material, kGreen);
  for (const double lambda : {1.2, 3.0}) {
    if (lambda > 2.0 && !is(IntegratorKind::kExplicit)) continue;
    State state = rest_state(mesh);
    state.x.row(0) *= lambda;
    const double energy = internal_energy(model, state);
    const std::unique_ptr<Integrator> integrator = make(model);
    for (int i = 0; i < 60; ++i) {
      const StepStats stats = integrator->step(model, no_loads(), kTick, nullptr, state);
      EXPECT_EQ(stats.flags & kFrozen, 0U);
      ASSERT_LE(internal_energy(model, state), (1.01 + 1e-9) * energy) << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, GreenIntegrators, testing::ValuesIn(all_integrators()), case_name);

class GreenExplicit : public testing::Test {
 protected:
  GreenExplicit() {
    IntegratorOptions options;
    options.kind = IntegratorKind::kExplicit;
    integrator = make_integrator(options);
    integrator->rebuild(model);
  }

  const mesh::TriangleMesh mesh = square_grid(9);
  const Model model{mesh, soft_cloth(), kGreen};
  std::unique_ptr<Integrator> integrator;
};

TEST_F(GreenExplicit, TakesShorterSubstepsWhereItIsStretched) {
  const auto substeps = [&](double lambda) {
    State state = rest_state(mesh);
    state.x *= lambda;
    Loads loads = no_loads();
    for (int v = 0; v < mesh.num_vertices(); ++v) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
    return integrator->step(model, loads, kTick, nullptr, state).substeps;
  };
  const int at_rest = substeps(1.0);
  EXPECT_EQ(substeps(0.8), at_rest);
  EXPECT_GT(substeps(2.0), 2 * at_rest);
}

TEST_F(GreenExplicit, MakesAStepAgainThatEndsMoreStretchedThanItsSubstepsBear) {
  State state = rest_state(mesh);
  Loads loads = no_loads();
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    Eigen::Vector3d target = state.x.col(v);
    target.x() *= 2.0;
    loads.pins.push_back({v, target, (target - state.x.col(v)) / kTick});
  }
  const StepStats stats = integrator->step(model, loads, kTick, nullptr, state);
  EXPECT_EQ(stats.flags & kSubstepped, kSubstepped);
}

}  // namespace
}  // namespace kerf::fem
