#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/linear/row_store.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Clamp at a vertex: holds the derivative of the position by the material coordinates. These are along the rest axes,
// not along the fibres.
struct Clamp {
  mesh::VertexId vertex = mesh::kNone;
  Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();  // -
};

// Forces and energy of clamps: with clamped edges E = 1/2 x.Q x - sum over `forces` of x.force + energy.
struct ClampForces {
  struct Force {
    mesh::VertexId vertex = mesh::kNone;              // may repeat
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N
  };
  std::vector<Force> forces;
  double energy = 0.0;  // J
};

// Adds the clamp forces to f (3 x V, N), in addition to add_bending_forces.
void add_clamp_forces(const ClampForces& clamps, linear::VertexField& f);
// Returns the clamp energy, J, to be added to bending_energy.
double clamp_energy(const ClampForces& clamps, const linear::VertexField& x);

// Adds -Q x to f (3 x V, N), for x (3 x V, m), as f_i = sum_j Q_ij (x_i - x_j). The sum is equal to -Q x because the
// rows of Q sum to zero, and it is exactly invariant under translation. The two forces of each pair of vertices cancel
// exactly. For damping beta pass x + beta v. This damps the rate of the curvature as a vector, so unlike membrane
// damping it also slows the rotation of a bent sheet. Rows are processed in order.
void add_bending_forces(const linear::RowStore<BendingEntry>& rows, const linear::VertexField& x,
                        linear::VertexField& f);

// The terms whose sum is Q: one patch and one row of edges for each slot.
struct BendingTerms {
  std::span<const ElementBlock> blocks;  // give the materials of the patches
  std::span<const BendingPatch> patches;
  const linear::RowStore<BendingEdge>& edges;
};

// Adds the damping forces -sum over the terms of beta Q_term v to f (3 x V, N), for damping that varies. An edge
// between two materials has the smaller beta of the two. With a larger beta than a patch beside it, the edge could make
// the damping add energy (see kKinkPenalty). For beta see damping_of. Slots are processed in order.
void add_bending_damping(const BendingTerms& terms, std::span<const double> beta, const linear::VertexField& v,
                         linear::VertexField& f);
// Returns the damping time of an edge, s.
double edge_damping(std::span<const double> beta, const BendingEdge& edge);

// Returns 1/2 x.Q x, J.
double bending_energy(const linear::RowStore<BendingEntry>& rows, const linear::VertexField& x);

}  // namespace kerf::fem
