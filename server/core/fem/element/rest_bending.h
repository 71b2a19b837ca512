#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

inline constexpr double kLeastArea = 0.05;  // -; see RestBending

// What a rest shape that is curved adds to a bending patch. The conditions w = W x of the quadratic fit are compared
// with those of the rest shape, w0, turned along with the triangle:
//   E = 1/2 (w - F w0).G (w - F w0) = 1/2 x.Q x - sum_i x_i . F load_i + energy,   Q = W^T G W, load = W^T G w0,
// F = (t1, t2, n): the triangle's unit first edge, n x t1 and its unit normal. At rest E and its gradient are 0; both
// are invariant under rotation, F being a function of the corners alone, whose spin is in the forces: exactly, but for
// triangles that have collapsed to less than kLeastArea of their area, whose spin is taken as if they had that.
struct RestBending {
  bool is_bent = false;                               // false: what follows is 0
  std::array<Eigen::Vector3d, 6> load{};              // N, in the frame F, of the patch's vertices
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // J, in F: sum_rs G_rs ((w0_r.w0_s) 1 - w0_s w0_r^T)
  double energy = 0.0;                                // J
  double doubled_area = 0.0;                          // m^2, of the triangle at rest
  // N/m, upper triangle by rows as in BendingPatch: norms of the 3x3 blocks of the stiffness at rest less those of Q.
  std::array<double, 21> excess{};

  [[nodiscard]] double excess_at(int a, int b) const {
    return excess[BendingPatch::kPlace[static_cast<std::size_t>(6 * a + b)]];
  }
};

// All patches of a sheet, the blocks that have their materials, and what they have at rest: the latter empty where the
// rest shape is flat.
struct RestBendingPatches {
  std::span<const ElementBlock> blocks;
  std::span<const BendingPatch> patches;
  std::span<const RestBending> rest;
};

// corners, opposite: positions on the rest surface, m; the fit as of fit_bending.
RestBending make_rest_bending(const std::array<Eigen::Vector3d, 6>& surface, const BendingFit& fit);

// f (3 x V, N) += what is to be added to add_bending_forces(rows, x + beta v, f). x: m; v: m/s; beta: see
// damping_of. Damping acts on the rate of w - F w0, so that a curved sheet turns freely.
void add_rest_bending_forces(const RestBendingPatches& sheet, const mesh::VertexField& x, const mesh::VertexField& v,
                             std::span<const double> beta, mesh::VertexField& f);

// J; to be added to bending_energy.
double rest_bending_energy(const RestBendingPatches& sheet, const mesh::VertexField& x);

}  // namespace kerf::fem
