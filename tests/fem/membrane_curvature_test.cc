#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "server/core/fem/element/material_table.h"
#include "server/core/fem/element/membrane_curvature.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

// The energy per area of F = R U, 3 x 2, in material axes, N/m.
double energy(const Eigen::Matrix3d& C, const Eigen::Matrix<double, 3, 2>& F) {
  const Eigen::Matrix2d square = F.transpose() * F;
  const double det = std::sqrt(square.determinant());
  const Eigen::Matrix2d U = (square + det * Eigen::Matrix2d::Identity()) / std::sqrt(square.trace() + 2.0 * det);
  const Eigen::Vector3d strain(U(0, 0) - 1.0, U(1, 1) - 1.0, 2.0 * U(0, 1));
  return 0.5 * strain.dot(C * strain);
}

Eigen::Matrix<double, 3, 2> gradient_at(const Eigen::Vector2d& stretch, double angle) {
  const Eigen::Matrix2d Q = Eigen::Rotation2Dd(angle).toRotationMatrix();
  Eigen::Matrix<double, 3, 2> F = Eigen::Matrix<double, 3, 2>::Zero();
  F.topRows<2>() = Q * stretch.asDiagonal() * Q.transpose();
  return F;
}

Material random_material(SeededRandom& random) {
  Material material;
  material.youngs_modulus_1 = std::pow(10.0, random.uniform(5.0, 8.0));
  material.youngs_modulus_2 = material.youngs_modulus_1 * std::pow(10.0, random.uniform(-1.0, 1.0));
  const double limit = std::sqrt(material.youngs_modulus_1 / material.youngs_modulus_2);
  material.poissons_ratio_12 = random.uniform(-0.9, 0.9) * limit;
  material.shear_modulus = material.youngs_modulus_1 * std::pow(10.0, random.uniform(-2.0, 0.5));
  return material;
}

std::vector<Eigen::Matrix3d> laws() {
  std::vector<Eigen::Matrix3d> all;
  for (const std::string_view name : preset_names()) all.push_back(membrane_law(*find_preset(name)));
  SeededRandom random(3);
  for (int i = 0; i < 30; ++i) all.push_back(membrane_law(random_material(random)));
  return all;
}

// By differences of the energy itself.
TEST(MembraneCurvature, IsTheLargestSecondDerivative) {
  SeededRandom random(11);
  for (const Eigen::Matrix3d& C : laws()) {
    const Eigen::Vector2d stretch(random.uniform(0.4, 1.2), random.uniform(0.4, 1.2));
    const double angle = random.uniform(0.0, std::numbers::pi);
    const Eigen::Matrix<double, 3, 2> F = gradient_at(stretch, angle);
    constexpr double kStep = 1e-3;
    const auto at = [&](Eigen::Index i, double by_i, Eigen::Index j, double by_j) {
      Eigen::Matrix<double, 3, 2> moved = F;
      moved(i % 3, i / 3) += kStep * by_i;
      moved(j % 3, j / 3) += kStep * by_j;
      return energy(C, moved);
    };
    Eigen::Matrix<double, 6, 6> second;
    for (Eigen::Index i = 0; i < 6; ++i) {
      for (Eigen::Index j = 0; j < 6; ++j) {
        second(i, j) = (at(i, 1, j, 1) - at(i, 1, j, -1) - at(i, -1, j, 1) + at(i, -1, j, -1)) / (4.0 * kStep * kStep);
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> eigen(second, Eigen::EigenvaluesOnly);
    EXPECT_NEAR(membrane_curvature(C, stretch, angle), eigen.eigenvalues()[5], 1e-4 * C.diagonal().maxCoeff());
  }
}

TEST(MembraneCurvature, IsBoundedWhereverNothingIsStretchedFar) {
  SeededRandom random(12);
  for (const Eigen::Matrix3d& C : laws()) {
    const double bound = membrane_curvature_bound(C);
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2d stretch(random.uniform(kLeastStretch, kMostStretch), random.uniform(1e-3, kMostStretch));
      EXPECT_LE(membrane_curvature(C, stretch, random.uniform(0.0, std::numbers::pi)), bound) << stretch.transpose();
    }
  }
}

// 2 (mu + lambda), and for no law far above what it has at rest.
TEST(MembraneCurvature, IsThatAtRestOfIsotropicLaws) {
  for (const double nu : {0.0, 0.3, 0.48, 0.49}) {
    const Material material = isotropic(1e6, nu, 1e-3, 1000.0);
    const double lambda = 1e3 * nu / (1.0 - nu * nu);
    const double mu = 1e3 / (2.0 * (1.0 + nu));
    EXPECT_NEAR(membrane_curvature_bound(membrane_law(material)), 2.0 * (mu + lambda), 1e-9 * mu);
  }
}

}  // namespace
}  // namespace kerf::fem
