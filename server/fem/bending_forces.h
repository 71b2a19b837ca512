#pragma once

#include <Eigen/Core>

#include "server/fem/bending.h"
#include "server/fem/row_store.h"
#include "server/mesh/vertex_field.h"

namespace kerf::fem {

// f (3 x V, N) += -Q x for x (3 x V, m), as f_i = sum_j Q_ij (x_i - x_j): equal since the rows of Q sum to zero, but
// exactly invariant under translation and, pair by pair, exactly without resultant force. For damping beta pass
// x + beta v: the rate of the curvature as a vector, so that, unlike membrane damping, it also brakes the rotation of a
// sheet that is bent. Rows in order.
void add_bending_forces(const RowStore<BendingEntry>& rows, const mesh::VertexField& x, mesh::VertexField& f);

// J.
double bending_energy(const RowStore<BendingEntry>& rows, const mesh::VertexField& x);

}  // namespace kerf::fem
