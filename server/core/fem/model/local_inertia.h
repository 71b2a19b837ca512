#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/inertia_cluster.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/stiff_parts.h"
#include "server/core/linear/index_set.h"
#include "server/core/linear/lanes16.h"

namespace kerf::fem {

// Limits that an explicit step sets on the stiffness of a sheet.
struct InertiaTerms {
  // 1/s^2: largest row sum of the stiffness over the mass of the vertex that a step may have without clusters; may be
  // infinite.
  double limit = 0.0;
  // 1/s^2: the same for bending alone, if it acts once in several substeps. If it is 0 bending acts in each substep,
  // and its rows count towards `limit`.
  double bending_limit = 0.0;
  AddedInertia added;
  bool operator==(const InertiaTerms&) const = default;
};

// Keeps tiny triangles along cuts from dictating the explicit step of the whole sheet. Clusters of vertices around them
// have, in place of M, the inertia
//   M' = M + alpha h^2 (z L + n^2 Q).
// h is the length of a substep. L is the sum of g_i.g_j A over the stiff triangles, and z L bounds their stiffness. Q
// is the sum of the stiff bending terms, which act once in n substeps. This is selective mass scaling by stiffness
// (Olovsson, Simonsson, Unosson 2005, "Selective mass scaling for explicit finite element analyses"). Here the matrix
// has one number for each pair of vertices, the same for x, y and z, and bounds the stiffness in every position. It
// thus need not turn with the sheet, and is kept from cut to cut.
//   Stable: let b = beta / h, h^2 (1 + 2 b) K <= 4 M for all that is not stiff, and K_stiff <= z L + Q. Then h^2 (1 +
//     2 b) (K + K_stiff) <= 4 M' if alpha >= (1 + 2 b) / 4. Twice the least alpha is taken.
//   Conserved: L 1 = Q 1 = 0, so that total momentum and free fall are those of M. M' is symmetric and the same for x,
//     y and z, so that leapfrog keeps sum x_i x (M' v)_i and v.M' v / 2 + V as usual. Statics do not change. Only
//     motion inside a cluster is slowed: its added radius of gyration is sqrt(alpha z / surface density) h.
// A part (StiffPart) is a triangle or a bending term. The stiff parts at a vertex are those with the largest row sums
// there. They are as many as needed for the other row sums to add up to at most the limit times the mass of the vertex.
// A part that is stiff at one of its vertices is stiff as a whole, and stiff parts connect the vertices of a cluster.
// Clusters are derived from the model and the terms alone, whatever edits led to them.
class LocalInertia {
 public:
  // Reserves storage, so that the first cuts of a large sheet need not.
  void reserve(std::size_t num_vertices);
  void rebuild(const Model& model, const InertiaTerms& terms);
  // Updates the clusters after exactly one Model::follow since the previous rebuild() or follow().
  void follow(const Model& model, const InertiaTerms& terms);
  // Shows or hides the clusters. While they are hidden no function finds any. After that only rebuild() makes them
  // match a model again.
  void set_active(bool is_active) { is_active_ = is_active; }
  [[nodiscard]] bool is_active() const { return is_active_; }

  // All clusters, in ascending order of their lowest vertices.
  [[nodiscard]] std::span<InertiaCluster* const> clusters() const {
    return is_active_ ? std::span<InertiaCluster* const>(ordered_) : std::span<InertiaCluster* const>();
  }
  // Returns null if the vertex is in no cluster.
  [[nodiscard]] const InertiaCluster* cluster_of(mesh::VertexId v) const {
    const std::int32_t slot = slot_of(v);
    return slot == mesh::kNone ? nullptr : &cluster_in(slot);
  }
  // Returns the slot of the vertex's cluster, or kNone. This is its number in 0..num_slots() - 1, which no other
  // cluster has.
  [[nodiscard]] std::int32_t slot_of(mesh::VertexId v) const {
    return is_active_ ? cluster_of_[static_cast<std::size_t>(v)] : mesh::kNone;
  }
  [[nodiscard]] const InertiaCluster& cluster_in(std::int32_t slot) const {
    return *clusters_[static_cast<std::size_t>(slot)];
  }
  [[nodiscard]] std::size_t num_slots() const { return clusters_.size(); }
  [[nodiscard]] bool empty() const { return clusters().empty(); }
  [[nodiscard]] std::size_t num_vertices() const { return is_active_ ? num_vertices_ : 0; }  // of all clusters
  [[nodiscard]] std::size_t num_entries() const { return is_active_ ? num_entries_ : 0; }    // of all factors
  [[nodiscard]] std::size_t largest() const { return is_active_ ? largest_ : 0; }            // vertices of one cluster

  // Holds, in all clusters, exactly the components that `pins` fix. Does not allocate.
  void hold(std::span<const Pin> pins);
  // 1/kg, velocity of the grab's point per impulse on it; see Integrator::mobility.
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const;
  // Takes velocities (m/s) that impulses would give to the masses alone. Replaces them by those that the same impulses
  // give to the clusters: v' = M'^-1 M v. Other vertices keep theirs. Momentum stays, and kinetic energy never grows:
  // v'.M' v' <= v.M v, as M' >= M.
  void share_impulses(const Model& model, linear::VertexField& v) const;
  // Contributions of the added inertia M' - M to the kinetic energy, J, and to the angular momentum about the world's
  // origin, kg m^2/s.
  [[nodiscard]] double added_energy(const linear::VertexField& v) const;
  [[nodiscard]] Eigen::Vector3d added_spin(const State& state) const;

 private:
  void begin_update(const Model& model);
  void end_update(const Model& model);
  void dissolve(std::int32_t cluster);
  void find_wanted(const Model& model, mesh::VertexId v);
  void gather_region(const Model& model);
  void form_clusters(const Model& model);
  void set_order();
  std::int32_t root(std::int32_t place);

  InertiaTerms terms_;
  bool is_active_ = false;
  std::unordered_map<mesh::VertexId, std::vector<StiffPart>> wanted_;  // stiff parts at a vertex, ascending; only
                                                                       // vertices that have some
  std::vector<std::int32_t> cluster_of_;                               // length V
  std::vector<std::unique_ptr<InertiaCluster>> clusters_;
  std::vector<std::int32_t> free_;
  std::vector<InertiaCluster*> ordered_;
  std::size_t num_vertices_ = 0, num_entries_ = 0, largest_ = 0;
  std::vector<std::uint8_t> held_;  // scratch of hold(), length V, 0 between calls
  std::vector<std::uint8_t> held_of_cluster_;
  mutable std::vector<linear::Lanes16<double>> values_;  // scratch for one cluster

  // Scratch of updates.
  linear::IndexSet region_;  // changed vertices with stiff parts, and vertices of clusters being rebuilt
  std::vector<StiffPart> stiff_;
  std::vector<std::int32_t> parent_;
  std::vector<mesh::TriangleId> slots_;
  std::vector<PartAtVertex> parts_, bending_;
  std::vector<StiffPart> row_;
};

}  // namespace kerf::fem
