// Sheets whose rest shape is curved.
#include <cmath>
#include <numbers>
#include <vector>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/step/integrator.h"
#include "tests/fem/fixture.h"
#include "tests/support/shells.h"

namespace kerf::fem {
namespace {

Material shell_material() {
  Material m = orthotropic_cloth();
  m.thickness = 0.02;  // bending matters
  return m;
}

std::vector<mesh::IndexedMesh> shells() {
  return {test::rolled_square(7, 0.4), test::rolled_square(6, 0.3, true), test::dome(7, 1.1, true),
          test::creased_sheet(7)};
}

double energy(const Model& model, const linear::VertexField& x) {
  State state;
  state.x = x;
  state.v = x;
  state.v.setZero();
  const Energies energies = model.energies(state, Eigen::Vector3d::Zero());
  return energies.membrane + energies.bending;
}

linear::VertexField turned(const linear::VertexField& x, const Eigen::Matrix3d& turn, const Eigen::Vector3d& shift) {
  linear::VertexField moved(x.cols());
  for (Eigen::Index i = 0; i < x.cols(); ++i) moved.col(i) = turn * Eigen::Vector3d(x.col(i)) + shift;
  return moved;
}

TEST(Shell, FeelsNothingAtRestHoweverItIsTurned) {
  SeededRandom random(3);
  for (const mesh::IndexedMesh& sheet : shells()) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    ASSERT_TRUE(mesh.is_curved());
    const Model model(mesh, shell_material());
    const State rest = rest_on_surface(mesh);
    // Forces of a flat sheet in this shape.
    linear::VertexField flat(rest.x.cols());
    flat.setZero();
    add_bending_forces(model.bending().rows(), rest.x, flat);
    ASSERT_GT(flat.norm(), 0.0);
    linear::VertexField f(rest.x.cols());
    for (int i = 0; i < 3; ++i) {
      const linear::VertexField x = turned(rest.x, random_rotation(random), random_vector(random, 1.0));
      model.internal_forces(x, f);
      EXPECT_LT(f.norm(), 1e-9 * flat.norm());
      EXPECT_LT(std::abs(energy(model, x)), 1e-10 * bending_energy(model.bending().rows(), x));
    }
  }
}

TEST(Shell, ForcesAreTheGradientOfTheEnergy) {
  SeededRandom random(5);
  for (const mesh::IndexedMesh& sheet : shells()) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    const Model model(mesh, shell_material());
    linear::VertexField x = turned(rest_on_surface(mesh).x, random_rotation(random), Eigen::Vector3d::Zero());
    x += random_field(random, x.cols(), 0.02);
    linear::VertexField f(x.cols());
    model.internal_forces(x, f);
    for (int i = 0; i < 5; ++i) {
      const linear::VertexField p = random_field(random, x.cols(), 1.0);
      constexpr double kStep = 1e-6;
      const double slope = (energy(model, x + kStep * p) - energy(model, x - kStep * p)) / (2.0 * kStep);
      EXPECT_NEAR(-f.cwiseProduct(p).sum(), slope, 1e-6 * f.norm() * p.norm());
    }
  }
}

TEST(Shell, ForcesHaveNoResultantAndDampingLetsItTurn) {
  SeededRandom random(7);
  for (const mesh::IndexedMesh& sheet : shells()) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    const Model model(mesh, shell_material());
    State state = rest_on_surface(mesh);
    const Eigen::Vector3d turn = random_vector(random, 1.0);
    for (const bool is_rigid : {true, false}) {
      if (!is_rigid) state.x += random_field(random, state.x.cols(), 0.02);
      for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
        state.v.col(i) =
            is_rigid ? Eigen::Vector3d(turn.cross(Eigen::Vector3d(state.x.col(i)))) : random_vector(random, 1.0);
      }
      constexpr double kBeta = 0.01;
      linear::VertexField f(state.x.cols());
      f.setZero();
      add_bending_forces(model.bending().rows(), state.x + kBeta * state.v, f);
      const double scale = f.norm();
      add_rest_bending_forces(model.bending().rest(model.element_blocks()), state.x, state.v, std::array{kBeta}, f);
      Eigen::Vector3d force = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
      for (Eigen::Index i = 0; i < f.cols(); ++i) {
        force += f.col(i);
        torque += Eigen::Vector3d(state.x.col(i)).cross(Eigen::Vector3d(f.col(i)));
      }
      EXPECT_LT(force.norm(), 1e-11 * scale);
      if (is_rigid) {
        EXPECT_LT(torque.norm(), 1e-11 * scale);
        EXPECT_LT(f.norm(), 1e-10 * scale);
      }
    }
  }
}

TEST(Shell, DampingTakesEnergy) {
  SeededRandom random(9);
  for (const mesh::IndexedMesh& sheet : shells()) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    const Model model(mesh, shell_material());
    const linear::VertexField x = rest_on_surface(mesh).x + random_field(random, mesh.num_vertices(), 0.02);
    for (int i = 0; i < 20; ++i) {
      const linear::VertexField v = random_field(random, x.cols(), 1.0);
      const auto power = [&](double beta) {
        linear::VertexField f(x.cols());
        f.setZero();
        add_bending_forces(model.bending().rows(), x + beta * v, f);
        add_rest_bending_forces(model.bending().rest(model.element_blocks()), x, v, std::array{beta}, f);
        return f.cwiseProduct(v).sum();
      };
      EXPECT_LE(power(0.01), power(0.0));
    }
  }
}

// Bent by kappa about y from flat to this radius, a unit square stores D11 kappa^2 / 2, and a rolled one as much when
// it is unrolled.
TEST(Shell, UnrollingStoresTheEnergyOfRolling) {
  constexpr double kRadius = 0.5;
  Material material = isotropic(1.0e6, 0.3, 0.02, 300.0);
  const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(test::rolled_square(41, kRadius)));
  const Model model(mesh, material);
  State flat;
  flat.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  flat.v = flat.x;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) flat.x.col(v).head<2>() = mesh.rest_position(v);
  const double exact = 0.5 * bending_law(material)(0, 0) / (kRadius * kRadius);
  EXPECT_NEAR(model.energies(flat, Eigen::Vector3d::Zero()).bending, exact, 0.04 * exact);
}

TEST(Shell, StiffnessBoundHolds) {
  for (const mesh::IndexedMesh& sheet : shells()) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    for (const double scale : {0.0, 1.0, 50.0}) {
      Material material = shell_material();
      material.bending_scale = scale;  // 50: so that bending decides
      const Model model(mesh, material);
      const double largest = largest_eigenvalue(model, rest_on_surface(mesh).x, 1000);
      EXPECT_GE(model.stiffness_bound().value(), largest * (1.0 - 1e-6));
      EXPECT_LE(model.stiffness_bound().value(), (scale > 1.0 ? 4.0 : 2.0) * largest);
    }
  }
}

TEST(Shell, BothIntegratorsKeepItsShape) {
  for (const IntegratorKind kind : {IntegratorKind::kExplicit, IntegratorKind::kImplicitEuler}) {
    const mesh::TriangleMesh mesh = test::must(mesh::import_mesh(test::dome(9, 1.1)));
    const Model model(mesh, shell_material());
    IntegratorOptions options;
    options.kind = kind;
    const std::unique_ptr<Integrator> integrator = make_integrator(options);
    integrator->rebuild(model);
    const State rest = rest_on_surface(mesh);
    State state = rest;
    const Eigen::Vector3d turn(0.03, 0.2, -0.1);  // slow: the rim gives way to the centrifugal force
    for (Eigen::Index i = 0; i < state.x.cols(); ++i) state.v.col(i) = turn.cross(Eigen::Vector3d(state.x.col(i)));
    Loads loads;
    loads.gravity.setZero();
    loads.external_forces = linear::VertexField(state.x.cols());
    loads.external_forces.setZero();
    for (int i = 0; i < 60; ++i) {
      const StepStats stats = integrator->step(model, loads, 1.0 / 60.0, nullptr, state);
      EXPECT_EQ(stats.flags & (kFrozen | kNotConverged), 0U);
    }
    // Turned by about 0.2 rad by now, yet every distance is what it was.
    double change = 0.0;
    for (Eigen::Index i = 1; i < state.x.cols(); ++i) {
      change =
          std::max(change, std::abs((state.x.col(i) - state.x.col(0)).norm() - (rest.x.col(i) - rest.x.col(0)).norm()));
    }
    EXPECT_LT(change, 0.01);
    EXPECT_GT((state.x.col(0) - rest.x.col(0)).norm(), 0.05);
  }
}

TEST(Shell, ACutUpdatesTheModelToWhatAFreshOneIs) {
  for (const mesh::IndexedMesh& sheet : shells()) {
    mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    Model model(mesh, shell_material());
    const double mass = model.masses().total();
    cut::CutRequest request;
    request.curve = cut::CubicBezier{{{-0.1, 0.31}, {0.4, 0.27}, {0.5, 0.9}, {1.1, 0.77}}};
    const Result<cut::CutPlan> plan = cut::plan(mesh, request);
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    const Result<cut::CutOutcome> applied = cut::apply(mesh, *plan);
    ASSERT_TRUE(applied.ok()) << applied.error().message;
    EXPECT_EQ(mesh.num_pieces(), 2);
    EXPECT_EQ(mesh.find_violation(), std::nullopt);
    model.apply(mesh, applied->edit);
    EXPECT_EQ(model.hash(), Model(mesh, shell_material()).hash());
    EXPECT_NEAR(model.masses().total(), mass, 1e-12 * mass);
    linear::VertexField f(mesh.num_vertices());
    const State rest = rest_on_surface(mesh);
    model.internal_forces(rest.x, f);
    linear::VertexField flat(mesh.num_vertices());
    flat.setZero();
    add_bending_forces(model.bending().rows(), rest.x, flat);
    EXPECT_LT(f.norm(), 1e-6 * flat.norm());
  }
}

// The mass floor once took the area ratio of whichever facet a vertex named, and an edit may name another.
TEST(Shell, ManyCutsFromVerticesUpdateTheModelToWhatAFreshOneIs) {
  SeededRandom random(5);
  for (const mesh::IndexedMesh& sheet : shells()) {
    mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
    Model model(mesh, shell_material());
    const auto vertex = [&] {
      return mesh.rest_position(
          static_cast<mesh::VertexId>(random.below(static_cast<std::uint64_t>(mesh.num_vertices()))));
    };
    for (int i = 0; i < 30; ++i) {
      const Eigen::Vector2d a = vertex(), b = vertex();
      cut::CutRequest request;
      request.curve = cut::CubicBezier{{a, a + (b - a) / 3.0, b + (a - b) / 3.0, b}};
      const Result<cut::CutPlan> plan = cut::plan(mesh, request);
      if (!plan.ok()) continue;  // both ends are one point
      const Result<cut::CutOutcome> applied = cut::apply(mesh, *plan);
      ASSERT_TRUE(applied.ok()) << applied.error().message;
      model.apply(mesh, applied->edit);
      ASSERT_EQ(model.hash(), Model(mesh, shell_material()).hash()) << "after cut " << i;
    }
  }
}

}  // namespace
}  // namespace kerf::fem
