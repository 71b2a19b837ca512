#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/rest_bending.h"
#include "server/core/fem/model/bending_row_assembly.h"
#include "server/core/fem/model/border_clamps.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

class AngleBending;

// The bending stiffness of a sheet. A quadratic patch of each triangle and its up to three neighbours has the energy W
// = A/2 kappa.D kappa (see bending.h); moments do work on the kinks between patches (see bending_edge.h). On a curved
// rest shape the patch is unfolded along its edges, and kappa is measured from the rest curvature (see rest_bending.h).
// Curved rest shapes have no terms for kinks. For equilibria and vibrations see bend_by_angles(). A patch has the plate
// law of its own triangle. All members are empty if no material bends.
class BendingOperator {
 public:
  // Makes room for the patches of `num_slots` slots.
  void reserve(std::size_t num_slots) { patches_.reserve(num_slots); }
  // Makes room for the entries that the next edits add.
  void make_room();

  // Recomputes what depends on the slots `rewritten`, which are sorted and unique. Must be called after
  // RestElements::follow() for the same edit.
  void follow(const RestSheet& sheet, std::span<const mesh::TriangleId> rewritten);
  // Replaces the clamps. Returns true if rows of Q may have changed. Does nothing if no material bends or the rest
  // shape is curved.
  bool set_clamps(const RestSheet& sheet, BorderClamps clamps);

  // Switches forces and energies to those of angles (see angle_bending.h), for equilibria and vibrations. The switch
  // lasts until the next follow(), set_clamps() or bend_by_matrix(). Damping, rows() and bound_rows() stay those of Q.
  // Does nothing on a curved rest shape or without bending. O(V). The hash does not include it.
  void bend_by_angles(const RestSheet& sheet);
  void bend_by_matrix() { angles_.reset(); }
  // Null if bending uses Q.
  [[nodiscard]] const AngleBending* angles() const { return angles_.get(); }

  // Terms of the energy at edges, one row a slot. A row has the edges of its slot to neighbours with higher slots.
  [[nodiscard]] const linear::RowStore<BendingEdge>& edges() const { return edges_; }
  // Q in N/m, one row a vertex: the force on vertex i is -sum_j Q_ij x_j, unless bend_by_angles() is active.
  [[nodiscard]] const linear::RowStore<BendingEntry>& rows() const { return rows_; }
  // N/m; entries whose absolute values bound those of the bending stiffness. They are Q itself, or on a curved rest
  // shape |Q| plus RestBending::excess.
  [[nodiscard]] const linear::RowStore<BendingEntry>& bound_rows() const { return rest_.empty() ? rows_ : bound_rows_; }
  [[nodiscard]] const BorderClamps& clamps() const { return clamps_; }
  // Forces and energy that clamps add to those of Q.
  [[nodiscard]] const ClampForces& clamp_forces() const { return clamp_forces_; }
  // `blocks` are those of the elements. The rest terms are empty for a flat rest shape.
  [[nodiscard]] BendingTerms terms(std::span<const ElementBlock> blocks) const { return {blocks, patches_, edges_}; }
  [[nodiscard]] RestBendingPatches rest(std::span<const ElementBlock> blocks) const {
    return {blocks, patches_, rest_};
  }
  // Vertices whose row may have changed columns or entries since the last follow() or set_clamps(); unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_rows() const { return changed_rows_.members(); }

  // Adds to f (3 x V, N) the bending forces at x (3 x V, m), without damping. `blocks` are those of the elements.
  void add_forces(std::span<const ElementBlock> blocks, const linear::VertexField& x, linear::VertexField& f) const;
  // Adds to f (3 x V, N) the bending forces at x (3 x V, m) and v (3 x V, m/s). They include those of clamps and of a
  // curved rest shape. Kelvin-Voigt damping makes the stresses D (kappa + beta dkappa/dt). For beta see damping_of;
  // `damped` (3 x V) is scratch.
  void add_forces(std::span<const ElementBlock> blocks, const linear::VertexField& x, const linear::VertexField& v,
                  std::span<const double> beta, linear::VertexField& damped, linear::VertexField& f) const;
  [[nodiscard]] double energy(std::span<const ElementBlock> blocks, const linear::VertexField& x) const;  // J

  void add_to(StateHash& hash) const;

 private:
  void resize(const RestSheet& sheet);
  // Marks rows of Q to be summed again; vertices that the sheet no longer has are left out.
  void mark_rows(std::span<const mesh::VertexId> vertices);
  // Rebuilds the patches of these slots and their neighbours, and the rows of Q that they are or were in.
  void make_patches(const RestSheet& sheet, std::span<const mesh::TriangleId> slots);
  // Computes the stiffness of the patches in patched_, the sides of the patches in fitted_, and the terms of a curved
  // rest shape.
  void fit_patches(const RestSheet& sheet);
  // Rebuilds the edge terms of the slots in patched_, and marks the rows that they are or were in.
  void make_edges(const RestSheet& sheet);
  // Makes the term of the edge opposite corner k of `slot`, with `other` across it. Returns true if the edge needs one.
  bool make_edge(const RestSheet& sheet, mesh::TriangleId slot, mesh::TriangleId other, int k, BendingEdge& edge);

  std::vector<BendingPatch> patches_;  // one a slot
  linear::RowStore<BendingEdge> edges_;
  linear::RowStore<BendingEntry> rows_;
  BorderClamps clamps_;
  ClampForces clamp_forces_;
  std::shared_ptr<const AngleBending> angles_;
  // For a curved rest shape only; empty otherwise.
  std::vector<RestBending> rest_;              // one a slot
  linear::RowStore<BendingEntry> bound_rows_;  // sums of |Q_ij| + RestBending::excess
  linear::IdSet changed_rows_;                 // vertices whose row of Q is summed again

  // Scratch of follow().
  linear::IdSet patched_;                          // slots whose patch is rebuilt
  linear::IdSet edged_;                            // slots whose row of edges_ is rebuilt
  linear::IndexSet fitted_;                        // slots whose patch is fitted: those of patched_, and their
                                                   // neighbours, whose sides the edge terms need
  std::vector<std::array<BendingSide, 3>> sides_;  // by place in fitted_, for a flat rest shape
  std::vector<BendingEdge> edge_row_;              // of one slot
  BendingRowAssembly assembly_;
};

}  // namespace kerf::fem
