#include "server/analysis/fields.h"

#include <cmath>

#include <Eigen/Geometry>

#include "server/fem/element_block.h"
#include "server/fem/material.h"

namespace kerf::analysis {

InPlane in_plane(const fem::Model& model, mesh::TriangleId slot, const mesh::VertexField& x) {
  const fem::ElementBlock& block = model.element_blocks()[static_cast<std::size_t>(slot / fem::kLanes)];
  const auto lane = static_cast<std::size_t>(slot % fem::kLanes);
  const Eigen::Vector3d x0 = x.col(block.vertex[0][lane]);
  const Eigen::Vector3d d1 = x.col(block.vertex[1][lane]) - x0;
  const Eigen::Vector3d d2 = x.col(block.vertex[2][lane]) - x0;
  Eigen::Matrix<double, 3, 2> F;
  F.col(0) = d1 * block.g1[0][lane] + d2 * block.g2[0][lane];
  F.col(1) = d1 * block.g1[1][lane] + d2 * block.g2[1][lane];
  // S = sqrt(F^T F) in closed form, see fem/membrane.h; in material axes.
  const Eigen::Matrix2d c = F.transpose() * F;
  const double d = F.col(0).cross(F.col(1)).norm();
  const double s = std::sqrt(c.trace() + 2.0 * d);
  Eigen::Matrix2d e = -Eigen::Matrix2d::Identity();
  if (s > 0.0) e += (c + d * Eigen::Matrix2d::Identity()) / s;
  const Eigen::Vector3d sigma =
      model.membrane_law() * Eigen::Vector3d(e(0, 0), e(1, 1), 2.0 * e(0, 1)) / model.material().thickness;
  Eigen::Matrix2d stress;
  stress << sigma[0], sigma[2], sigma[2], sigma[1];
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(model.material().direction).toRotationMatrix();
  const Eigen::Matrix2d strain_xy = turn * e * turn.transpose();
  const Eigen::Matrix2d stress_xy = turn * stress * turn.transpose();
  return {{strain_xy(0, 0), strain_xy(1, 1), strain_xy(0, 1)},
          {stress_xy(0, 0), stress_xy(1, 1), stress_xy(0, 1)},
          block.area[lane]};
}

InPlane in_plane_at(const fem::Model& model, mesh::VertexId vertex, const mesh::VertexField& x) {
  InPlane mean;
  for (const mesh::TriangleId slot : model.incident_slots().row(vertex)) {
    const InPlane one = in_plane(model, slot, x);
    mean.strain += one.area * one.strain;
    mean.stress += one.area * one.stress;
    mean.area += one.area;
  }
  if (mean.area > 0.0) {
    mean.strain /= mean.area;
    mean.stress /= mean.area;
  }
  return mean;
}

}  // namespace kerf::analysis
