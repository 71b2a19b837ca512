#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

inline constexpr double kLeastArea = 0.05;  // -, of the rest area of a triangle, which counts as collapsed below it:
                                            // see RestBending

// Additional terms of a bending patch on a curved rest shape. The conditions w = W x of the fit (see BendingFit; W
// holds its conditions and G its law) are compared with those of the rest shape, w0. These turn along with the
// triangle:
//   E = 1/2 (w - F w0).G (w - F w0) = 1/2 x.Q x - sum_i x_i . F load_i + energy,   Q = W^T G W, load = W^T G w0.
// F = (t1, t2, n) holds the triangle's unit first edge, n x t1 and its unit normal. At rest E and its gradient are 0. E
// and the forces are exactly invariant under rotation, because F is a function of the corners alone and the forces
// include its spin. The exception is a triangle that has collapsed to less than kLeastArea of its area, whose spin is
// taken as at that area.
struct RestBending {
  bool is_bent = false;                   // false: all other members are 0
  std::array<Eigen::Vector3d, 6> load{};  // N, in the frame F, for the patch's vertices
  // J (joules), in the frame F, with the rows w0_r of w0: sum_rs G_rs ((w0_r.w0_s) 1 - w0_s w0_r^T).
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  double energy = 0.0;        // J
  double doubled_area = 0.0;  // m^2, twice the area of the triangle at rest
  // N/m, upper triangle by rows as in BendingPatch: norms of the 3x3 blocks of the stiffness at rest minus Q.
  std::array<double, 21> excess{};

  [[nodiscard]] double excess_at(int a, int b) const {
    return excess[BendingPatch::kPlace[static_cast<std::size_t>(6 * a + b)]];
  }
};

// All patches of a sheet, the blocks with their materials, and their rest terms, which are empty for a flat rest shape.
struct RestBendingPatches {
  std::span<const ElementBlock> blocks;
  std::span<const BendingPatch> patches;
  std::span<const RestBending> rest;
};

// Makes the rest terms of a patch. `surface` holds the places of its vertices on the rest surface, m, and `fit` is the
// result of fit_bending().
RestBending make_rest_bending(const std::array<Eigen::Vector3d, 6>& surface, const BendingFit& fit);

// Adds to f (3 x V, N) the terms that add_bending_forces(rows, x + beta v, f) lacks. x: m; v: m/s; beta: see
// damping_of. Damping acts on the rate of w - F w0, so that a curved sheet turns freely.
void add_rest_bending_forces(const RestBendingPatches& sheet, const linear::VertexField& x,
                             const linear::VertexField& v, std::span<const double> beta, linear::VertexField& f);

// Returns the energy to be added to bending_energy, J.
double rest_bending_energy(const RestBendingPatches& sheet, const linear::VertexField& x);

}  // namespace kerf::fem
