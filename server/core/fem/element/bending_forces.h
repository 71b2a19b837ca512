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

// The derivative of positions by the material coordinates (rest axes, not those of the material) that a clamp holds at
// a vertex.
struct Clamp {
  mesh::VertexId vertex = mesh::kNone;
  Eigen::Matrix<double, 3, 2> gradient = Eigen::Matrix<double, 3, 2>::Zero();  // -
};

// With clamped edges E = 1/2 x.Q x - sum over `forces` of x.force + energy.
struct ClampForces {
  struct Force {
    mesh::VertexId vertex = mesh::kNone;              // may repeat
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N
  };
  std::vector<Force> forces;
  double energy = 0.0;  // J
};

// f (3 x V, N) += what is to be added to add_bending_forces.
void add_clamp_forces(const ClampForces& clamps, mesh::VertexField& f);
// J; to be added to bending_energy.
double clamp_energy(const ClampForces& clamps, const mesh::VertexField& x);

// f (3 x V, N) += -Q x for x (3 x V, m), as f_i = sum_j Q_ij (x_i - x_j): equal since the rows of Q sum to zero, but
// exactly invariant under translation and, pair by pair, exactly without resultant force. For damping beta pass
// x + beta v: the rate of the curvature as a vector, so that, unlike membrane damping, it also brakes the rotation of a
// sheet that is bent. Rows in order.
void add_bending_forces(const RowStore<BendingEntry>& rows, const mesh::VertexField& x, mesh::VertexField& f);

// The terms that Q is the sum of, by slot.
struct BendingTerms {
  std::span<const ElementBlock> blocks;  // have the materials of the patches
  std::span<const BendingPatch> patches;
  const RowStore<BendingEdge>& edges;
};

// For damping that is not the same everywhere: f (3 x V, N) += -sum over the terms of beta Q_term v. Between two
// materials an edge has the smaller beta of both: with a larger one than that of a patch beside it the sum might gain
// energy (see kKinkPenalty). beta: see damping_of. Slots in order.
void add_bending_damping(const BendingTerms& terms, std::span<const double> beta, const mesh::VertexField& v,
                         mesh::VertexField& f);
// s, of an edge.
double edge_damping(std::span<const double> beta, const BendingEdge& edge);

// J.
double bending_energy(const RowStore<BendingEntry>& rows, const mesh::VertexField& x);

}  // namespace kerf::fem
