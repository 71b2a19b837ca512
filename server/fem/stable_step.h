#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/fem/bending.h"
#include "server/fem/element_block.h"
#include "server/fem/index_set.h"
#include "server/fem/material_table.h"
#include "server/fem/row_store.h"
#include "server/mesh/ids.h"

namespace kerf::fem {

// The largest of many values, kept while some of them change: a tree of group maxima.
class RunningMaximum {
 public:
  [[nodiscard]] double value() const {
    return levels_.empty() || levels_.back().empty() ? 0.0 : levels_.back().front();
  }
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
  std::span<const double> stiffness;     // N/m, length V; corner_stiffness summed around each vertex
  std::span<const double> inverse_mass;  // 1/kg, length V
};

// Upper bound of the largest eigenvalue of M^-1 K at rest, 1/s^2, membrane and bending, kept up to date through edits.
// Two parts, added:
//   Membrane: lambda_max(M^-1 K) <= max_e lambda_max(M_e^-1 K_e) for any split of the lumped masses among the triangles
//   around each vertex (Fried 1972, "Bounds on the extremal eigenvalues of the finite element stiffness and mass
//   matrices"). The mass is split in proportion to the triangles' stiffness at the vertex, so that a sliver borrows
//   mass from its neighbours, and then once more in proportion to that times the bound that comes of it, which evens
//   the triangles' bounds out; the eigenvalue of the 3x3 matrix H that remains is bounded by (tr H^8)^(1/8).
//   Bending: largest absolute row sum of M^-1/2 Q M^-1/2 (Gershgorin).
// The membrane part holds at rest; tension and folding raise it only moderately for the co-rotational law, which is
// what the safety factor of the explicit integrator (IntegratorOptions::cfl) is for. For Green's strain see
// GreenStretch.
class StiffnessBound {
 public:
  [[nodiscard]] double value() const { return membrane_.value() + bending(); }
  [[nodiscard]] double bending() const { return bending_.value(); }

  // After a change of these slots, of mass or stiffness at these vertices, and of these rows; those that the problem no
  // longer has are dropped.
  void update(const StiffnessProblem& problem, std::span<const mesh::TriangleId> slots,
              std::span<const mesh::VertexId> vertices, std::span<const mesh::VertexId> rows);

 private:
  void update_membrane(const StiffnessProblem& problem, std::span<const mesh::TriangleId> slots,
                       std::span<const mesh::VertexId> vertices);
  void update_bending(const StiffnessProblem& problem, std::span<const mesh::VertexId> vertices,
                      std::span<const mesh::VertexId> rows);

  // N/m/s^2, of the corners of the slots: stiffness times the bound that comes of masses split by stiffness alone. Not
  // set where there is no material.
  std::vector<std::array<double, 3>> weight_parts_;
  std::vector<double> weights_;  // N/m/s^2, length V; sums of the parts around each vertex
  std::vector<double> roots_;    // 1/sqrt(kg), length V, of the inverse masses; empty without bending
  RunningMaximum membrane_;      // of the slots
  RunningMaximum bending_;       // of the rows
  // Scratch.
  IdSet changed_slots_;
  IdSet changed_vertices_;
  IdSet changed_rows_;
};

}  // namespace kerf::fem
