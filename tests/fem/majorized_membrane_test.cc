// The quadratic over the energy of a triangle.
#include "server/core/fem/element/majorized_membrane.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/core/fem/element/membrane.h"
#include "tests/fem/integrator_cases.h"
#include "tests/fem/random_material.h"

namespace kerf::fem {
namespace {

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
  [[nodiscard]] linear::VertexField positions(const Eigen::Matrix<double, 3, 2>& F) const {
    const Eigen::Matrix2d Dm_inv{
        {block().g1[0][0], block().g1[1][0]},
        {block().g2[0][0], block().g2[1][0]},
    };
    const Eigen::Matrix<double, 3, 2> edges = F * Dm_inv.inverse();
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, 3);
    x.col(block().vertex[1][0]) = edges.col(0);
    x.col(block().vertex[2][0]) = edges.col(1);
    return x;
  }
  [[nodiscard]] MajorizedTriangle majorized(const linear::VertexField& x) const {
    LaneFrames frames;
    frames_at(block(), x, frames);
    return {block(), 0, frames, model.materials()};
  }
  [[nodiscard]] double energy(const linear::VertexField& x) const {
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
    const linear::VertexField x = triangle.positions(at.F);
    const double gap = triangle.majorized(x).energy(at.F) - triangle.energy(x);
    const double size = 1.0 + at.F.squaredNorm();
    const bool touches = at.least_stretch > MajorizedTriangle::kLeastStretch;
    EXPECT_LE(std::abs(gap), (touches ? 1e-11 : MajorizedTriangle::kLeastStretch) * stiffness * size);
    if (!touches) return;
    linear::VertexField forces = Eigen::Matrix3Xd::Zero(3, 3);
    linear::VertexField expected = forces;
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
    const linear::VertexField dx = triangle.positions(moved);
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
  const Triangle triangle(random, isotropic(1.0e6, 0.3, 1.0e-3, 300.0));
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

}  // namespace
}  // namespace kerf::fem
