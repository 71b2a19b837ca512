#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/model/running_maximum.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// Data that StiffnessBound depends on.
struct StiffnessProblem {
  std::span<const ElementBlock> blocks;
  const linear::RowStore<mesh::TriangleId>& incident_slots;
  const linear::RowStore<BendingEntry>& bending_rows;  // BendingOperator::bound_rows(); no rows without bending
  const MaterialTable& materials;
  std::span<const double> inverse_mass;  // 1/kg, length V
  bool is_curved = false;                // true for a curved rest shape; see TriangleMesh::is_curved
};

// Absolute values of a 2x2 block of the membrane's stiffness at rest, in rest coordinates.
struct StiffnessBlock {
  mesh::VertexId column = mesh::kNone;
  double xx = 0.0, xy = 0.0, yx = 0.0, yy = 0.0;  // N/m
};

// Upper bound of the largest eigenvalue of M^-1 K at rest, 1/s^2, membrane and bending, kept up to date through edits.
// It is the sum of two parts:
//   Membrane: no eigenvalue of A = M^-1 K is larger than the largest of |A|, the matrix of absolute values. A matrix
//     without negative entries has none above max_i (|A| z)_i / z_i, for any z > 0 (Collatz 1942, "Einschliessungssatz
//     fuer die charakteristischen Zahlen von Matrizen"). The bound is tight for this A: the fastest mode moves
//     neighbours against each other, along the signs of K. z begins as the diagonal of M^-1/2 K M^-1 and is multiplied
//     by |A| kPasses times. It thus comes near the eigenvector where that matters. The bound of a row depends on
//     1 + kPasses rings of neighbours only. Triangles of a curved rest shape have no plane in common; norms of their
//     blocks are summed.
//   Bending: largest absolute row sum of M^-1/2 Q M^-1/2 (Gershgorin).
// The membrane part holds at rest. With the co-rotational law, folds lower the largest eigenvalue by up to 5 % where
// the sheet is crumpled. Strains of 100 % raise it by some 20 %. The explicit integrator covers this by its safety
// factor (IntegratorOptions::cfl) and by ExplicitIntegrator::substeps_stretched(). For Green's strain see GreenStretch.
class StiffnessBound {
 public:
  static constexpr std::size_t kPasses = 2;

  [[nodiscard]] double value() const { return membrane_.value() + bending(); }
  [[nodiscard]] double bending() const { return bending_.value(); }

  // Updates the bound after a change of the triangles around `touched`, of the masses of `weighed`, and of the bending
  // rows `rows`. Drops vertices that the problem no longer has.
  void update(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
              std::span<const mesh::VertexId> weighed, std::span<const mesh::VertexId> rows);

 private:
  using Pair = std::array<double, 2>;  // in-plane components

  void update_membrane(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
                       std::span<const mesh::VertexId> weighed);
  void set_row(const StiffnessProblem& problem, mesh::VertexId vertex);
  StiffnessBlock& block_of_row(mesh::VertexId column);
  void add_neighbours_of_changed();
  [[nodiscard]] Pair product(const StiffnessProblem& problem, mesh::VertexId row, const std::vector<Pair>& z) const;
  void update_bending(const StiffnessProblem& problem, std::span<const mesh::VertexId> weighed,
                      std::span<const mesh::VertexId> rows);

  linear::RowStore<StiffnessBlock> rows_;         // one row a vertex, with a block for itself; empty without material
  std::array<std::vector<Pair>, kPasses + 1> z_;  // z after each pass: 1/(s^2 sqrt(kg)), times 1/s^2 a pass, length V
  std::vector<double> roots_;                     // 1/sqrt(kg), length V, square roots of the inverse masses; empty
                                                  // without bending
  RunningMaximum membrane_;                       // 1/s^2, bound of the membrane by vertex
  RunningMaximum bending_;                        // 1/s^2, bound of bending by row
  // Scratch.
  std::vector<StiffnessBlock> row_;
  linear::IdSet changed_;
  linear::IdSet changed_rows_;
};

}  // namespace kerf::fem
