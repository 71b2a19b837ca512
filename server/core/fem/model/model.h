#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/base/phase_observer.h"
#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/element_block.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/element/material.h"
#include "server/core/fem/element/material_table.h"
#include "server/core/fem/element/rest_bending.h"
#include "server/core/fem/element/row_sum.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/mass_redistribution.h"
#include "server/core/fem/model/stable_step.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/row_store.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/mesh_edit.h"

namespace kerf::mesh {
class TriangleMesh;
}

namespace kerf::fem {

class AngleBending;

// Energies of a state, J.
struct Energies {
  double membrane = 0.0;
  double bending = 0.0;
  double gravity = 0.0;  // -sum m g.x
  double kinetic = 0.0;
  [[nodiscard]] double total() const { return membrane + bending + gravity + kinetic; }
};

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // kg m^2/s, about the world's origin
};

// Vertices whose mass an edit recomputed or changed, including added ones, with their masses before the edit.
struct MassChange {
  std::vector<mesh::VertexId> vertices;  // unique
  std::vector<double> mass_before;       // kg, same length; 0 for an added vertex
  std::vector<double> dropped;           // kg, masses of the last vertices, which were removed
  std::size_t num_examined = 0;          // vertices whose mass was recomputed, changed or not
};

// The discrete elastic sheet: constants of every triangle, lumped masses and the bending matrix. They belong to the
// rest shape of the mesh, flat or curved, and its materials.
//   Membrane: linear triangles, W = A/2 e.C e; co-rotational with e = U - I, F = R U (Biot strain), or with Green's
//             strain: see MembraneLaw.
//   Bending: quadratic patch of a triangle and its up to three neighbours, W = A/2 kappa.D kappa (see bending.h), and
//            the work of moments on the kinks between patches (see bending_edge.h). On a curved rest shape the patch is
//            unfolded along its edges, and kappa is measured from the rest curvature (see rest_bending.h). Kinks are
//            left out there. For equilibria and vibrations see bend_by_angles().
//   Mass: a third of each triangle's mass to each corner. Vertices far too light for their stiffness, as along a cut,
//         get mass from their neighbours (see mass_redistribution.h).
//   Materials: a triangle has the material with the number region(t) of the mesh. No edit moves the borders between
//         regions, so cuts keep the material at each place. A bending patch has the law of its own triangle. Mass
//         damping at a vertex is the mean over its triangles, weighted with their masses.
// A model is derived from mesh and materials alone. Two models of equal mesh and materials are equal bit for bit,
// whatever edits led to them.
class Model {
 public:
  // Uses one material for all triangles, whatever the regions of the mesh. `material` must be valid (see validate).
  Model(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law = MembraneLaw::kCorotational);
  // Takes 1..kMaxMaterials materials: at least one for each region of the mesh, or a single one for all.
  Model(const mesh::TriangleMesh& mesh, std::span<const Material> materials,
        MembraneLaw law = MembraneLaw::kCorotational);

  // Follows an edit that the mesh has already made. Recomputes only the rewritten slots, the bending patches that touch
  // them and the masses near them. The result equals a fresh model of the same materials.
  MassChange apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit);
  // Follows any number of edits, made or reverted, given the slots they rewrote. `rewritten` is sorted and unique, and
  // holds all such slots that the mesh still has. If the mesh has fewer slots and vertices than the model, the last
  // ones are dropped. `observer` may be null.
  MassChange follow(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten,
                    PhaseObserver* observer = nullptr);

  // Clamps the slope of the sheet at border edges whose two ends are both in `clamps`. `clamps` is sorted by vertex and
  // unique, and replaces earlier clamps. Affects bending only, and only flat rest shapes.
  void set_clamps(const mesh::TriangleMesh& mesh, std::vector<Clamp> clamps);

  // Switches bending forces and energies to those of angles (see angle_bending.h), for equilibria and vibrations. They
  // last until the mesh or the clamps change, or bend_by_matrix(). Damping, rows and bounds stay those of Q. Does
  // nothing on a curved rest shape or without bending. O(V). Not part of hash().
  void bend_by_angles(const mesh::TriangleMesh& mesh);
  void bend_by_matrix() { angle_bending_.reset(); }
  // Null if bending uses Q.
  [[nodiscard]] const AngleBending* angle_bending() const { return angle_bending_.get(); }

  // Returns a moment along the border edge opposite corner `edge` of a solid slot; see EdgeMoment. `moment_per_length`
  // is in N m per m of the edge at rest. It is valid until the mesh or the clamps change. A clamped edge gets none,
  // since the clamp carries it. On a curved rest shape, or without bending, the slope is that of the triangle alone.
  [[nodiscard]] EdgeMoment edge_moment(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, int edge,
                                       double moment_per_length) const;

  [[nodiscard]] int num_vertices() const { return static_cast<int>(mass_.size()); }
  [[nodiscard]] int num_slots() const { return num_slots_; }
  [[nodiscard]] const MaterialTable& materials() const { return materials_; }
  // Law of a slot; that of material 0 for a slot without material.
  [[nodiscard]] const MaterialLaw& law(mesh::TriangleId slot) const {
    return materials_.of(blocks_[static_cast<std::size_t>(slot / kLanes)], static_cast<std::size_t>(slot % kLanes));
  }

  // kg, length V; 0 for a vertex without material, which never moves.
  [[nodiscard]] std::span<const double> mass() const { return mass_; }
  // 1/kg, length V; 0 where the mass is 0.
  [[nodiscard]] std::span<const double> inverse_mass() const { return inverse_mass_; }
  [[nodiscard]] double total_mass() const;  // kg
  [[nodiscard]] double rest_area() const;   // m^2
  // m; smallest edge length (see EdgeLengths), in the sheet as built, shared by at least a tenth of the vertices.
  [[nodiscard]] double typical_edge_length() const;
  // m; longer side of the bounding box of the sheet as built, in material coordinates.
  [[nodiscard]] double built_extent() const { return built_extent_; }
  // 1/s, Rayleigh alpha at a vertex: the damping force on it is -alpha m v.
  [[nodiscard]] double mass_damping(mesh::VertexId vertex) const {
    return materials_.has_one_mass_damping() ? materials_[0].material.mass_damping
                                             : mass_damping_[static_cast<std::size_t>(vertex)];
  }

  // Returns ceil(num_slots / kLanes) blocks; lanes beyond num_slots have no material.
  [[nodiscard]] std::span<const ElementBlock> element_blocks() const { return blocks_; }
  [[nodiscard]] bool has_bending() const { return materials_.has_bending(); }
  // Terms of the bending energy at edges; one row a slot, empty without bending.
  [[nodiscard]] const RowStore<BendingEdge>& bending_edges() const { return bending_edges_; }
  // Q in N/m, one row a vertex: the bending force on vertex i is -sum_j Q_ij x_j, unless bend_by_angles() is active.
  // Rows are empty without bending.
  [[nodiscard]] const RowStore<BendingEntry>& bending_rows() const { return bending_rows_; }
  // N/m; bounds the absolute values of the rows of the bending stiffness, which are larger on a curved rest shape.
  [[nodiscard]] const RowStore<BendingEntry>& bending_bound_rows() const {
    return rest_bending_.empty() ? bending_rows_ : bound_rows_;
  }
  // Forces that clamps add to the bending force -Q x.
  [[nodiscard]] const ClampForces& clamp_forces() const { return clamp_forces_; }
  // Empty for a flat rest shape.
  [[nodiscard]] RestBendingPatches rest_bending() const { return {blocks_, patches_, rest_bending_}; }
  // Solid slots around each vertex, ascending.
  [[nodiscard]] const RowStore<mesh::TriangleId>& incident_slots() const { return incident_; }
  // Vertices whose row of the stiffness matrix may have changed columns or elements since the last apply() or follow();
  // unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_rows() const {
    return has_bending() ? rows_.members() : touched_.members();
  }
  // Vertices whose mass the last apply() or follow() recomputed; unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_masses() const { return changed_masses_; }
  // Slots that the last apply() or follow() wrote or dropped; may repeat.
  [[nodiscard]] std::span<const mesh::TriangleId> changed_slots() const { return changed_slots_; }
  // 1/s^2, upper bound of the largest eigenvalue of M^-1 K at rest; see StiffnessBound.
  [[nodiscard]] double stiffness_bound() const { return stiffness_bound_.value(); }
  // Part of stiffness_bound() due to bending.
  [[nodiscard]] double bending_stiffness_bound() const { return stiffness_bound_.bending(); }
  // 1/m, reciprocal of the least height of the slot's triangle at rest; 0 without material.
  [[nodiscard]] double gradient(mesh::TriangleId slot) const {
    return gradients_.value(static_cast<std::size_t>(slot));
  }
  // 1/m, reciprocal of the least height of any triangle at rest; 0 without material.
  [[nodiscard]] double largest_gradient() const { return gradients_.value(); }

  // Sets f (3 x V, N) to the membrane and bending forces at x (3 x V, m), without damping. f must have V columns.
  void internal_forces(const mesh::VertexField& x, mesh::VertexField& f) const;
  // Adds to f (3 x V, N) the bending forces at x (3 x V, m) and v (3 x V, m/s). They include those of clamps and of a
  // curved rest shape. Kelvin-Voigt damping makes the stresses D (kappa + beta dkappa/dt). For beta see damping_of;
  // `damped` (3 x V) is scratch.
  void add_bending_forces(const mesh::VertexField& x, const mesh::VertexField& v, std::span<const double> beta,
                          mesh::VertexField& damped, mesh::VertexField& f) const;
  [[nodiscard]] BendingTerms bending_terms() const { return {blocks_, patches_, bending_edges_}; }
  [[nodiscard]] double bending_energy(const mesh::VertexField& x) const;  // J
  // Returns the energies of a state; gravity in m/s^2.
  [[nodiscard]] Energies energies(const State& state, const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Momentum momentum(const State& state) const;
  [[nodiscard]] Eigen::Vector3d centre_of_mass(const mesh::VertexField& x) const;  // m

  // Hash of every number derived from mesh and material, bit for bit, including those that only later edits read. For
  // tests.
  [[nodiscard]] std::uint64_t hash() const;

 private:
  // Empties the slots that the mesh no longer has. Returns the remaining vertices of their triangles and patches, in
  // any order, repeated.
  std::vector<mesh::VertexId> drop_slots(const mesh::TriangleMesh& mesh);
  // Rewrites the slots and the incidence of their vertices. Leaves in touched_ those vertices, old and new, and the
  // `bereft`, which have lost a slot.
  void set_elements(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten,
                    const std::vector<mesh::VertexId>& bereft);
  void set_incidence(const std::vector<mesh::TriangleId>& rewritten);
  void resize(const mesh::TriangleMesh& mesh);
  void set_element(const mesh::TriangleMesh& mesh, mesh::TriangleId slot);
  // Returns the material of a slot of the mesh.
  [[nodiscard]] std::uint8_t material_at(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  void write_element(mesh::TriangleId slot, const std::array<mesh::VertexId, 3>& vertices,
                     const Eigen::Matrix2d& Dm_inv, double area, std::uint8_t material);
  void set_edge_length(mesh::VertexId vertex, double length);
  void set_lumped_mass(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // Sets mass_ to the redistributed lumped masses.
  MassChange set_masses();
  // Makes the patches of the rewritten slots and of their neighbours. Sums the rows that these are or were in, leaving
  // them in rows_.
  void set_bending(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten);
  // Rebuilds the bending patches of the rewritten triangles and their neighbours, and marks the matrix rows they touch.
  void make_patches(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> rewritten);
  [[nodiscard]] const Clamp* find_clamp(mesh::VertexId vertex) const;
  // Returns true if edge k of a solid slot is clamped, and then sets `gradient` to the derivative of x by the material
  // coordinates there.
  bool find_clamped_edge(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, std::size_t k,
                         Eigen::Matrix<double, 3, 2>& gradient) const;
  // Sets clamp_forces_.
  void sum_clamp_forces(const mesh::TriangleMesh& mesh);
  // Marks in rows_ those of the vertices that the sheet has.
  void mark_rows(std::span<const mesh::VertexId> vertices);
  // Rebuilds the edge terms of the slots in patched_, and marks the rows that they are or were in.
  void make_edges(const mesh::TriangleMesh& mesh);
  // Makes the term of the edge opposite corner k of `slot`, with `other` across it. Returns true if the edge needs one.
  bool make_edge(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, mesh::TriangleId other, int k,
                 BendingEdge& edge);
  // Returns the corner of `slot` that is not on its edge to its neighbour `from`.
  static std::size_t corner_across(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, mesh::TriangleId from);
  // Returns the vertices of a patch; all kNone for a slot without material.
  [[nodiscard]] std::array<mesh::VertexId, 6> patch_vertices(const mesh::TriangleMesh& mesh,
                                                             mesh::TriangleId slot) const;
  // Positions of a patch on the rest surface, as for make_rest_bending.
  struct PatchSurface {
    std::array<Eigen::Vector3d, 6> at;  // m
    bool is_bent = false;
  };
  // Computes the stiffness of the patches in patched_, the sides of those in fitted_, and the terms of a curved rest
  // shape.
  void fit_patches(const mesh::TriangleMesh& mesh);
  // Returns the patch of a solid slot of a flat rest shape.
  [[nodiscard]] PatchGeometry flat_patch(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  // Returns the patch of a solid slot of a curved rest shape.
  [[nodiscard]] PatchGeometry curved_patch(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                                           PatchSurface& surface) const;
  // Returns the slopes h x_nu that clamps hold at each edge of a slot (see fit_bending); 0 at other edges.
  [[nodiscard]] std::array<Eigen::Vector3d, 3> held_slopes(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  // Adds the forces of held slopes to clamp_forces_. entry(a, b) is the entry of Q at these places; a place is kNone
  // where a held slope takes it.
  template <typename Entry>
  void add_clamp_forces_of(std::span<const mesh::VertexId> vertices, std::span<const Eigen::Vector3d> held,
                           const Entry& entry);
  // Sums row `vertex` of Q over the patches that the vertex is in, by ascending slot, then over the edges. On a curved
  // rest shape it also sums the row that bounds the stiffness.
  void sum_bending_row(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // Sets row_sorted_ to the patches that the vertex is in and its row there, 8 * slot + row, ascending.
  void find_patches_at(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // Adds the patches in row_sorted_ to the row; entries(slot, a, b) gives those of patch `slot`.
  template <typename Entries>
  void add_patches_to_row(const Entries& entries);
  void add_edges_to_row(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  struct RowOfEdge {
    const BendingEdge* edge = nullptr;
    std::size_t place = 0;  // place of the vertex in the edge
  };
  [[nodiscard]] bool has_material(mesh::TriangleId slot) const;
  [[nodiscard]] std::array<mesh::VertexId, 3> corners(mesh::TriangleId slot) const;

  [[nodiscard]] StiffnessProblem stiffness_problem(const mesh::TriangleMesh& mesh) const;

  MaterialTable materials_;
  int num_slots_ = 0;
  std::vector<ElementBlock> blocks_;
  RunningMaximum gradients_;           // 1/m, reciprocal of the least height, by slot
  std::vector<BendingPatch> patches_;  // one a slot; empty without bending
  RowStore<mesh::TriangleId> incident_;
  RowStore<BendingEdge> bending_edges_;  // one row a slot: at its edges to neighbours of higher slots
  RowStore<BendingEntry> bending_rows_;
  std::vector<Clamp> clamps_;  // sorted by vertex
  ClampForces clamp_forces_;
  std::shared_ptr<const AngleBending> angle_bending_;
  // For a curved rest shape only; empty otherwise.
  std::vector<RestBending> rest_bending_;  // one a slot
  RowStore<BendingEntry> bound_rows_;      // sums of |Q_ij| + RestBending::excess
  std::vector<double> lumped_mass_;        // kg, length V; a third of each triangle's mass
  std::vector<double> mass_floor_;         // kg, length V; a lighter vertex gets mass from its neighbours
  std::vector<double> mass_damping_;       // 1/s, length V; empty if all materials have the same
  std::vector<MassTile> mass_tile_;        // length V
  std::vector<double> edge_length_;        // m, length V; in the sheet as built, 0 without material
  std::map<double, std::int64_t> num_vertices_by_edge_length_;  // few entries: lengths are powers of two apart
  double built_extent_ = 0.0;                                   // m
  std::vector<double> mass_;
  std::vector<double> inverse_mass_;
  MassRedistribution redistribution_;
  StiffnessBound stiffness_bound_;
  std::vector<mesh::TriangleId> changed_slots_;
  std::vector<mesh::VertexId> changed_masses_;

  // Scratch of apply().
  IndexSet touched_;                                     // vertices of rewritten slots, before and after
  IdSet rewritten_;                                      // slots
  IdSet patched_;                                        // slots whose patch is rebuilt
  IdSet edged_;                                          // slots whose row of bending_edges_ is rebuilt
  IndexSet fitted_;                                      // slots whose patch is refitted
  std::vector<std::array<BendingSide, 3>> sides_;        // by place in fitted_, for a flat rest shape
  std::vector<BendingEdge> edge_row_;                    // of one slot
  IdSet rows_;                                           // rows of Q to sum again
  std::vector<std::int32_t> row_patches_, row_sorted_;   // of one row: see find_patches_at
  std::vector<RowOfEdge> row_edges_, row_edges_sorted_;  // of one row
  std::vector<std::int32_t> row_keys_;                   // of row_edges_
  std::vector<std::int32_t> row_order_;                  // of one row
  RowSum row_sum_;
};

}  // namespace kerf::fem
