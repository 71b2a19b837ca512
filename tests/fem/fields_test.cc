// Reactions at pins, and strain and stress in triangles and at vertices.
#include <algorithm>
#include <cmath>

#include "server/core/cut/cut.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/reactions.h"
#include "server/core/fem/statics/recovered_fields.h"
#include "tests/fem/fixture.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Reactions, HoldTheWeightOfAHangingSheetAndNothingElse) {
  const mesh::TriangleMesh mesh = square_grid(7);
  const Model model(mesh, isotropic(1.0e5, 0.3, 1.0e-3, 300.0));
  linear::VertexField x = rest_state(mesh).x;
  Loads loads;
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 0.5);
  for (int i = 0; i < 7; ++i) loads.pins.push_back({42 + i, x.col(42 + i), Vector3d::Zero()});
  loads.pins.push_back({0, x.col(0), Vector3d::Zero(), {true, false, false}});
  EquilibriumSolver solver({});
  solver.rebuild(model);
  ASSERT_TRUE(solver.solve(model, loads, nullptr, x).converged);
  linear::VertexField reactions;
  find_reactions(model, loads, x, reactions);
  const Vector3d push = [&] {
    Vector3d sum = Vector3d::Zero();
    for (int t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (!mesh.is_solid(t)) continue;
      const auto& c = mesh.vertices(t);
      sum += 0.25 * Vector3d(x.col(c[1]) - x.col(c[0])).cross(Vector3d(x.col(c[2]) - x.col(c[0])));
    }
    return sum;
  }();
  EXPECT_LT((Vector3d(reactions.rowwise().sum()) + push - Vector3d(0.0, 0.0, 0.3 * 9.81)).norm(), 1e-8);
  for (int v = 1; v < 42; ++v) EXPECT_TRUE(reactions.col(v).isZero(0.0));
  EXPECT_NE(reactions(0, 0), 0.0);
  EXPECT_EQ(reactions(1, 0), 0.0);
  EXPECT_EQ(reactions(2, 0), 0.0);
  // At rest, and with pins that do not accelerate, both are the same.
  linear::VertexField moving;
  const linear::VertexField still = Matrix3Xd::Zero(3, x.cols());
  find_reactions(model, loads, State{x, still}, still, moving);
  EXPECT_THAT(moving, test::MatrixNear(reactions, 1e-12));
}

TEST(Reactions, AccelerateWhatTheyHoldAgainstDampingAndWind) {
  const mesh::TriangleMesh mesh = square_grid(4);
  Material material = orthotropic_cloth();
  material.mass_damping = 3.0;
  const Model model(mesh, material);
  State state = rest_state(mesh);
  state.v.row(2).setConstant(2.0);
  linear::VertexField acceleration = Matrix3Xd::Zero(3, state.x.cols());
  acceleration.row(0).setConstant(5.0);
  Loads loads;
  for (int v = 0; v < mesh.num_vertices(); ++v) loads.pins.push_back({v, state.x.col(v), state.v.col(v)});
  loads.wind.air_density = 1.2;
  linear::VertexField reactions;
  find_reactions(model, loads, state, acceleration, reactions);
  // 0.3 kg: inertia, weight, mass damping; and drag 1/2 rho A c v^2 on 1 m^2.
  const double drag = 0.5 * 1.2 * loads.wind.normal_drag * 4.0;
  const Vector3d expected(0.3 * 5.0, 0.0, 0.3 * (9.81 + 3.0 * 2.0) + drag);
  EXPECT_LT((Vector3d(reactions.rowwise().sum()) - expected).norm(), 1e-12);
}

TEST(Reactions, ArePulledByGrabsThatStretchAndMove) {
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, orthotropic_cloth());
  State state = rest_state(mesh);
  Loads loads;
  loads.gravity.setZero();
  loads.pins.push_back({4, state.x.col(4), Vector3d::Zero()});
  loads.grabs.push_back({{4, mesh::kNone, mesh::kNone},
                         {1.0, 0.0, 0.0},
                         state.x.col(4) + Vector3d(0.0, 0.0, 0.2),
                         {0.0, 3.0, 0.0},
                         10.0,
                         0.5});
  linear::VertexField reactions;
  find_reactions(model, loads, state.x, reactions);
  EXPECT_LT((reactions.col(4) - Vector3d(0.0, 0.0, -2.0)).norm(), 1e-12);
  find_reactions(model, loads, state, state.v, reactions);
  EXPECT_LT((reactions.col(4) - Vector3d(0.0, -1.5, -2.0)).norm(), 1e-12);
}

// x = Q F X with F in the plane.
linear::VertexField mapped(const mesh::TriangleMesh& mesh, const Matrix2d& F, const Eigen::Matrix3d& Q) {
  linear::VertexField x = Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) x.col(v).head<2>() = F * mesh.rest_position(v);
  return Q * x;
}

TEST(TriangleField, IsThatOfAHomogeneousStretchInEitherAxesHoweverTheSheetIsTurned) {
  const mesh::TriangleMesh mesh = jittered_square(5);
  const Material material = orthotropic_cloth();  // fibres at 0.4 rad
  const Model model(mesh, material);
  const Matrix2d U{
      {1.20, 0.07},
      {0.07, 0.90},
  };
  SeededRandom random(2);
  const linear::VertexField x = mapped(mesh, U, random_rotation(random));
  const double c = std::cos(0.4);
  const double s = std::sin(0.4);
  const Matrix2d to_material{
      {c, s},
      {-s, c},
  };
  const Matrix2d e = to_material * (U - Matrix2d::Identity()) * to_material.transpose();
  const Vector3d strain(e(0, 0), e(1, 1), 2.0 * e(0, 1));
  const Vector3d stress = membrane_law(material) * strain / material.thickness;
  const std::vector<Vector3d> strains = triangle_field(model, x, MembraneField::kBiotStrain, FieldAxes::kMaterial);
  const std::vector<Vector3d> at_rest = triangle_field(model, x, MembraneField::kBiotStrain, FieldAxes::kRest);
  const std::vector<Vector3d> stresses = triangle_field(model, x, MembraneField::kBiotStress, FieldAxes::kMaterial);
  ASSERT_EQ(strains.size(), static_cast<std::size_t>(mesh.num_triangle_slots()));
  for (int t = 0; t < mesh.num_triangle_slots(); ++t) {
    const auto slot = static_cast<std::size_t>(t);
    if (!mesh.is_solid(t)) {
      EXPECT_TRUE(strains[slot].isZero(0.0));
      continue;
    }
    EXPECT_LT((strains[slot] - strain).norm(), 1e-12);
    EXPECT_LT((at_rest[slot] - Vector3d(0.20, -0.10, 0.14)).norm(), 1e-12);
    EXPECT_LT((stresses[slot] - stress).norm(), 1e-9 * stress.norm());
  }
  for (const Recovery recovery : {Recovery::kMean, Recovery::kPatch}) {
    for (const Vector3d& value : vertex_field(model, strains, recovery)) EXPECT_LT((value - strain).norm(), 1e-12);
  }
}

// The force on the sides of a stretched sheet is Cauchy's stress times thickness and length as they are now.
TEST(TriangleField, CauchyStressIsWhatReactionsTransmit) {
  const mesh::TriangleMesh mesh = square_grid(5);
  Material material = orthotropic_cloth();
  material.bending_scale = 0.0;
  const Model model(mesh, material);
  const Matrix2d F{
      {1.20, 0.07},
      {0.07, 0.90},
  };
  const linear::VertexField x = mapped(mesh, F, Eigen::Matrix3d::Identity());
  Loads loads;
  loads.gravity.setZero();
  for (int v = 0; v < mesh.num_vertices(); ++v) loads.pins.push_back({v, x.col(v), Vector3d::Zero()});
  linear::VertexField reactions;
  find_reactions(model, loads, x, reactions);
  Vector2d force = Vector2d::Zero();  // on the right half of the sheet: what crosses its middle
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.rest_position(v).x() > 0.6) force += reactions.col(v).head<2>();
  }
  const Vector3d sigma = triangle_field(model, x, MembraneField::kCauchyStress,
                                        FieldAxes::kRest)[static_cast<std::size_t>(mesh.triangle_at(12))];
  const Matrix2d stress{
      {sigma[0], sigma[2]},
      {sigma[2], sigma[1]},
  };
  const Vector2d side = F.col(1);  // of 1 m at rest; its normal times its length:
  const Vector2d expected = material.thickness * stress * Vector2d(side.y(), -side.x());
  EXPECT_LT((force - expected).norm(), 1e-9 * expected.norm());
}

// A beam in pure bending within its plane: strains are linear, e11 = k y, and nodes are where they belong.
double worst_recovery(int n, Recovery recovery) {
  constexpr double kBend = 1e-6;  // 1/m
  const mesh::TriangleMesh mesh = square_grid(n);
  const Model model(mesh, isotropic(1.0e6, 0.3, 1.0e-3, 300.0));
  linear::VertexField x = Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const Vector2d X = mesh.rest_position(v);
    x.col(v).head<2>() = X + kBend * Vector2d(X.x() * X.y(), -0.5 * X.x() * X.x() - 0.15 * X.y() * X.y());
  }
  const std::vector<Vector3d> stress =
      vertex_field(model, triangle_field(model, x, MembraneField::kBiotStress, FieldAxes::kRest), recovery);
  double worst = 0.0;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const Vector3d expected(1.0e6 * kBend * mesh.rest_position(v).y(), 0.0, 0.0);
    worst = std::max(worst, (stress[static_cast<std::size_t>(v)] - expected).norm());
  }
  return worst;  // of 1
}

TEST(VertexField, PatchesRecoverLinearStressAndMeansOnlyToFirstOrder) {
  EXPECT_LT(worst_recovery(9, Recovery::kPatch), 1e-5);
  const double coarse = worst_recovery(9, Recovery::kMean);
  EXPECT_GT(coarse, 0.05);
  EXPECT_NEAR(worst_recovery(17, Recovery::kMean), 0.5 * coarse, 0.02 * coarse);
}

TEST(VertexField, KeepsTheTwoSidesOfACutApart) {
  mesh::TriangleMesh mesh = square_grid(6);
  const auto plan = cut::plan(mesh, {cut::Polyline{{{-0.1, 0.45}, {1.1, 0.45}}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  ASSERT_TRUE(cut::apply(mesh, *plan).ok());
  const Model model(mesh, orthotropic_cloth());
  // Finds the part connected to the triangle at the upper right corner.
  std::vector<bool> is_above(static_cast<std::size_t>(mesh.num_vertices()), false);
  std::vector<mesh::TriangleId> stack;
  std::vector<bool> seen(static_cast<std::size_t>(mesh.num_triangle_slots()), false);
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.rest_position(v).minCoeff() > 1.0 - 1e-9) stack.push_back(mesh.triangle_at(v));
  }
  while (!stack.empty()) {
    const mesh::TriangleId t = stack.back();
    stack.pop_back();
    if (seen[static_cast<std::size_t>(t)]) continue;
    seen[static_cast<std::size_t>(t)] = true;
    for (const mesh::VertexId v : mesh.vertices(t)) is_above[static_cast<std::size_t>(v)] = true;
    for (int k = 0; k < 3; ++k) {
      if (mesh.neighbour(t, k) != mesh::kNone) stack.push_back(mesh.neighbour(t, k));
    }
  }
  const auto num_above = std::count(is_above.begin(), is_above.end(), true);
  EXPECT_GT(num_above, 15);
  EXPECT_GT(mesh.num_vertices() - num_above, 15);
  linear::VertexField x = Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const double stretch = is_above[static_cast<std::size_t>(v)] ? 1.1 : 0.9;
    x.col(v) << stretch * mesh.rest_position(v).x(), mesh.rest_position(v).y(), 0.0;
  }
  const std::vector<Vector3d> strain = triangle_field(model, x, MembraneField::kBiotStrain, FieldAxes::kRest);
  for (const Recovery recovery : {Recovery::kMean, Recovery::kPatch}) {
    const std::vector<Vector3d> values = vertex_field(model, strain, recovery);
    for (std::size_t v = 0; v < values.size(); ++v) {
      EXPECT_NEAR(values[v][0], is_above[v] ? 0.1 : -0.1, 1e-12);
    }
  }
}

}  // namespace
}  // namespace kerf::fem
