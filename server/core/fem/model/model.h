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

// Vertices whose mass an edit recomputed or changed, added ones included, with the mass they had before.
struct MassChange {
  std::vector<mesh::VertexId> vertices;  // unique
  std::vector<double> mass_before;       // kg, same length; 0 for an added vertex
  std::vector<double> dropped;           // kg, of the last vertices, which are gone
  std::size_t num_examined = 0;          // vertices whose mass was worked out anew, changed or not
};

// The discrete elastic sheet: constants of every triangle, lumped masses and the bending matrix, for the rest shape of
// the mesh, flat or curved, and its materials.
//   Membrane: linear triangles, W = A/2 e.C e; co-rotational with e = U - I, F = R U (Biot strain), or with Green's
//             strain: see MembraneLaw.
//   Bending: quadratic patch of a triangle and its up to three neighbours, W = A/2 kappa.D kappa (see bending.h), and
//            the work of moments on the kinks between patches (see bending_edge.h); where the rest shape is curved the
//            patch is unfolded along its edges, kappa is measured from that of the rest shape (see rest_bending.h), and
//            kinks are left out. For equilibria and vibrations see bend_by_angles().
//   Mass: a third of each triangle's to each corner; vertices far too light for their stiffness, as along a cut, are
//         given some of their neighbours' (see mass_redistribution.h).
//   Materials: a triangle has that of its number, region(t) of the mesh; no edit moves the borders between regions, so
//         that the material of a place stays, whatever is cut. A bending patch has the law of its own triangle, and
//         damping of the mass at a vertex is the mean over its triangles, weighted with their masses.
// Derived from mesh and materials alone: two models of equal mesh and materials are equal bit for bit, however they
// were arrived at.
class Model {
 public:
  // `material` must be valid (see validate). One for all, whatever the regions of the mesh.
  Model(const mesh::TriangleMesh& mesh, const Material& material, MembraneLaw law = MembraneLaw::kCorotational);
  // 1..kMaxMaterials; more than all regions of the mesh, or one for all.
  Model(const mesh::TriangleMesh& mesh, std::span<const Material> materials,
        MembraneLaw law = MembraneLaw::kCorotational);

  // Follows an edit the mesh has already made; recomputes the rewritten slots, the bending patches that touch them and
  // the masses near them, nothing else. Equal to a fresh model of the same materials.
  MassChange apply(const mesh::TriangleMesh& mesh, const mesh::MeshEdit& edit);
  // The same for any number of edits, made or taken back, by the slots that they rewrote: `rewritten` is sorted and
  // unique, and holds all of those that the mesh still has. Where the mesh has fewer slots and vertices than the model,
  // the last ones go.
  // `observer` may be null.
  MassChange follow(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten,
                    PhaseObserver* observer = nullptr);

  // Holds the slope of the sheet at border edges both ends of which are among these; sorted by vertex, unique; replaces
  // those before. Bending only, and where the rest shape is flat.
  void set_clamps(const mesh::TriangleMesh& mesh, std::vector<Clamp> clamps);

  // Until the mesh or the clamps change, or bend_by_matrix(), forces and energies of bending are those of angles (see
  // angle_bending.h), for equilibria and vibrations; damping, rows and bounds stay those of Q. Nothing where the rest
  // shape is curved, or without bending. O(V). In no hash.
  void bend_by_angles(const mesh::TriangleMesh& mesh);
  void bend_by_matrix() { angle_bending_.reset(); }
  // Null where bending is that of Q.
  [[nodiscard]] const AngleBending* angle_bending() const { return angle_bending_.get(); }

  // A moment along the border edge opposite corner `edge` of a solid slot, in N m per m of the edge at rest; see
  // EdgeMoment. Until the mesh or the clamps change. None at a clamped edge, which takes it. Where the rest shape is
  // curved, or without bending, the slope is that of the triangle alone.
  [[nodiscard]] EdgeMoment edge_moment(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, int edge,
                                       double moment_per_length) const;

  [[nodiscard]] int num_vertices() const { return static_cast<int>(mass_.size()); }
  [[nodiscard]] int num_slots() const { return num_slots_; }
  [[nodiscard]] const MaterialTable& materials() const { return materials_; }
  // Of a slot; of one without material, that of material 0.
  [[nodiscard]] const MaterialLaw& law(mesh::TriangleId slot) const {
    return materials_.of(blocks_[static_cast<std::size_t>(slot / kLanes)], static_cast<std::size_t>(slot % kLanes));
  }

  // kg, length V; 0 for a vertex without material, which nothing ever moves.
  [[nodiscard]] std::span<const double> mass() const { return mass_; }
  // 1/kg, length V; 0 where the mass is 0.
  [[nodiscard]] std::span<const double> inverse_mass() const { return inverse_mass_; }
  [[nodiscard]] double total_mass() const;  // kg
  [[nodiscard]] double rest_area() const;   // m^2
  // m; of the sheet as built: the least edge length (see EdgeLengths) that a tenth of the vertices, or more, have.
  [[nodiscard]] double typical_edge_length() const;
  // m; the longer side of the bounding box of the sheet as built, in material coordinates.
  [[nodiscard]] double built_extent() const { return built_extent_; }
  // 1/s, Rayleigh alpha at a vertex: the force on it is -alpha m v.
  [[nodiscard]] double mass_damping(mesh::VertexId vertex) const {
    return materials_.has_one_mass_damping() ? materials_[0].material.mass_damping
                                             : mass_damping_[static_cast<std::size_t>(vertex)];
  }

  // ceil(num_slots / kLanes) blocks; lanes beyond num_slots have no material.
  [[nodiscard]] std::span<const ElementBlock> element_blocks() const { return blocks_; }
  [[nodiscard]] bool has_bending() const { return materials_.has_bending(); }
  // What of it is at edges; one row a slot, empty without bending.
  [[nodiscard]] const RowStore<BendingEdge>& bending_edges() const { return bending_edges_; }
  // Q in N/m, one row a vertex: bending force on vertex i = -sum_j Q_ij x_j, but for angles. Empty rows without
  // bending.
  [[nodiscard]] const RowStore<BendingEntry>& bending_rows() const { return bending_rows_; }
  // N/m, what bounds the absolute values of its rows: more on a curved rest shape.
  [[nodiscard]] const RowStore<BendingEntry>& bending_bound_rows() const {
    return rest_bending_.empty() ? bending_rows_ : bound_rows_;
  }
  // What clamps add to the bending force -Q x.
  [[nodiscard]] const ClampForces& clamp_forces() const { return clamp_forces_; }
  // Empty where the rest shape is flat.
  [[nodiscard]] RestBendingPatches rest_bending() const { return {blocks_, patches_, rest_bending_}; }
  // Solid slots around each vertex, ascending.
  [[nodiscard]] const RowStore<mesh::TriangleId>& incident_slots() const { return incident_; }
  // Vertices whose row of the stiffness matrix may have other columns since the last apply() or follow(), or stand for
  // other elements; unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_rows() const {
    return has_bending() ? rows_.members() : touched_.members();
  }
  // Vertices whose mass the last apply() or follow() worked out again; unique.
  [[nodiscard]] std::span<const mesh::VertexId> changed_masses() const { return changed_masses_; }
  // Slots that the last apply() or follow() wrote, and those that are gone since; may repeat.
  [[nodiscard]] std::span<const mesh::TriangleId> changed_slots() const { return changed_slots_; }
  // Upper bound of the largest eigenvalue of M^-1 K at rest, 1/s^2; see StiffnessBound.
  [[nodiscard]] double stiffness_bound() const { return stiffness_bound_.value(); }
  // The part of it that is of bending.
  [[nodiscard]] double bending_stiffness_bound() const { return stiffness_bound_.bending(); }
  // 1/m, one over the least height of the slot's triangle at rest; 0 without material.
  [[nodiscard]] double gradient(mesh::TriangleId slot) const {
    return gradients_.value(static_cast<std::size_t>(slot));
  }
  // 1/m, one over the least height of any triangle at rest; 0 without material.
  [[nodiscard]] double largest_gradient() const { return gradients_.value(); }

  // f (3 x V, N), overwritten: membrane and bending forces at x (3 x V, m), no damping. f must have V columns.
  void internal_forces(const mesh::VertexField& x, mesh::VertexField& f) const;
  // f (3 x V, N) += bending forces at x (3 x V, m) and v (3 x V, m/s), those of clamps and of a curved rest shape
  // included, with Kelvin-Voigt damping: stresses are D (kappa + beta dkappa/dt). beta: see damping_of. `damped` (3 x
  // V) is scratch.
  void add_bending_forces(const mesh::VertexField& x, const mesh::VertexField& v, std::span<const double> beta,
                          mesh::VertexField& damped, mesh::VertexField& f) const;
  [[nodiscard]] BendingTerms bending_terms() const { return {blocks_, patches_, bending_edges_}; }
  [[nodiscard]] double bending_energy(const mesh::VertexField& x) const;  // J
  // gravity: m/s^2.
  [[nodiscard]] Energies energies(const State& state, const Eigen::Vector3d& gravity) const;
  [[nodiscard]] Momentum momentum(const State& state) const;
  [[nodiscard]] Eigen::Vector3d centre_of_mass(const mesh::VertexField& x) const;  // m

  // Of every number derived from mesh and material, bit for bit, those that only a later edit reads included; for
  // tests.
  [[nodiscard]] std::uint64_t hash() const;

 private:
  // Empties the slots that the mesh no longer has; returns the vertices of their triangles and patches that it still
  // has, in any order, repeated.
  std::vector<mesh::VertexId> drop_slots(const mesh::TriangleMesh& mesh);
  // Rewrites the slots and the incidence of their vertices; leaves those vertices, old and new, and those `bereft` of a
  // slot in touched_.
  void set_elements(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten,
                    const std::vector<mesh::VertexId>& bereft);
  void set_incidence(const std::vector<mesh::TriangleId>& rewritten);
  void resize(const mesh::TriangleMesh& mesh);
  void set_element(const mesh::TriangleMesh& mesh, mesh::TriangleId slot);
  // The material of a slot of the mesh.
  [[nodiscard]] std::uint8_t material_at(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  void write_element(mesh::TriangleId slot, const std::array<mesh::VertexId, 3>& vertices,
                     const Eigen::Matrix2d& Dm_inv, double area, std::uint8_t material);
  void set_edge_length(mesh::VertexId vertex, double length);
  void set_lumped_mass(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // Takes the lumped masses over into mass_, redistributed.
  MassChange set_masses();
  // Makes the patches of the rewritten slots and of their neighbours, and sums the rows they are in or were, left in
  // rows_.
  void set_bending(const mesh::TriangleMesh& mesh, const std::vector<mesh::TriangleId>& rewritten);
  // Of the rewritten slots and their neighbours, and of all rows they are in.
  void make_patches(const mesh::TriangleMesh& mesh, std::span<const mesh::TriangleId> rewritten);
  [[nodiscard]] const Clamp* find_clamp(mesh::VertexId vertex) const;
  // Whether edge k of a solid slot is clamped; then the derivative of x by the material coordinates there.
  bool find_clamped_edge(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, std::size_t k,
                         Eigen::Matrix<double, 3, 2>& gradient) const;
  // Into clamp_forces_.
  void sum_clamp_forces(const mesh::TriangleMesh& mesh);
  // Marks rows_ of those that the sheet has.
  void mark_rows(std::span<const mesh::VertexId> vertices);
  // At the edges of the slots in patched_; marks the rows that they are in or were.
  void make_edges(const mesh::TriangleMesh& mesh);
  // Of the edge opposite corner k of `slot`, `other` across it. Whether it needs a term.
  bool make_edge(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, mesh::TriangleId other, int k,
                 BendingEdge& edge);
  // The corner of `slot` that is not on its edge to its neighbour `from`.
  static std::size_t corner_across(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, mesh::TriangleId from);
  // kNone throughout for a slot without material.
  [[nodiscard]] std::array<mesh::VertexId, 6> patch_vertices(const mesh::TriangleMesh& mesh,
                                                             mesh::TriangleId slot) const;
  // Positions on the rest surface, as of make_rest_bending.
  struct PatchSurface {
    std::array<Eigen::Vector3d, 6> at;  // m
    bool is_bent = false;
  };
  // Stiffness of the patches in patched_, sides of those in fitted_; of a curved rest shape what that adds.
  void fit_patches(const mesh::TriangleMesh& mesh);
  // Of a solid slot of a flat rest shape.
  [[nodiscard]] PatchGeometry flat_patch(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  // Of a curved one.
  [[nodiscard]] PatchGeometry curved_patch(const mesh::TriangleMesh& mesh, mesh::TriangleId slot,
                                           PatchSurface& surface) const;
  // What clamps hold at each edge of a slot, h x_nu: see fit_bending; 0 elsewhere.
  [[nodiscard]] std::array<Eigen::Vector3d, 3> held_slopes(const mesh::TriangleMesh& mesh, mesh::TriangleId slot) const;
  // entry(a, b): of the Q of these vertices, kNone where what is held takes their place. Into clamp_forces_.
  template <typename Entry>
  void add_clamp_forces_of(std::span<const mesh::VertexId> vertices, std::span<const Eigen::Vector3d> held,
                           const Entry& entry);
  // Row `vertex` of Q: the sum over the patches that the vertex is in, by ascending slot, then over the edges. Of a
  // curved rest shape also that of what bounds the stiffness.
  void sum_bending_row(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // Into row_sorted_: the patches that the vertex is in and its row there, 8 * slot + row, ascending.
  void find_patches_at(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  // entries(slot, a, b): of patch `slot`, all of those in row_sorted_.
  template <typename Entries>
  void add_patches_to_row(const Entries& entries);
  void add_edges_to_row(const mesh::TriangleMesh& mesh, mesh::VertexId vertex);
  struct RowOfEdge {
    const BendingEdge* edge = nullptr;
    std::size_t place = 0;  // of the vertex
  };
  [[nodiscard]] bool has_material(mesh::TriangleId slot) const;
  [[nodiscard]] std::array<mesh::VertexId, 3> corners(mesh::TriangleId slot) const;

  [[nodiscard]] StiffnessProblem stiffness_problem(const mesh::TriangleMesh& mesh) const;

  MaterialTable materials_;
  int num_slots_ = 0;
  std::vector<ElementBlock> blocks_;
  RunningMaximum gradients_;           // 1/m, of the slots: 1 / least height
  std::vector<BendingPatch> patches_;  // one a slot; empty without bending
  RowStore<mesh::TriangleId> incident_;
  RowStore<BendingEdge> bending_edges_;  // one row a slot: at its edges to neighbours of higher slots
  RowStore<BendingEntry> bending_rows_;
  std::vector<Clamp> clamps_;  // sorted by vertex
  ClampForces clamp_forces_;
  std::shared_ptr<const AngleBending> angle_bending_;
  // Of a curved rest shape; empty else.
  std::vector<RestBending> rest_bending_;  // one a slot
  RowStore<BendingEntry> bound_rows_;      // sums of |Q_ij| + RestBending::excess
  std::vector<double> lumped_mass_;        // kg, length V; a third of each triangle's
  std::vector<double> mass_floor_;         // kg, length V; below which a vertex is given mass
  std::vector<double> mass_damping_;       // 1/s, length V; empty where all materials have the same
  std::vector<MassTile> mass_tile_;        // length V
  std::vector<double> edge_length_;        // m, length V; of the sheet as built, 0 without material
  std::map<double, std::int64_t> num_vertices_by_edge_length_;  // lengths are powers of two apart: few
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
  IdSet patched_;                                        // slots whose patch is made anew
  IdSet edged_;                                          // slots whose row of bending_edges_ is made anew
  IndexSet fitted_;                                      // slots whose patch is fitted anew
  std::vector<std::array<BendingSide, 3>> sides_;        // by place in fitted_, of a flat rest shape
  std::vector<BendingEdge> edge_row_;                    // of one slot
  IdSet rows_;                                           // rows of Q that are summed anew
  std::vector<std::int32_t> row_patches_, row_sorted_;   // of one row: see find_patches_at
  std::vector<RowOfEdge> row_edges_, row_edges_sorted_;  // of one row
  std::vector<std::int32_t> row_keys_;                   // of row_edges_
  std::vector<std::int32_t> row_order_;                  // of one row
  RowSum row_sum_;
};

}  // namespace kerf::fem
