#include "server/core/fem/model/stable_step.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "server/base/interruption.h"

namespace kerf::fem {
namespace {

// Constants of one triangle, in rest coordinates.
struct Corners {
  std::array<mesh::VertexId, 3> vertex{};
  std::array<Eigen::Matrix<double, 3, 2>, 3> strain;  // 1/m, strain per displacement of each corner; in material axes
  const MaterialLaw* law = nullptr;
  double area = 0.0;  // m^2
};

Corners corners_of(const StiffnessProblem& problem, mesh::TriangleId slot) {
  const ElementBlock& block = problem.blocks[static_cast<std::size_t>(slot / kLanes)];
  const auto l = static_cast<std::size_t>(slot % kLanes);
  Corners corners;
  corners.area = block.area[l];
  corners.law = &problem.materials.of(block, l);
  const std::array<double, 3> gx{-block.g1[0][l] - block.g2[0][l], block.g1[0][l], block.g2[0][l]};
  const std::array<double, 3> gy{-block.g1[1][l] - block.g2[1][l], block.g1[1][l], block.g2[1][l]};
  for (std::size_t k = 0; k < 3; ++k) {
    corners.vertex[k] = block.vertex[k][l];
    corners.strain[k] << gx[k], 0.0, 0.0, gy[k], gy[k], gx[k];
    // If all triangles have one material, its axes serve for all and no rows are turned.
    if (!problem.materials.has_one()) corners.strain[k] *= corners.law->axes;
  }
  return corners;
}

// Returns the larger singular value of a 2x2 matrix.
double spectral_norm(const Eigen::Matrix2d& A) {
  const double half_squares = 0.5 * A.squaredNorm();
  const double determinant = A.determinant();
  const double difference = std::max(0.0, (half_squares - determinant) * (half_squares + determinant));
  return std::sqrt(half_squares + std::sqrt(difference));
}

// Returns the absolute row sum of the scaled bending matrix. roots: 1/sqrt(kg), square roots of the inverse masses.
double bending_bound(const StiffnessProblem& problem, std::span<const double> roots, mesh::VertexId row) {
  double sum = 0.0;
  for (const BendingEntry& entry : problem.bending_rows.row(row)) {
    sum += std::abs(entry.value) * roots[static_cast<std::size_t>(entry.column)];
  }
  return sum * roots[static_cast<std::size_t>(row)];
}

}  // namespace

void StiffnessBound::update(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
                            std::span<const mesh::VertexId> weighed, std::span<const mesh::VertexId> rows) {
  update_membrane(problem, touched, weighed);
  update_bending(problem, weighed, rows);
}

void StiffnessBound::update_membrane(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
                                     std::span<const mesh::VertexId> weighed) {
  const std::size_t num_vertices = problem.inverse_mass.size();
  rows_.resize(static_cast<int>(num_vertices));
  for (std::vector<Pair>& z : z_) z.resize(num_vertices);
  membrane_.resize(num_vertices);
  changed_.clear();
  changed_.resize(num_vertices);
  for (const mesh::VertexId v : weighed) changed_.insert(v);
  for (const mesh::VertexId v : touched) {
    changed_.insert(v);
    set_row(problem, v);
  }
  for (const mesh::VertexId v : changed_.members()) {
    interruption_point();
    const double inverse_mass = problem.inverse_mass[static_cast<std::size_t>(v)];
    const double scale = inverse_mass * std::sqrt(inverse_mass);
    Pair& first = z_.front()[static_cast<std::size_t>(v)];
    first = {};
    for (const StiffnessBlock& block : rows_.row(v)) {
      if (block.column == v) first = {scale * block.xx, scale * block.yy};
    }
  }
  for (std::size_t pass = 0; pass < kPasses; ++pass) {
    add_neighbours_of_changed();
    for (const mesh::VertexId v : changed_.members()) {
      z_[pass + 1][static_cast<std::size_t>(v)] = product(problem, v, z_[pass]);
    }
  }
  add_neighbours_of_changed();
  for (const mesh::VertexId v : changed_.members()) {
    const Pair& z = z_.back()[static_cast<std::size_t>(v)];
    const Pair next = product(problem, v, z_.back());
    const bool has_material = z[0] > 0.0 && z[1] > 0.0;
    membrane_.set(static_cast<std::size_t>(v), has_material ? std::max(next[0] / z[0], next[1] / z[1]) : 0.0);
  }
  membrane_.update(changed_.members());
}

void StiffnessBound::set_row(const StiffnessProblem& problem, mesh::VertexId vertex) {
  row_.clear();
  for (const mesh::TriangleId slot : problem.incident_slots.row(vertex)) {
    const Corners corners = corners_of(problem, slot);
    const std::size_t own = (corners.vertex[1] == vertex ? 1U : 0U) + (corners.vertex[2] == vertex ? 2U : 0U);
    const Eigen::Matrix<double, 2, 3> stress = corners.area * corners.strain[own].transpose() * corners.law->membrane;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Matrix2d K = stress * corners.strain[k];
      StiffnessBlock& block = block_of_row(corners.vertex[k]);
      if (problem.is_curved) {
        const double norm = spectral_norm(K);
        block.xx += norm;
        block.yy += norm;
      } else {
        block.xx += K(0, 0);
        block.xy += K(0, 1);
        block.yx += K(1, 0);
        block.yy += K(1, 1);
      }
    }
  }
  for (StiffnessBlock& block : row_) {
    for (double* entry : {&block.xx, &block.xy, &block.yx, &block.yy}) *entry = std::abs(*entry);
  }
  rows_.set_row(vertex, row_);
}

StiffnessBlock& StiffnessBound::block_of_row(mesh::VertexId column) {
  for (StiffnessBlock& block : row_) {
    if (block.column == column) return block;
  }
  row_.emplace_back().column = column;
  return row_.back();
}

void StiffnessBound::add_neighbours_of_changed() {
  const std::size_t size = changed_.size();
  for (std::size_t i = 0; i < size; ++i) {
    for (const StiffnessBlock& block : rows_.row(changed_.members()[i])) changed_.insert(block.column);
  }
}

StiffnessBound::Pair StiffnessBound::product(const StiffnessProblem& problem, mesh::VertexId row,
                                             const std::vector<Pair>& z) const {
  const double inverse_mass = problem.inverse_mass[static_cast<std::size_t>(row)];
  double x = 0.0, y = 0.0;
  for (const StiffnessBlock& block : rows_.row(row)) {
    const Pair& at = z[static_cast<std::size_t>(block.column)];
    x += block.xx * at[0] + block.xy * at[1];
    y += block.yx * at[0] + block.yy * at[1];
  }
  return {inverse_mass * x, inverse_mass * y};
}

void StiffnessBound::update_bending(const StiffnessProblem& problem, std::span<const mesh::VertexId> weighed,
                                    std::span<const mesh::VertexId> rows) {
  const auto num_rows = static_cast<std::size_t>(problem.bending_rows.num_rows());
  if (num_rows == 0) return;
  bending_.resize(num_rows);
  changed_rows_.clear();
  changed_rows_.resize(num_rows);
  roots_.resize(num_rows, 0.0);
  for (const mesh::VertexId row : rows) changed_rows_.insert(row);
  for (const mesh::VertexId v : weighed) {
    changed_rows_.insert(v);
    roots_[static_cast<std::size_t>(v)] = std::sqrt(problem.inverse_mass[static_cast<std::size_t>(v)]);
    for (const BendingEntry& entry : problem.bending_rows.row(v)) changed_rows_.insert(entry.column);
  }
  for (const mesh::VertexId row : changed_rows_.members()) {
    interruption_point();
    bending_.set(static_cast<std::size_t>(row), bending_bound(problem, roots_, row));
  }
  bending_.update(changed_rows_.members());
}

}  // namespace kerf::fem
