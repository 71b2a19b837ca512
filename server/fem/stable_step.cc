#include "server/fem/stable_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "server/fem/mass_redistribution.h"

namespace kerf::fem {
namespace {

// >= the largest eigenvalue of a 3x3 matrix with real eigenvalues that are not negative, by at most 15 %: (tr
// M^8)^(1/8), from the elementary symmetric functions of the eigenvalues, which go over into those of their squares
// (Graeffe 1837).
double largest_eigenvalue_bound(double trace, double minors, double determinant) {
  if (!(trace > 0.0)) return 0.0;
  double e1 = 1.0;
  double e2 = minors / (trace * trace);
  double e3 = determinant / (trace * trace * trace);
  for (int squaring = 0; squaring < 3; ++squaring) {
    const double next_e2 = e2 * e2 - 2.0 * e1 * e3;
    e1 = e1 * e1 - 2.0 * e2;
    e2 = next_e2;
    e3 = e3 * e3;
  }
  return trace * std::sqrt(std::sqrt(std::sqrt(e1)));
}

// Of one triangle.
struct Corners {
  std::array<mesh::VertexId, 3> vertex{};
  std::array<double, 3> gx{}, gy{};  // 1/m
  double area = 0.0;                 // m^2; 0: no material, the rest is not set
  const MaterialLaw* law = nullptr;
  std::size_t material = 0;
};

Corners corners_of(const StiffnessProblem& problem, mesh::TriangleId slot) {
  const ElementBlock& block = problem.blocks[static_cast<std::size_t>(slot / kLanes)];
  const auto l = static_cast<std::size_t>(slot % kLanes);
  Corners corners;
  corners.area = block.area[l];
  if (corners.area == 0.0) return corners;
  corners.law = &problem.materials.of(block, l);
  corners.material = block.material[l];
  corners.gx = {-block.g1[0][l] - block.g2[0][l], block.g1[0][l], block.g2[0][l]};
  corners.gy = {-block.g1[1][l] - block.g2[1][l], block.g1[1][l], block.g2[1][l]};
  for (std::size_t k = 0; k < 3; ++k) corners.vertex[k] = block.vertex[k][l];
  return corners;
}

// Which corner of a slot the vertex is.
std::size_t corner_at(const StiffnessProblem& problem, mesh::TriangleId slot, mesh::VertexId vertex) {
  const ElementBlock& block = problem.blocks[static_cast<std::size_t>(slot / kLanes)];
  const auto l = static_cast<std::size_t>(slot % kLanes);
  return (block.vertex[1][l] == vertex ? 1U : 0U) + (block.vertex[2][l] == vertex ? 2U : 0U);
}

// Where corner k has the part own[k] of all[vertex[k]] of its vertex' mass.
double membrane_bound(const StiffnessProblem& problem, std::span<const double> law_determinants, const Corners& corners,
                      const std::array<double, 3>& own, std::span<const double> all) {
  // G = sum over corners of A B B^T / (mass share), with strain-displacement matrices B, rows (gx, 0), (0, gy), (gy,
  // gx): {xx, 0, xy}, {0, yy, xy}, {xy, xy, xx + yy}.
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto v = static_cast<std::size_t>(corners.vertex[k]);
    const double weight = corners.area * all[v] * problem.inverse_mass[v] / own[k];
    xx += weight * corners.gx[k] * corners.gx[k];
    xy += weight * corners.gx[k] * corners.gy[k];
    yy += weight * corners.gy[k] * corners.gy[k];
  }
  const Eigen::Matrix3d G{
      {xx, 0.0, xy},
      {0.0, yy, xy},
      {xy, xy, xx + yy},
  };
  const Eigen::Matrix3d H = corners.law->membrane * G;  // its eigenvalues are those of L^T G L, L L^T the law
  const double minors = H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0) + H(0, 0) * H(2, 2) - H(0, 2) * H(2, 0) +
                        H(1, 1) * H(2, 2) - H(1, 2) * H(2, 1);
  return largest_eigenvalue_bound(H.trace(), minors,
                                  law_determinants[corners.material] * (xx + yy) * (xx * yy - xy * xy));
}

// roots: 1/sqrt(kg), of the inverse masses.
double bending_bound(const StiffnessProblem& problem, std::span<const double> roots, mesh::VertexId row) {
  double sum = 0.0;
  for (const BendingEntry& entry : problem.bending_rows.row(row)) {
    sum += std::abs(entry.value) * roots[static_cast<std::size_t>(entry.column)];
  }
  return sum * roots[static_cast<std::size_t>(row)];
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
  update_membrane(problem, slots, vertices);
  update_bending(problem, vertices, rows);
}

void StiffnessBound::update_membrane(const StiffnessProblem& problem, std::span<const mesh::TriangleId> slots,
                                     std::span<const mesh::VertexId> vertices) {
  std::array<double, kMaxMaterials> law_determinants{};
  for (std::size_t i = 0; i < problem.materials.size(); ++i) {
    law_determinants[i] = problem.materials[i].membrane.determinant();
  }
  const std::size_t num_slots = problem.blocks.size() * kLanes;
  weight_parts_.resize(num_slots);
  weights_.resize(problem.stiffness.size(), 0.0);
  membrane_.resize(num_slots);
  changed_slots_.clear();
  changed_slots_.resize(num_slots);
  changed_vertices_.clear();
  changed_vertices_.resize(weights_.size());
  for (const mesh::TriangleId slot : slots) {
    if (static_cast<std::size_t>(slot) < num_slots) changed_slots_.insert(slot);
  }
  for (const mesh::VertexId v : vertices) {
    changed_vertices_.insert(v);
    for (const mesh::TriangleId slot : problem.incident_slots.row(v)) changed_slots_.insert(slot);
  }
  for (const mesh::TriangleId slot : changed_slots_.members()) {
    const Corners corners = corners_of(problem, slot);
    if (corners.area == 0.0) continue;
    std::array<double, 3> stiffness{};
    for (std::size_t k = 0; k < 3; ++k) {
      stiffness[k] = corner_stiffness(corners.gx[k], corners.gy[k], corners.area, corners.law->membrane);
    }
    const double bound = membrane_bound(problem, law_determinants, corners, stiffness, problem.stiffness);
    for (std::size_t k = 0; k < 3; ++k) {
      weight_parts_[static_cast<std::size_t>(slot)][k] = bound * stiffness[k];
      changed_vertices_.insert(corners.vertex[k]);
    }
  }
  for (const mesh::VertexId v : changed_vertices_.members()) {
    double weight = 0.0;
    for (const mesh::TriangleId slot : problem.incident_slots.row(v)) {
      weight += weight_parts_[static_cast<std::size_t>(slot)][corner_at(problem, slot, v)];
      changed_slots_.insert(slot);
    }
    weights_[static_cast<std::size_t>(v)] = weight;
  }
  for (const mesh::TriangleId slot : changed_slots_.members()) {
    const Corners corners = corners_of(problem, slot);
    const std::array<double, 3>& own = weight_parts_[static_cast<std::size_t>(slot)];
    const bool is_solid = corners.area != 0.0;
    membrane_.set(static_cast<std::size_t>(slot),
                  is_solid ? membrane_bound(problem, law_determinants, corners, own, weights_) : 0.0);
  }
  membrane_.update(changed_slots_.members());
}

void StiffnessBound::update_bending(const StiffnessProblem& problem, std::span<const mesh::VertexId> vertices,
                                    std::span<const mesh::VertexId> rows) {
  const auto num_rows = static_cast<std::size_t>(problem.bending_rows.num_rows());
  if (num_rows == 0) return;
  bending_.resize(num_rows);
  changed_rows_.clear();
  changed_rows_.resize(num_rows);
  roots_.resize(num_rows, 0.0);
  for (const mesh::VertexId row : rows) changed_rows_.insert(row);
  for (const mesh::VertexId v : vertices) {
    changed_rows_.insert(v);
    roots_[static_cast<std::size_t>(v)] = std::sqrt(problem.inverse_mass[static_cast<std::size_t>(v)]);
    for (const BendingEntry& entry : problem.bending_rows.row(v)) changed_rows_.insert(entry.column);
  }
  for (const mesh::VertexId row : changed_rows_.members()) {
    bending_.set(static_cast<std::size_t>(row), bending_bound(problem, roots_, row));
  }
  bending_.update(changed_rows_.members());
}

}  // namespace kerf::fem
