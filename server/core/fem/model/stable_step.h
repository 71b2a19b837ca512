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
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// The largest of many values, kept while some of them change: a tree of group maxima.
class RunningMaximum {
 public:
  [[nodiscard]] double value() const {
    return levels_.empty() || levels_.back().empty() ? 0.0 : levels_.back().front();
  }
  [[nodiscard]] double value(std::size_t i) const { return levels_.front()[i]; }
  // New values are 0; values beyond are dropped.
  void resize(std::size_t size);
  void set(std::size_t i, double value) { levels_.front()[i] = value; }
  // After set() of each of `changed`.
  void update(std::span<const std::int32_t> changed);

 private:
  static constexpr std::size_t kGroup = 16;
  std::vector<std::vector<double>>
      levels_;  // the values, maxima of kGroup of them, of kGroup of those ..., the largest
};

// What the bound is of.
struct StiffnessProblem {
  std::span<const ElementBlock> blocks;
  const RowStore<mesh::TriangleId>& incident_slots;
  const RowStore<BendingEntry>& bending_rows;  // without rows where there is no bending
  const MaterialTable& materials;
  std::span<const double> inverse_mass;  // 1/kg, length V
  bool is_curved = false;                // the rest shape; see TriangleMesh::is_curved
};

// Absolute values of a block of the membrane's stiffness at rest, in rest coordinates.
struct StiffnessBlock {
  mesh::VertexId column = mesh::kNone;
  double xx = 0.0, xy = 0.0, yx = 0.0, yy = 0.0;  // N/m
};

// Upper bound of the largest eigenvalue of M^-1 K at rest, 1/s^2, membrane and bending, kept up to date through edits.
// Two parts, added:
//   Membrane: no eigenvalue is larger than that of the matrix of absolute values, |A|, and that of any matrix without
//   negative entries is at most max_i (|A| z)_i / z_i, for any z > 0 (Collatz 1942, "Einschliessungssatz fuer die
//   charakteristischen Zahlen von Matrizen"). Of M^-1 K that is close: the fastest mode moves neighbours against each
//   other, along the signs of K. z begins as the diagonal of M^-1/2 K M^-1 and is multiplied by |M^-1 K| kPasses times,
//   so that it comes near the eigenvector where that matters, and depends on so many rings of neighbours only.
//   Between triangles of a curved rest shape, which have no plane in common, norms of their blocks are summed.
//   Bending: largest absolute row sum of M^-1/2 Q M^-1/2 (Gershgorin).
// The membrane part holds at rest. Of the co-rotational law, folds lower the largest eigenvalue, by up to 5 % where the
// sheet is crumpled, and strains of 100 % raise it by some 20 %: what the safety factor of the explicit integrator
// (IntegratorOptions::cfl) is for, and its substeps_stretched(). For Green's strain see GreenStretch.
class StiffnessBound {
 public:
  static constexpr std::size_t kPasses = 2;

  [[nodiscard]] double value() const { return membrane_.value() + bending(); }
  [[nodiscard]] double bending() const { return bending_.value(); }

  // After a change of the triangles around `touched`, of the masses of `weighed`, and of these rows of bending;
  // vertices that the problem no longer has are dropped.
  void update(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
              std::span<const mesh::VertexId> weighed, std::span<const mesh::VertexId> rows);

 private:
  using Pair = std::array<double, 2>;  // of the components in the plane

  void update_membrane(const StiffnessProblem& problem, std::span<const mesh::VertexId> touched,
                       std::span<const mesh::VertexId> weighed);
  void set_row(const StiffnessProblem& problem, mesh::VertexId vertex);
  StiffnessBlock& block_of_row(mesh::VertexId column);
  void add_neighbours_of_changed();
  [[nodiscard]] Pair product(const StiffnessProblem& problem, mesh::VertexId row, const std::vector<Pair>& z) const;
  void update_bending(const StiffnessProblem& problem, std::span<const mesh::VertexId> weighed,
                      std::span<const mesh::VertexId> rows);

  RowStore<StiffnessBlock> rows_;                 // the vertex itself among them; empty without material
  std::array<std::vector<Pair>, kPasses + 1> z_;  // 1/(s^2 sqrt(kg)), times 1/s^2 a pass, length V
  std::vector<double> roots_;                     // 1/sqrt(kg), length V, of the inverse masses; empty without bending
  RunningMaximum membrane_;                       // of the vertices
  RunningMaximum bending_;                        // of the rows
  // Scratch.
  std::vector<StiffnessBlock> row_;
  IdSet changed_;
  IdSet changed_rows_;
};

}  // namespace kerf::fem
