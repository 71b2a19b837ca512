#include "server/fem/stable_step.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "server/fem/mass_redistribution.h"

namespace kerf::fem {
namespace {

using Matrix32 = Eigen::Matrix<double, 3, 2>;

// Strain-displacement matrix of one corner at rest, rows (e11, e22, 2 e12).
Matrix32 strain_displacement(double gx, double gy) {
  return Matrix32{
      {gx, 0.0},
      {0.0, gy},
      {gy, gx},
  };
}

struct Corner {
  Matrix32 B;
  double stiffness = 0.0;  // trace of A B^T C B, N/m
};

std::array<Corner, 3> corners_of(const ElementBlock& block, std::size_t l, const Eigen::Matrix3d& C) {
  const double g1x = block.g1[0][l];
  const double g1y = block.g1[1][l];
  const double g2x = block.g2[0][l];
  const double g2y = block.g2[1][l];
  std::array<Corner, 3> corners;
  corners[0].B = strain_displacement(-g1x - g2x, -g1y - g2y);
  corners[1].B = strain_displacement(g1x, g1y);
  corners[2].B = strain_displacement(g2x, g2y);
  for (Corner& corner : corners) {
    corner.stiffness = corner_stiffness(corner.B(0, 0), corner.B(1, 1), block.area[l], C);
  }
  return corners;
}

// >= the largest eigenvalue of a symmetric positive semidefinite H, by at most 15 %.
double largest_eigenvalue_bound(const Eigen::Matrix3d& H) {
  const double scale = H.trace();
  if (!(scale > 0.0)) return 0.0;
  Eigen::Matrix3d power = H / scale;
  power = (power * power).eval();
  power = (power * power).eval();
  power = (power * power).eval();
  return scale * std::sqrt(std::sqrt(std::sqrt(power.trace())));
}

double membrane_bound(const Model& model) {
  const Eigen::Matrix3d& C = model.membrane_law();
  const Eigen::Matrix3d L = C.llt().matrixL();
  std::vector<double> stiffness(static_cast<std::size_t>(model.num_vertices()), 0.0);
  for (const ElementBlock& block : model.element_blocks()) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const std::array<Corner, 3> corners = corners_of(block, l, C);
      for (std::size_t k = 0; k < 3; ++k) {
        stiffness[static_cast<std::size_t>(block.vertex[k][l])] += corners[k].stiffness;
      }
    }
  }
  double bound = 0.0;
  for (const ElementBlock& block : model.element_blocks()) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (block.area[l] == 0.0) continue;
      const std::array<Corner, 3> corners = corners_of(block, l, C);
      Eigen::Matrix3d G = Eigen::Matrix3d::Zero();  // sum over corners of A B B^T / (mass share)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = static_cast<std::size_t>(block.vertex[k][l]);
        const double mass_share = model.mass()[v] * corners[k].stiffness / stiffness[v];
        G += (block.area[l] / mass_share) * (corners[k].B * corners[k].B.transpose());
      }
      bound = std::max(bound, largest_eigenvalue_bound(L.transpose() * (G * L)));
    }
  }
  return bound;
}

double bending_bound(const Model& model) {
  const std::span<const double> inverse_mass = model.inverse_mass();
  double bound = 0.0;
  for (int i = 0; i < model.bending_rows().num_rows(); ++i) {
    double sum = 0.0;
    for (const BendingEntry& entry : model.bending_rows().row(i)) {
      sum += std::abs(entry.value) * std::sqrt(inverse_mass[static_cast<std::size_t>(entry.column)]);
    }
    bound = std::max(bound, sum * std::sqrt(inverse_mass[static_cast<std::size_t>(i)]));
  }
  return bound;
}

}  // namespace

double stiffness_bound(const Model& model) {
  return membrane_bound(model) + bending_bound(model);
}

}  // namespace kerf::fem
