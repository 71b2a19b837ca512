#include "server/fem/stable_step.h"

#include <algorithm>
#include <array>
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

double membrane_bound(const StiffnessProblem& problem, const Eigen::Matrix3d& L, mesh::TriangleId slot) {
  const ElementBlock& block = problem.blocks[static_cast<std::size_t>(slot / kLanes)];
  const auto l = static_cast<std::size_t>(slot % kLanes);
  if (block.area[l] == 0.0) return 0.0;
  const std::array<Corner, 3> corners = corners_of(block, l, problem.membrane_law);
  Eigen::Matrix3d G = Eigen::Matrix3d::Zero();  // sum over corners of A B B^T / (mass share)
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(block.vertex[k][l]);
    const double mass_share = problem.mass[v] * corners[k].stiffness / problem.stiffness[v];
    G += (block.area[l] / mass_share) * (corners[k].B * corners[k].B.transpose());
  }
  return largest_eigenvalue_bound(L.transpose() * (G * L));
}

double bending_bound(const StiffnessProblem& problem, mesh::VertexId row) {
  double sum = 0.0;
  for (const BendingEntry& entry : problem.bending_rows.row(row)) {
    sum += std::abs(entry.value) * std::sqrt(problem.inverse_mass[static_cast<std::size_t>(entry.column)]);
  }
  return sum * std::sqrt(problem.inverse_mass[static_cast<std::size_t>(row)]);
}

}  // namespace

void RunningMaximum::resize(std::size_t size) {
  if (levels_.empty()) levels_.emplace_back();
  const std::size_t before = levels_.front().size();
  if (size == before) return;
  std::size_t level = 0;
  for (std::size_t n = size;; n = (n + kGroup - 1) / kGroup) {
    if (level == levels_.size()) levels_.emplace_back();
    levels_[level++].resize(n, 0.0);
    if (n <= 1) break;
  }
  levels_.resize(level);
  // Where values were dropped, the last group of each level lost some of its members; a level that is new at the top
  // has had none so far. Both have their maxima on the way from the first and the last value to the top.
  if (size > 0) {
    const std::array<std::int32_t, 2> ends{0, static_cast<std::int32_t>(size - 1)};
    update(ends);
  }
}

void RunningMaximum::update(std::span<const std::int32_t> changed) {
  std::vector<std::size_t> groups(changed.begin(), changed.end());
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    // Ids come in runs: dropping repetitions in a row leaves few.
    for (std::size_t& i : groups) i /= kGroup;
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    const std::vector<double>& below = levels_[level - 1];
    for (const std::size_t i : groups) {
      const auto first = below.begin() + static_cast<std::ptrdiff_t>(i * kGroup);
      const auto last = below.begin() + static_cast<std::ptrdiff_t>(std::min((i + 1) * kGroup, below.size()));
      levels_[level][i] = *std::max_element(first, last);
    }
  }
}

void StiffnessBound::update(const StiffnessProblem& problem, std::span<const mesh::TriangleId> slots,
                            std::span<const mesh::VertexId> vertices, std::span<const mesh::VertexId> rows) {
  const Eigen::Matrix3d L = problem.membrane_law.llt().matrixL();
  membrane_.resize(problem.blocks.size() * kLanes);
  changed_slots_.clear();
  changed_slots_.resize(problem.blocks.size() * kLanes);
  const auto num_slots = static_cast<mesh::TriangleId>(problem.blocks.size() * kLanes);
  for (const mesh::TriangleId slot : slots) {
    if (slot < num_slots) changed_slots_.insert(slot);
  }
  for (const mesh::VertexId v : vertices) {
    for (const mesh::TriangleId slot : problem.incident_slots.row(v)) changed_slots_.insert(slot);
  }
  for (const mesh::TriangleId slot : changed_slots_.members()) {
    membrane_.set(static_cast<std::size_t>(slot), membrane_bound(problem, L, slot));
  }
  membrane_.update(changed_slots_.members());

  const auto num_rows = static_cast<std::size_t>(problem.bending_rows.num_rows());
  if (num_rows == 0) return;
  bending_.resize(num_rows);
  changed_rows_.clear();
  changed_rows_.resize(num_rows);
  for (const mesh::VertexId row : rows) changed_rows_.insert(row);
  for (const mesh::VertexId v : vertices) {
    changed_rows_.insert(v);
    for (const BendingEntry& entry : problem.bending_rows.row(v)) changed_rows_.insert(entry.column);
  }
  for (const mesh::VertexId row : changed_rows_.members()) {
    bending_.set(static_cast<std::size_t>(row), bending_bound(problem, row));
  }
  bending_.update(changed_rows_.members());
}

}  // namespace kerf::fem
