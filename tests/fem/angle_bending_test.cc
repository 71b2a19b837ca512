// Hinges, and bending by angles: what it has in common with the quadratic form that it comes from, and what not.
// element_test.cc compares its derivatives with differences.
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/hinge.h"
#include "server/core/mesh/regions.h"
#include "tests/fem/elements.h"
#include "tests/fem/fixture.h"
#include "tests/support/cut_patterns.h"
#include "tests/support/meshes.h"
#include "tests/support/shells.h"

namespace kerf::fem {
namespace {

using Points = std::array<Eigen::Vector3d, 4>;

// An edge of 0.7 m, corners 0.5 and 0.3 m from it, folded up by `phi`, somewhere in space.
Points folded(double phi, const Eigen::Matrix3d& R) {
  Points x{Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.7, 0.0, 0.0), Eigen::Vector3d(0.2, 0.5, 0.0),
           Eigen::Vector3d(0.9, -0.3 * std::cos(phi), 0.3 * std::sin(phi))};
  for (Eigen::Vector3d& each : x) each = R * each + Eigen::Vector3d(1.0, -2.0, 0.5);
  return x;
}
constexpr HingeSize kHingeSize{0.7, {0.5, 0.3}};

TEST(Hinge, HasItsAngle) {
  SeededRandom random(3);
  for (const double phi : {-3.14, -1.0, -1e-7, 0.0, 1e-9, 0.3, 1.5707, 3.0, 3.14159}) {
    const Hinge hinge(folded(phi, random_rotation(random)), kHingeSize);
    EXPECT_NEAR(hinge.theta(), phi, 1e-14) << phi;
  }
}

TEST(Hinge, HasTheDerivativesOfItsAngle) {
  SeededRandom random(4);
  for (const double phi : {-2.5, -0.4, 0.0, 0.01, 1.0, 2.9}) {
    Points x = folded(phi, random_rotation(random));
    for (Eigen::Vector3d& each : x) each += random_vector(random, 0.05);
    const Hinge hinge(x, kHingeSize);
    const std::array<Eigen::Vector3d, 4> gradient = hinge.gradient();
    const Eigen::Matrix<double, 12, 12> hessian = hinge.hessian();
    EXPECT_EQ(hessian, hessian.transpose()) << phi;
    constexpr double kStep = 1e-4;  // m
    for (std::size_t p = 0; p < 4; ++p) {
      for (Eigen::Index c = 0; c < 3; ++c) {
        // Fourth order.
        double slope = 0.0;
        Eigen::Matrix<double, 12, 1> curvature = Eigen::Matrix<double, 12, 1>::Zero();
        for (const auto& [offset, weight] : {std::pair(-2.0, 1.0), {-1.0, -8.0}, {1.0, 8.0}, {2.0, -1.0}}) {
          Points moved = x;
          moved[p][c] += offset * kStep;
          const Hinge other(moved, kHingeSize);
          slope += weight / (12.0 * kStep) * other.theta();
          const std::array<Eigen::Vector3d, 4> there = other.gradient();
          for (std::size_t q = 0; q < 4; ++q) {
            curvature.segment<3>(static_cast<Eigen::Index>(3 * q)) += weight / (12.0 * kStep) * there[q];
          }
        }
        EXPECT_NEAR(gradient[p][c], slope, 1e-9) << phi << ", point " << p;
        const auto column = static_cast<Eigen::Index>(3 * p) + c;
        EXPECT_LT((hessian.col(column) - curvature).norm(), 1e-7 * hessian.norm()) << phi << ", point " << p;
      }
    }
  }
}

TEST(Hinge, StaysFiniteWhereItHasCollapsed) {
  const Eigen::Vector3d o(1.0, 2.0, 3.0);
  const Eigen::Vector3d e(0.5, 0.0, 0.0);
  const std::array<Points, 4> collapsed{Points{o, o, o, o}, Points{o, o + e, o + 2.0 * e, o - e},
                                        Points{o, o, o + e, o - Eigen::Vector3d(0.0, 1.0, 0.0)},
                                        Points{o, o + e, o + Eigen::Vector3d(0.1, 0.3, 0.0), o + e}};
  for (const Points& x : collapsed) {
    const Hinge hinge(x, kHingeSize);
    EXPECT_TRUE(std::isfinite(hinge.theta()));
    EXPECT_LE(std::abs(hinge.theta()), std::numbers::pi);
    for (const Eigen::Vector3d& each : hinge.gradient()) EXPECT_LT(each.norm(), 1e4);
    EXPECT_TRUE(hinge.hessian().allFinite());
  }
}

// Nor does a triangle push out of the plane as long as it is in it, however small it has become.
TEST(Hinge, IsFlatInThePlaneHoweverNarrow) {
  for (const double share : {1.0, 0.06, 0.04, 1e-3, 1e-12, 0.0}) {
    const Points x{Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.7, 0.0, 0.0),
                   Eigen::Vector3d(0.2, 0.5 * share, 0.0), Eigen::Vector3d(0.9, -0.3, 0.0)};
    EXPECT_EQ(Hinge(x, kHingeSize).theta(), 0.0) << share;
  }
}

struct FoldedMesh {
  std::string name;
  mesh::TriangleMesh mesh;
};

std::vector<FoldedMesh> folded_meshes() {
  std::vector<FoldedMesh> meshes;
  for (const test::ZooMesh& each : test::zoo())
    meshes.push_back({each.name, test::must(mesh::import_mesh(each.sheet))});
  meshes.push_back({"grid", square_grid(7)});
  meshes.push_back({"jittered", jittered_square(7)});
  meshes.push_back({"union jack", test::union_jack(7)});
  mesh::TriangleMesh slit = square_grid(7);
  for (const cut::Curve& curve : test::kirigami(2, 2)) {
    const auto plan = cut::plan(slit, {curve, {}, {}});
    EXPECT_TRUE(plan.ok() && cut::apply(slit, *plan).ok());
  }
  meshes.push_back({"slits", std::move(slit)});
  return meshes;
}

// m
double least_height(const mesh::TriangleMesh& mesh) {
  double least = 1.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const Eigen::Matrix2d edges = mesh.rest_edges(t);
    const double longest = std::max({edges.col(0).norm(), edges.col(1).norm(), (edges.col(1) - edges.col(0)).norm()});
    least = std::min(least, edges.determinant() / longest);
  }
  return least;
}

// Energies of small deflections are those of the quadratic form, to the square of the slopes.
TEST(AngleBending, IsTheQuadraticFormOfSmallDeflections) {
  for (const FoldedMesh& tested : folded_meshes()) {
    SCOPED_TRACE(tested.name);
    const AngleBendingElement angles(tested.mesh, orthotropic_cloth());
    const Model model(tested.mesh, orthotropic_cloth());
    if (angles.angles().folds.empty()) continue;
    linear::VertexField x = rest_state(tested.mesh).x;
    const linear::VertexField flat = x;
    SeededRandom random(8);
    constexpr double kSlope = 1e-5;  // -
    const double height = least_height(tested.mesh);
    for (Eigen::Index v = 0; v < x.cols(); ++v) x(2, v) = kSlope * height * random.uniform(-1.0, 1.0);
    linear::VertexField deflection = x;  // in the plane rows of slivers sum to zero only as far as rounding goes
    deflection.topRows<2>().setZero();
    const double expected = bending_energy(model.bending().rows(), deflection);
    EXPECT_NEAR(angles.energy(x), expected, 1e-5 * expected);
    linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
    add_bending_forces(model.bending().rows(), deflection, f);
    EXPECT_LT((angles.forces(x) - f).row(2).norm(), 1e-5 * f.row(2).norm());
    // The stiffness of the flat sheet is that of deflections, and nothing else.
    const Eigen::MatrixXd K = angles.stiffness(flat, false);
    const Eigen::MatrixXd Q = BendingElement(tested.mesh, orthotropic_cloth()).stiffness(flat, false);
    const double scale = Q.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < K.rows(); ++i) {
      for (Eigen::Index j = 0; j < K.cols(); ++j) {
        const bool is_across = i % 3 == 2 && j % 3 == 2;
        EXPECT_NEAR(K(i, j), is_across ? Q(i, j) : 0.0, 1e-11 * scale) << i << " " << j;
      }
    }
  }
}

// The quadratic form has an energy for strains that change from place to place; angles have none.
TEST(AngleBending, HasNothingAgainstStrainInThePlane) {
  for (const FoldedMesh& tested : folded_meshes()) {
    SCOPED_TRACE(tested.name);
    const AngleBendingElement angles(tested.mesh, orthotropic_cloth());
    linear::VertexField x = rest_state(tested.mesh).x;
    const Eigen::Vector2d centre = x.topRows<2>().rowwise().mean();
    const double size = std::min(0.1, least_height(tested.mesh));  // no triangle turns over
    for (Eigen::Index v = 0; v < x.cols(); ++v) {
      const Eigen::Vector2d d = x.col(v).head<2>() - centre;
      x.col(v).head<2>() += size / (1.0 + d.squaredNorm()) * d.squaredNorm() * Eigen::Vector2d(d.y(), 1.0 + d.x());
    }
    if (!angles.angles().folds.empty()) {
      EXPECT_GT(bending_energy(angles.model.bending().rows(), x), 0.0);
    }
    EXPECT_EQ(angles.energy(x), 0.0);
    EXPECT_TRUE(angles.forces(x).isZero(0.0));
  }
}

// Holds at any amplitude: a folded sheet offers no way to gain energy.
TEST(AngleBending, IsNeverNegative) {
  SeededRandom random(9);
  for (const FoldedMesh& tested : folded_meshes()) {
    SCOPED_TRACE(tested.name);
    const AngleBendingElement angles(tested.mesh, orthotropic_cloth());
    for (const double size : {0.01, 0.1, 1.0, 10.0}) {
      const linear::VertexField x = rest_state(tested.mesh).x + random_field(random, tested.mesh.num_vertices(), size);
      EXPECT_GE(angles.energy(x), 0.0) << size;
      const Eigen::MatrixXd K = angles.stiffness(x, true);
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (K + K.transpose()), Eigen::EigenvaluesOnly);
      EXPECT_GE(eigen.eigenvalues().minCoeff(), -1e-12 * eigen.eigenvalues().maxCoeff()) << size;
    }
  }
}

// A strip rolled up without stretching: every patch has curvature 1 / r as a vector, and as an angle.
TEST(AngleBending, OfARollIsThatOfTheQuadraticForm) {
  constexpr double kRadius = 0.2;
  const mesh::TriangleMesh mesh = jittered_square(41);
  const AngleBendingElement angles(mesh, isotropic(1.0e6, 0.3, 1.0e-3, 300.0));
  linear::VertexField x = rest_state(mesh).x;
  for (Eigen::Index v = 0; v < x.cols(); ++v) {
    const double angle = x(0, v) / kRadius;
    x(0, v) = kRadius * std::sin(angle);
    x(2, v) = kRadius * (1.0 - std::cos(angle));
  }
  const double quadratic = bending_energy(angles.model.bending().rows(), x);
  EXPECT_NEAR(angles.energy(x), quadratic, 0.005 * quadratic);
}

TEST(AngleBending, TakesTheSlopesThatClampsHold) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  Model model(mesh, orthotropic_cloth());
  const linear::VertexField rest = rest_state(mesh).x;
  std::vector<Clamp> clamps;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.rest_position(v).x() == 0.0) clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
  }
  model.set_clamps(mesh, clamps);
  Model quadratic = model;
  model.bend_by_angles(mesh);
  EXPECT_EQ(model.bending().energy(model.element_blocks(), rest), 0.0);
  // Tilted about the edge that is held, and moved along.
  linear::VertexField x = rest;
  constexpr double kTilt = 1e-4;
  x.row(2) = kTilt * rest.row(0);
  x.colwise() += Eigen::Vector3d(0.3, 0.2, 0.1);
  const double expected = quadratic.bending().energy(quadratic.element_blocks(), x);
  EXPECT_GT(expected, 0.0);
  EXPECT_NEAR(model.bending().energy(model.element_blocks(), x), expected, 1e-4 * expected);
  SeededRandom random(5);
  const linear::VertexField direction = random_field(random, x.cols(), 1.0);
  x += 0.02 * random_field(random, x.cols(), 1.0);
  linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
  linear::VertexField scratch = f;
  const linear::VertexField at_rest = f;
  model.bending().add_forces(model.element_blocks(), x, at_rest, {}, scratch, f);
  constexpr double kStep = 1e-6;
  const double slope = (model.bending().energy(model.element_blocks(), x + kStep * direction) -
                        model.bending().energy(model.element_blocks(), x - kStep * direction)) /
                       (2.0 * kStep);
  EXPECT_NEAR(-f.cwiseProduct(direction).sum(), slope, 1e-6 * std::abs(slope));
}

// One of two materials does not bend, with clamps, on cut meshes. Forces along a random direction are compared with
// differences of the energy, and stiffness with those of forces.
TEST(AngleBending, HasTheDerivativesOfItsEnergyOnEveryMesh) {
  SeededRandom random(11);
  for (const FoldedMesh& tested : folded_meshes()) {
    SCOPED_TRACE(tested.name);
    if (tested.name == "slivers") continue;  // differences resolve nothing there
    for (const bool has_membrane_part : {false, true}) {
      std::vector<std::int32_t> regions(static_cast<std::size_t>(tested.mesh.num_triangle_slots()), 0);
      for (std::size_t t = 0; t < regions.size(); t += 3) regions[t] = has_membrane_part ? 1 : 0;
      const mesh::TriangleMesh mesh = mesh::with_regions(tested.mesh, regions);
      Material slack = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
      slack.bending_scale = 0.0;
      const std::array<Material, 2> materials{orthotropic_cloth(), slack};
      Model model(mesh, materials);
      std::vector<Clamp> clamps;
      for (int v = 0; v < mesh.num_vertices(); v += 2) clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
      model.set_clamps(mesh, clamps);
      model.bend_by_angles(mesh);
      ASSERT_NE(model.bending().angles(), nullptr);
      const AngleBending& angles = *model.bending().angles();
      const double size = 0.05 * least_height(mesh);
      const Eigen::Index n = mesh.num_vertices();
      const linear::VertexField x = rest_state(mesh).x + random_field(random, n, size);
      const linear::VertexField direction = random_field(random, n, 1.0);
      const auto forces = [&](const linear::VertexField& at) {
        linear::VertexField f = Eigen::Matrix3Xd::Zero(3, n);
        angles.add_forces(at, f);
        return f;
      };
      const double step = 1e-3 * size;
      const linear::VertexField f = forces(x);
      const double slope = (angles.energy(x + step * direction) - angles.energy(x - step * direction)) / (2.0 * step);
      EXPECT_NEAR(-f.cwiseProduct(direction).sum(), slope, 1e-5 * f.cwiseProduct(direction).cwiseAbs().sum());
      TangentMatrix tangent;
      tangent.rebuild(model);
      tangent.blocks().set_zero();
      angles.add_stiffness(x, {}, false, tangent.blocks());
      linear::VertexField pull(n);
      tangent.blocks().multiply(direction, pull);
      const linear::VertexField change = (forces(x - step * direction) - forces(x + step * direction)) / (2.0 * step);
      EXPECT_LE((pull - change).norm(), 1e-5 * pull.norm());
    }
  }
}

TEST(AngleBending, EndsWithTheNextCut) {
  mesh::TriangleMesh mesh = square_grid(9);
  Model model(mesh, orthotropic_cloth());
  const std::uint64_t hash = model.hash();
  model.bend_by_angles(mesh);
  ASSERT_NE(model.bending().angles(), nullptr);
  EXPECT_EQ(model.hash(), hash);
  const auto plan = cut::plan(mesh, {cut::Polyline{{{0.31, 0.28}, {0.72, 0.61}}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  const auto outcome = cut::apply(mesh, *plan);
  ASSERT_TRUE(outcome.ok());
  model.apply(mesh, outcome->edit);
  EXPECT_EQ(model.bending().angles(), nullptr);
  EXPECT_EQ(model.hash(), Model(mesh, orthotropic_cloth()).hash());
}

TEST(AngleBending, IsNotOfCurvedRestShapes) {
  const mesh::TriangleMesh shell = test::must(mesh::import_mesh(test::rolled_square(6, 1.0)));
  Model model(shell, orthotropic_cloth());
  model.bend_by_angles(shell);
  EXPECT_EQ(model.bending().angles(), nullptr);
}

}  // namespace
}  // namespace kerf::fem
