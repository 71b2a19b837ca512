#include "server/fem/bending_forces.h"

namespace kerf::fem {

void add_bending_forces(const RowStore<BendingEntry>& rows, const mesh::VertexField& x, mesh::VertexField& f) {
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

double bending_energy(const RowStore<BendingEntry>& rows, const mesh::VertexField& x) {
  // x.Q x / 2 = -1/4 sum_ij Q_ij |x_i - x_j|^2.
  double sum = 0.0;
  for (int i = 0; i < rows.num_rows(); ++i) {
    for (const BendingEntry& entry : rows.row(i)) sum += entry.value * (x.col(i) - x.col(entry.column)).squaredNorm();
  }
  return -0.25 * sum;
}

void add_clamp_forces(const ClampForces& clamps, mesh::VertexField& f) {
  for (const ClampForces::Force& each : clamps.forces) f.col(each.vertex) += each.force;
}

double clamp_energy(const ClampForces& clamps, const mesh::VertexField& x) {
  double energy = clamps.energy;
  for (const ClampForces::Force& each : clamps.forces) energy -= each.force.dot(x.col(each.vertex));
  return energy;
}

}  // namespace kerf::fem
