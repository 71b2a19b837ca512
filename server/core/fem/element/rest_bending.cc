#include "server/core/fem/element/rest_bending.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "server/core/fem/element/material_table.h"
#include "server/core/linear/cross_matrix.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The frame F of a triangle, and how it rotates as the corners move.
struct Frame {
  std::array<Vector3d, 3> opposite;  // edge opposite each corner over twice the area, 1/m
  double over_length = 0.0;          // 1 / |first edge|, 1/m
  Matrix3d axes;                     // columns t1, t2, n

  bool is_valid = true;  // false if the corners lie on a line

  Frame(const std::array<Vector3d, 3>& corners, double rest_doubled_area) {
    const Vector3d first = corners[1] - corners[0];
    const Vector3d normal = first.cross(corners[2] - corners[0]);
    const double doubled_area = normal.norm();
    is_valid = doubled_area > 0.0;
    const double over = 1.0 / std::max(doubled_area, kLeastArea * rest_doubled_area);
    for (std::size_t k = 0; k < 3; ++k) opposite[k] = over * (corners[(k + 2) % 3] - corners[(k + 1) % 3]);
    const double length = first.norm();
    over_length = 1.0 / std::max(length, kLeastArea * std::sqrt(rest_doubled_area));
    axes.col(0) = first / length;
    axes.col(2) = normal / doubled_area;
    axes.col(1) = axes.col(2).cross(axes.col(0));
  }

  // Returns the angular velocity of the frame for given velocities of the corners.
  [[nodiscard]] Vector3d spin(const std::array<Vector3d, 3>& rates) const {
    Vector3d turn = (over_length * axes.col(1).dot(rates[1] - rates[0])) * axes.col(2);
    for (std::size_t k = 0; k < 3; ++k) turn += axes.col(2).dot(rates[k]) * opposite[k];
    return turn;
  }

  // Returns the force on corner k from a torque: the transpose of spin().
  [[nodiscard]] Vector3d force(std::size_t k, const Vector3d& torque) const {
    Vector3d f = opposite[k].dot(torque) * axes.col(2);
    if (k < 2) f += ((k == 1 ? 1.0 : -1.0) * over_length * axes.col(2).dot(torque)) * axes.col(1);
    return f;
  }
};

std::array<Vector3d, 3> corners_at(const BendingPatch& patch, const linear::VertexField& field) {
  return {field.col(patch.vertex[0]), field.col(patch.vertex[1]), field.col(patch.vertex[2])};
}

// Returns the stiffness at rest minus Q. The Gauss-Newton matrix of w - F w0 is exact there.
std::array<double, 21> excess_stiffness(const BendingFit& fit, const Frame& frame, const Matrix3d& w0) {
  std::array<std::array<Matrix3d, 6>, 3> gradient;  // of condition r by vertex
  for (int r = 0; r < 3; ++r) {
    const Matrix3d turned = linear::cross_matrix(frame.axes * w0.row(r).transpose());
    for (std::size_t i = 0; i < 6; ++i) {
      Matrix3d& block = gradient[static_cast<std::size_t>(r)][i];
      block = fit.conditions(r, static_cast<Eigen::Index>(i)) * Matrix3d::Identity();
      if (i > 2) continue;
      Matrix3d spin;  // column c is for a unit rate of coordinate c
      for (int c = 0; c < 3; ++c) {
        std::array<Vector3d, 3> rates{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
        rates[i] = Vector3d::Unit(c);
        spin.col(c) = frame.spin(rates);
      }
      block += turned * spin;
    }
  }
  const Eigen::Matrix<double, 6, 6> Q = fit.conditions.transpose() * (fit.law * fit.conditions);
  std::array<double, 21> excess{};
  std::size_t at = 0;
  // Vertices across the edges cause no spin, so there is no excess between two of them.
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<Matrix3d, 3> stress;  // law times the gradients by vertex i
    for (int r = 0; r < 3; ++r) {
      stress[static_cast<std::size_t>(r)] =
          fit.law(r, 0) * gradient[0][i] + fit.law(r, 1) * gradient[1][i] + fit.law(r, 2) * gradient[2][i];
    }
    for (std::size_t j = i; j < 6; ++j) {
      Matrix3d block = -Q(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * Matrix3d::Identity();
      for (std::size_t r = 0; r < 3; ++r) block += stress[r].transpose() * gradient[r][j];
      excess[at++] = block.norm();
    }
  }
  return excess;
}

}  // namespace

RestBending make_rest_bending(const std::array<Vector3d, 6>& surface, const BendingFit& fit) {
  RestBending rest;
  rest.is_bent = true;
  rest.doubled_area = (surface[1] - surface[0]).cross(surface[2] - surface[0]).norm();
  const Frame frame({surface[0], surface[1], surface[2]}, rest.doubled_area);
  Matrix3d w0 = Matrix3d::Zero();  // rows: conditions, in the frame
  for (int r = 0; r < 3; ++r) {
    Vector3d w = Vector3d::Zero();
    for (std::size_t i = 0; i < 6; ++i) {
      w += fit.conditions(r, static_cast<Eigen::Index>(i)) * (surface[i] - surface[0]);
    }
    w0.row(r) = (frame.axes.transpose() * w).transpose();
  }
  const Matrix3d stress = fit.law * w0;
  const Eigen::Matrix<double, 6, 3> load = fit.conditions.transpose() * stress;
  for (std::size_t i = 0; i < 6; ++i) rest.load[i] = load.row(static_cast<Eigen::Index>(i)).transpose();
  rest.energy = 0.5 * (w0.transpose() * stress).trace();
  rest.inertia = 2.0 * rest.energy * Matrix3d::Identity() - w0.transpose() * stress;
  rest.excess = excess_stiffness(fit, frame, w0);
  return rest;
}

void add_rest_bending_forces(const RestBendingPatches& sheet, const linear::VertexField& x,
                             const linear::VertexField& v, std::span<const double> beta, linear::VertexField& f) {
  for (std::size_t slot = 0; slot < sheet.rest.size(); ++slot) {
    const RestBending& rest = sheet.rest[slot];
    if (!rest.is_bent) continue;
    const BendingPatch& patch = sheet.patches[slot];
    const Frame frame(corners_at(patch, x), rest.doubled_area);
    if (!frame.is_valid) continue;
    const double damping = damping_of(beta, sheet.blocks[slot / kLanes].material[slot % kLanes]);
    const Vector3d spin = damping * frame.spin(corners_at(patch, v));
    Vector3d torque = -(frame.axes * (rest.inertia * (frame.axes.transpose() * spin)));
    for (std::size_t i = 0; i < 6; ++i) {
      if (patch.vertex[i] == mesh::kNone) continue;
      const Vector3d load = frame.axes * rest.load[i];
      const Vector3d arm =
          x.col(patch.vertex[i]) - x.col(patch.vertex[0]) + damping * (v.col(patch.vertex[i]) - v.col(patch.vertex[0]));
      torque += load.cross(arm);
      f.col(patch.vertex[i]) += load + spin.cross(load);
    }
    for (std::size_t k = 0; k < 3; ++k) f.col(patch.vertex[k]) += frame.force(k, torque);
  }
}

double rest_bending_energy(const RestBendingPatches& sheet, const linear::VertexField& x) {
  double sum = 0.0;
  for (std::size_t slot = 0; slot < sheet.rest.size(); ++slot) {
    const RestBending& rest = sheet.rest[slot];
    if (!rest.is_bent) continue;
    const BendingPatch& patch = sheet.patches[slot];
    const Frame frame(corners_at(patch, x), rest.doubled_area);
    sum += rest.energy;
    if (!frame.is_valid) continue;
    for (std::size_t i = 1; i < 6; ++i) {
      if (patch.vertex[i] == mesh::kNone) continue;
      sum -= (x.col(patch.vertex[i]) - x.col(patch.vertex[0])).dot(frame.axes * rest.load[i]);
    }
  }
  return sum;
}

}  // namespace kerf::fem
