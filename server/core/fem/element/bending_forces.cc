#include "server/core/fem/element/bending_forces.h"

#include <algorithm>

#include "server/core/fem/element/material_table.h"

namespace kerf::fem {
namespace {

// Adds -scale sum_j Q_ij (v_j - v_i), which is exactly without resultant.
void add_patch_damping(const BendingPatch& patch, double scale, const linear::VertexField& v, linear::VertexField& f) {
  for (std::size_t a = 0; a < patch.vertex.size(); ++a) {
    for (std::size_t b = a + 1; b < patch.vertex.size(); ++b) {
      if (patch.vertex[a] == mesh::kNone || patch.vertex[b] == mesh::kNone) continue;
      const double entry = scale * patch.at(static_cast<int>(a), static_cast<int>(b));
      const Eigen::Vector3d pull = entry * (v.col(patch.vertex[a]) - v.col(patch.vertex[b]));
      f.col(patch.vertex[a]) += pull;
      f.col(patch.vertex[b]) -= pull;
    }
  }
}

void add_edge_damping(const BendingEdge& edge, double scale, const linear::VertexField& v, linear::VertexField& f) {
  for (std::size_t a = 0; a < edge.vertex.size(); ++a) {
    for (std::size_t b = a + 1; b < edge.vertex.size(); ++b) {
      if (edge.vertex[a] == mesh::kNone || edge.vertex[b] == mesh::kNone) continue;
      const Eigen::Vector3d pull = scale * edge.at(a, b) * (v.col(edge.vertex[a]) - v.col(edge.vertex[b]));
      f.col(edge.vertex[a]) += pull;
      f.col(edge.vertex[b]) -= pull;
    }
  }
}

}  // namespace

void add_bending_forces(const linear::RowStore<BendingEntry>& rows, const linear::VertexField& x,
                        linear::VertexField& f) {
  const double* const from = x.data();
  double* const to = f.data();
  for (int i = 0; i < rows.num_rows(); ++i) {
    const double* const xi = from + 3 * static_cast<std::ptrdiff_t>(i);
    double f0 = 0.0;
    double f1 = 0.0;
    double f2 = 0.0;
    for (const BendingEntry& entry : rows.row(i)) {
      const double* const xj = from + 3 * static_cast<std::ptrdiff_t>(entry.column);
      f0 += entry.value * (xi[0] - xj[0]);
      f1 += entry.value * (xi[1] - xj[1]);
      f2 += entry.value * (xi[2] - xj[2]);
    }
    double* const fi = to + 3 * static_cast<std::ptrdiff_t>(i);
    fi[0] += f0;
    fi[1] += f1;
    fi[2] += f2;
  }
}

double edge_damping(std::span<const double> beta, const BendingEdge& edge) {
  return std::min(damping_of(beta, edge.material[0]), damping_of(beta, edge.material[1]));
}

void add_bending_damping(const BendingTerms& terms, std::span<const double> beta, const linear::VertexField& v,
                         linear::VertexField& f) {
  for (std::size_t slot = 0; slot < terms.patches.size(); ++slot) {
    const double scale = damping_of(beta, terms.blocks[slot / kLanes].material[slot % kLanes]);
    if (scale > 0.0) add_patch_damping(terms.patches[slot], scale, v, f);
    for (const BendingEdge& edge : terms.edges.row(static_cast<int>(slot))) {
      add_edge_damping(edge, edge_damping(beta, edge), v, f);
    }
  }
}

double bending_energy(const linear::RowStore<BendingEntry>& rows, const linear::VertexField& x) {
  // x.Q x / 2 = -1/4 sum_ij Q_ij |x_i - x_j|^2.
  double sum = 0.0;
  for (int i = 0; i < rows.num_rows(); ++i) {
    for (const BendingEntry& entry : rows.row(i)) sum += entry.value * (x.col(i) - x.col(entry.column)).squaredNorm();
  }
  return -0.25 * sum;
}

void add_clamp_forces(const ClampForces& clamps, linear::VertexField& f) {
  for (const ClampForces::Force& each : clamps.forces) f.col(each.vertex) += each.force;
}

double clamp_energy(const ClampForces& clamps, const linear::VertexField& x) {
  double energy = clamps.energy;
  for (const ClampForces::Force& each : clamps.forces) energy -= each.force.dot(x.col(each.vertex));
  return energy;
}

}  // namespace kerf::fem
