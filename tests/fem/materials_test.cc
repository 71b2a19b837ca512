// Sheets of several materials.
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/membrane.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/fem/statics/recovered_fields.h"
#include "server/core/fem/step/integrator.h"
#include "server/core/mesh/regions.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

// Region 1 where `is_in` holds of a centroid, 0 elsewhere.
template <typename Predicate>
mesh::TriangleMesh divided(const mesh::TriangleMesh& mesh, const Predicate& is_in) {
  std::vector<std::int32_t> regions(static_cast<std::size_t>(mesh.num_triangle_slots()), 0);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
    for (const mesh::VertexId v : mesh.vertices(t)) centroid += mesh.rest_position(v) / 3.0;
    regions[static_cast<std::size_t>(t)] = is_in(centroid) ? 1 : 0;
  }
  return mesh::with_regions(mesh, regions);
}

mesh::TriangleMesh right_half(const mesh::TriangleMesh& mesh) {
  return divided(mesh, [](const Eigen::Vector2d& at) { return at.x() > 0.5; });
}

mesh::TriangleMesh with_inclusion(const mesh::TriangleMesh& mesh) {
  return divided(mesh, [](const Eigen::Vector2d& at) { return (at - Eigen::Vector2d(0.5, 0.5)).norm() < 0.25; });
}

Material soft() {
  Material m = orthotropic_cloth();
  m.mass_damping = 0.3;
  m.stiffness_damping = 1e-3;
  return m;
}

// In everything different from soft().
Material stiff() {
  Material m = isotropic(5.0e6, 0.2, 2.0e-3, 900.0);
  m.direction = -0.9;
  m.bending_scale = 0.5;
  m.mass_damping = 2.0;
  m.stiffness_damping = 4e-3;
  return m;
}

std::array<Material, 2> both() {
  return {soft(), stiff()};
}

double region_area(const mesh::TriangleMesh& mesh, std::int32_t region) {
  double area = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.region(t) == region) area += mesh.area(t);
  }
  return area;
}

// A shape that is strained and bent everywhere.
linear::VertexField bent(const mesh::TriangleMesh& mesh, double size) {
  SeededRandom random(5);
  return rest_state(mesh).x + random_field(random, mesh.num_vertices(), size);
}

TEST(Materials, StrainOfABimaterialStripJumpsAsTheModuliDo) {
  const mesh::TriangleMesh mesh = right_half(square_grid(9));
  std::array<Material, 2> materials{isotropic(1.0e6, 0.0, 1e-3, 300.0), isotropic(4.0e6, 0.0, 1e-3, 300.0)};
  for (Material& material : materials) material.bending_scale = 0.0;  // bending resists kinks within the sheet, too
  const Model model(mesh, materials);
  linear::VertexField x = rest_state(mesh).x;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double at = x(0, i);
    x(0, i) = at + 0.04 * std::min(at, 0.5) + 0.01 * std::max(at - 0.5, 0.0);
  }
  linear::VertexField f(x.cols());
  model.internal_forces(x, f);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double at = mesh.rest_position(static_cast<int>(i)).x();
    if (at > 1e-9 && at < 1.0 - 1e-9) {
      EXPECT_LT(f.col(i).norm(), 1e-12) << at;
    }
  }
  const auto strain = triangle_field(model, x, MembraneField::kBiotStrain, FieldAxes::kRest);
  const auto stress = triangle_field(model, x, MembraneField::kBiotStress, FieldAxes::kRest);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    EXPECT_NEAR(strain[static_cast<std::size_t>(t)].x(), mesh.region(t) == 0 ? 0.04 : 0.01, 1e-14);
    EXPECT_NEAR(stress[static_cast<std::size_t>(t)].x(), 4.0e4, 1e-7);
  }
  // Each side's own right up to the border, where a vertex inside has the mean of both.
  const auto at_vertices = vertex_field(model, strain, Recovery::kPatch);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    if (std::abs(at.x() - 0.5) > 1e-9) {
      EXPECT_NEAR(at_vertices[static_cast<std::size_t>(v)].x(), at.x() < 0.5 ? 0.04 : 0.01, 1e-12);
    } else if (at.y() > 0.2 && at.y() < 0.8) {  // away from the ends, with as many neighbours on each side
      EXPECT_NEAR(at_vertices[static_cast<std::size_t>(v)].x(), 0.025, 1e-12);
    }
  }
}

TEST(Materials, EachHasItsMassAndDamping) {
  const mesh::TriangleMesh mesh = right_half(square_grid(9));
  const std::array<Material, 2> materials = both();
  const Model model(mesh, materials);
  const double left = 300.0 * 1e-3 * 0.5, right = 900.0 * 2e-3 * 0.5;  // kg
  EXPECT_NEAR(model.masses().total(), left + right, 1e-14);
  EXPECT_NEAR(model.elements().area(), 1.0, 1e-14);
  const double lever = (left * 0.25 + right * 0.75) / (left + right);
  // Lumping moves the mass of a triangle to its corners, whose mean is its centroid.
  EXPECT_LT((model.centre_of_mass(rest_state(mesh).x) - Eigen::Vector3d(lever, 0.5, 0.0)).norm(), 1e-13);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    if (at.x() < 0.49) {
      EXPECT_DOUBLE_EQ(model.masses().damping(v), 0.3);
    }
    if (at.x() > 0.51) {
      EXPECT_DOUBLE_EQ(model.masses().damping(v), 2.0);
    }
    const bool is_between = std::abs(at.x() - 0.5) < 1e-9 && at.y() > 0.01 && at.y() < 0.99;
    if (is_between) {
      EXPECT_NEAR(model.masses().damping(v), (0.3 * 0.3 + 1.8 * 2.0) / 2.1, 1e-12);
    }
  }
}

TEST(Materials, OneIsForAllWhateverTheRegions) {
  const mesh::TriangleMesh plain = jittered_square(8);
  EXPECT_EQ(Model(right_half(plain), soft()).hash(), Model(plain, soft()).hash());
}

TEST(Materials, ForcesOfEqualOnesAreThoseOfOneBitForBit) {
  const mesh::TriangleMesh mesh = with_inclusion(jittered_square(9));
  const std::array<Material, 2> materials{soft(), soft()};
  const linear::VertexField x = bent(mesh, 0.02), v = bent(mesh, 0.5);
  const std::array<double, 2> beta{1e-3, 1e-3};
  const Model one(mesh, soft()), two(mesh, materials);
  linear::VertexField f(x.cols()), g(x.cols());
  f.setZero();
  g.setZero();
  add_membrane_forces(one.element_blocks(), one.materials(), std::span(beta).first(1), x, v, f);
  add_membrane_forces(two.element_blocks(), two.materials(), beta, x, v, g);
  for (Eigen::Index i = 0; i < f.cols(); ++i) EXPECT_EQ(f.col(i), g.col(i));
}

void expect_derivatives(MembraneLaw law) {
  const mesh::TriangleMesh mesh = with_inclusion(jittered_square(7));
  const std::array<Material, 2> materials = both();
  const Model model(mesh, materials, law);
  const linear::VertexField x = bent(mesh, 0.01);
  SeededRandom random(8);
  const linear::VertexField p = random_field(random, x.cols(), 1.0);
  constexpr double kStep = 1e-6;
  const auto energy = [&](double s) {
    const Energies energies = model.energies({x + s * p, p}, Eigen::Vector3d::Zero());
    return energies.membrane + energies.bending;
  };
  const auto forces = [&](double s) {
    linear::VertexField f(x.cols());
    model.internal_forces(x + s * p, f);
    return f;
  };
  const double slope = (energy(kStep) - energy(-kStep)) / (2.0 * kStep);
  EXPECT_NEAR(-forces(0.0).cwiseProduct(p).sum(), slope, 1e-6 * std::abs(slope));
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  tangent.add_membrane(model, x, {}, {}, 1.0, false);
  tangent.add_bending(model, {});
  linear::VertexField Kp(x.cols());
  tangent.blocks().multiply(p, Kp);
  const linear::VertexField difference = (forces(-kStep) - forces(kStep)) / (2.0 * kStep);
  EXPECT_LT((Kp - difference).norm(), 1e-6 * Kp.norm());
}

TEST(Materials, ForcesAreTheDerivativeOfTheEnergyAndTheTangentTheirs) {
  for (const MembraneLaw law : {MembraneLaw::kCorotational, MembraneLaw::kGreen}) expect_derivatives(law);
}

TEST(Materials, DampingPatchByPatchIsThatOfTheSumsWhereItIsTheSame) {
  const mesh::TriangleMesh mesh = with_inclusion(jittered_square(7));
  const std::array<Material, 2> materials = both();
  const Model model(mesh, materials);
  const linear::VertexField v = bent(mesh, 0.5);
  constexpr std::array<double, 2> kBeta{2e-3, 2e-3};
  linear::VertexField by_patch(v.cols()), of_sums(v.cols());
  by_patch.setZero();
  of_sums.setZero();
  add_bending_damping(model.bending().terms(model.element_blocks()), kBeta, v, by_patch);
  add_bending_forces(model.bending().rows(), kBeta[0] * v, of_sums);
  EXPECT_GT(of_sums.norm(), 0.0);
  EXPECT_LT((by_patch - of_sums).norm(), 1e-12 * of_sums.norm());
  // The matrix of an implicit step has the same.
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  const std::array<double, 2> beta{1e-3, 5e-3};
  tangent.add_bending(model, {0.0, 1.0, beta});
  linear::VertexField product(v.cols());
  tangent.blocks().multiply(v, product);
  by_patch.setZero();
  add_bending_damping(model.bending().terms(model.element_blocks()), beta, v, by_patch);
  EXPECT_LT((by_patch + product).norm(), 1e-12 * product.norm());
}

TEST(Materials, DampingOfNoneGainsEnergy) {
  const mesh::TriangleMesh mesh = with_inclusion(jittered_square(9));
  const std::array<Material, 2> materials = both();
  const Model model(mesh, materials);
  const std::array<double, 2> beta{0.0, 5e-3};
  // The largest gain that any rates could make: of the matrix of damping the lowest eigenvalue is not negative.
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  tangent.add_bending(model, {0.0, 1.0, beta});
  const Eigen::Index n = mesh.num_vertices();
  Eigen::MatrixXd damping(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    linear::VertexField unit(n), column(n);
    unit.setZero();
    unit(0, j) = 1.0;
    tangent.blocks().multiply(unit, column);
    damping.col(j) = column.row(0).transpose();
  }
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(damping).eigenvalues();
  EXPECT_GT(eigenvalues.maxCoeff(), 0.0);
  EXPECT_GE(eigenvalues.minCoeff(), -1e-12 * eigenvalues.maxCoeff());
}

TEST(Materials, TheStableStepHoldsForAStiffInclusion) {
  for (const double stiffening : {1e-3, 1.0, 1e4}) {
    const mesh::TriangleMesh mesh = with_inclusion(jittered_square(12));
    std::array<Material, 2> materials{orthotropic_cloth(), isotropic(1.0e6 * stiffening, 0.3, 1e-3, 2000.0)};
    for (const double direction : {0.4, 1.3}) {
      materials[0].direction = direction;
      const Model model(mesh, materials);
      const double largest = largest_eigenvalue(model, rest_state(mesh).x, 2000);
      EXPECT_LE(largest, model.stiffness_bound().value() * (1.0 + 1e-6));
      EXPECT_GT(largest, 0.85 * model.stiffness_bound().value());
    }
  }
}

TEST(Materials, WithoutBendingInOneThePatternOfTheMatrixIsWhole) {
  const mesh::TriangleMesh mesh = right_half(jittered_square(8));
  std::array<Material, 2> materials = both();
  materials[1].bending_scale = 0.0;
  const Model model(mesh, materials);
  const linear::VertexField x = bent(mesh, 0.01);
  TangentMatrix tangent;
  tangent.rebuild(model);
  tangent.set_mass(model, 0.0);
  tangent.add_membrane(model, x, {}, {}, 1.0, false);
  linear::VertexField p = bent(mesh, 1.0), Kp(x.cols()), up(x.cols()), down(x.cols());
  tangent.add_bending(model, {});
  tangent.blocks().multiply(p, Kp);
  model.internal_forces(x + 1e-6 * p, up);
  model.internal_forces(x - 1e-6 * p, down);
  EXPECT_LT((Kp - (down - up) / 2e-6).norm(), 1e-6 * Kp.norm());
  // Bent like a cylinder, the half without has no bending force away from the other.
  const Model other(right_half(square_grid(9)), materials);
  const mesh::TriangleMesh grid = square_grid(9);
  linear::VertexField roll = rest_state(grid).x;
  for (Eigen::Index i = 0; i < roll.cols(); ++i) roll(2, i) = 0.1 * roll(0, i) * roll(0, i) * roll(0, i);
  linear::VertexField f(roll.cols());
  f.setZero();
  add_bending_forces(other.bending().rows(), roll, f);
  double left = 0.0;
  for (mesh::VertexId v = 0; v < grid.num_vertices(); ++v) {
    const double at = grid.rest_position(v).x();
    if (at > 0.7) {
      EXPECT_EQ(f.col(v).norm(), 0.0);
    }
    if (at < 0.5) left = std::max(left, f.col(v).norm());
  }
  EXPECT_GT(left, 0.0);
}

void expect_steps_agree(MembraneLaw law) {
  const mesh::TriangleMesh mesh = with_inclusion(jittered_square(7));
  std::array<Material, 2> materials = both();
  materials[0].stiffness_damping = 1e-4;  // what explicit steps can carry
  materials[1].stiffness_damping = 2e-4;
  const Model model(mesh, materials, law);
  Loads loads;
  loads.gravity = {0.0, 0.0, -9.81};
  for (mesh::VertexId v = 0; v < 7; ++v) loads.pins.push_back({v, rest_state(mesh).x.col(v), Eigen::Vector3d::Zero()});
  const auto run = [&](IntegratorKind kind, int steps) {
    IntegratorOptions options;
    options.kind = kind;
    options.highest_mode_damping = 0.0;
    options.newton_iterations = 30;
    options.newton_tolerance = options.linear_tolerance = 1e-10;
    State state = rest_state(mesh);
    for (Eigen::Index i = 7; i < state.v.cols(); ++i) state.v(2, i) = 0.5 * state.x(1, i);
    const auto integrator = make_integrator(options);
    integrator->rebuild(model);
    for (int i = 0; i < steps; ++i) {
      EXPECT_EQ(integrator->step(model, loads, 0.05 / steps, nullptr, state).flags, kNoFlags);
    }
    return state;
  };
  const State exact = run(IntegratorKind::kExplicit, 4000);
  const State rest = rest_state(mesh);
  const double moved = (exact.x - rest.x).norm();
  const double coarse = (run(IntegratorKind::kTrBdf2, 50).x - exact.x).norm();
  const double fine = (run(IntegratorKind::kTrBdf2, 100).x - exact.x).norm();
  EXPECT_LT(fine, 1e-3 * moved);
  EXPECT_LT(fine, 0.5 * coarse);
}

TEST(Materials, ExplicitAndImplicitStepsAgree) {
  for (const MembraneLaw law : {MembraneLaw::kCorotational, MembraneLaw::kGreen}) expect_steps_agree(law);
}

TEST(Materials, WindBrakesEachByItsMass) {
  const mesh::TriangleMesh mesh = right_half(square_grid(9));
  std::array<Material, 2> materials{isotropic(1e5, 0.0, 1e-3, 100.0), isotropic(1e5, 0.0, 1e-3, 1000.0)};
  const Model model(mesh, materials);
  Loads loads;
  loads.gravity.setZero();
  loads.wind.velocity = {0.0, 0.0, 10.0};
  loads.wind.air_density = 1.2;
  loads.wind.normal_drag = 1.0;
  IntegratorOptions options;
  options.kind = IntegratorKind::kExplicit;
  const auto integrator = make_integrator(options);
  integrator->rebuild(model);
  State state = rest_state(mesh);
  integrator->step(model, loads, 1e-5, nullptr, state);
  // 0.5 rho v^2 per area over 0.1 and 1 kg/m^2.
  EXPECT_NEAR(state.v(2, 9 * 4 + 1), 60.0 / 0.1 * 1e-5, 1e-3 * 6e-3);
  EXPECT_NEAR(state.v(2, 9 * 4 + 7), 60.0 / 1.0 * 1e-5, 1e-3 * 6e-4);
}

TEST(Materials, ACutAcrossTheBorderKeepsThemAndUpdatesTheModelToWhatAFreshOneIs) {
  const std::array<Material, 2> materials = both();
  mesh::TriangleMesh mesh = with_inclusion(jittered_square(14));
  const std::array<double, 2> areas{region_area(mesh, 0), region_area(mesh, 1)};
  Model model(mesh, materials);
  const std::uint64_t before = model.hash();
  const double mass = model.masses().total();
  cut::CutRequest request;
  request.curve = cut::CubicBezier{{{-0.1, 0.31}, {0.4, 0.27}, {0.5, 0.9}, {1.1, 0.77}}};
  const Result<cut::CutPlan> plan = cut::plan(mesh, request);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  const Result<cut::CutOutcome> applied = cut::apply(mesh, *plan);
  ASSERT_TRUE(applied.ok()) << applied.error().message;
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  EXPECT_EQ(mesh.num_pieces(), 2);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(region_area(mesh, static_cast<std::int32_t>(i)), areas[i], 1e-14);
  }
  std::vector<mesh::TriangleId> rewritten = applied->edit.rewritten_triangles;
  model.apply(mesh, applied->edit);
  EXPECT_EQ(model.hash(), Model(mesh, materials).hash());
  EXPECT_NEAR(model.masses().total(), mass, 1e-12 * mass);
  applied->undo.undo(mesh);
  std::erase_if(rewritten, [&](mesh::TriangleId t) { return t >= mesh.num_triangle_slots(); });
  model.follow(mesh, rewritten);
  EXPECT_EQ(model.hash(), before);
  EXPECT_EQ(model.hash(), Model(mesh, materials).hash());
}

}  // namespace
}  // namespace kerf::fem
