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

// Limits that an explicit step sets to a sheet.
struct InertiaTerms {
  double limit = 0.0;  // 1/s^2: what a row of the stiffness may sum to over the mass of its vertex; may be infinite
  // 1/s^2, the same of bending, which acts once in several substeps; 0: it acts in each, and its rows are in the sum.
  double bending_limit = 0.0;
  AddedInertia added;
  bool operator==(const InertiaTerms&) const = default;
};

// Keeps tiny triangles along cuts from dictating the explicit step of the whole sheet: clusters of vertices around them
// have the inertia
//   M' = M + alpha h^2 (z L + n^2 Q),
// L, Q the sums of the stiff triangles' g_i.g_j A and of the stiff bending terms, which act once in n substeps, in
// place of M. Selective mass scaling by stiffness (Olovsson, Simonsson, Unosson 2005, "Selective mass scaling for
// explicit finite element analyses"), but with a scalar matrix that bounds the stiffness in every position, so that it
// needs not turn with the sheet and stays as it is from one cut to the next.
//   Stable: with h^2 (1 + 2 b) K <= 4 M for the rest, b = beta / h, and K <= z L + Q for the stiff parts, h^2 (1 + 2 b)
//   (K + K_stiff) <= 4 M' where alpha >= (1 + 2 b) / 4. Twice that is taken.
//   Conserved: L 1 = Q 1 = 0, so that total momentum and free fall are those of M; M' is symmetric and the same for x,
//   y and z, so that sum x_i x (M' v)_i and v.M' v / 2 + V are kept as by leapfrog. Statics do not change. Only motion
//   inside a cluster is slowed: its added radius of gyration is sqrt(alpha z / surface density) h.
// Stiff are at each vertex the parts with the largest rows, until the rest sums to no more than the limit times its
// mass. A part is stiff as a whole, and stiff parts connect the vertices of a cluster.
// Derived from the model and the terms alone, not from how they came about.
class LocalInertia {
 public:
  // Makes room, so that the first cuts of a large sheet need not.
  void reserve(std::size_t num_vertices);
  void rebuild(const Model& model, const InertiaTerms& terms);
  // After one Model::follow since the call before.
  void follow(const Model& model, const InertiaTerms& terms);
  // While it is not active there are no clusters to be seen, and only rebuild() makes them those of a model again.
  void set_active(bool is_active) { is_active_ = is_active; }
  [[nodiscard]] bool is_active() const { return is_active_; }

  // By their lowest vertices, ascending.
  [[nodiscard]] std::span<InertiaCluster* const> clusters() const {
    return is_active_ ? std::span<InertiaCluster* const>(ordered_) : std::span<InertiaCluster* const>();
  }
  // Null where the vertex is in none.
  [[nodiscard]] const InertiaCluster* cluster_of(mesh::VertexId v) const {
    const std::int32_t slot = slot_of(v);
    return slot == mesh::kNone ? nullptr : &cluster_in(slot);
  }
  // Names the slot of its cluster, below num_slots(), or kNone.
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

  // Holds the vertices of clusters that have pins, and no others. Does not allocate.
  void hold(std::span<const Pin> pins);
  // 1/kg, see Integrator::mobility.
  [[nodiscard]] double mobility(const Model& model, const Grab& grab) const;
  // Takes the velocities of vertices in clusters, m/s, as given by impulses to the masses alone, and gives those to the
  // clusters by their inertia: v = M'^-1 M v. Keeps momentum, and never adds kinetic energy, v'.M' v' <= v.M v, as
  // M' >= M.
  void share_impulses(const Model& model, mesh::VertexField& v) const;
  // Shares of the added inertia M' - M in the kinetic energy, J, and in the angular momentum about the world's origin,
  // kg m^2/s.
  [[nodiscard]] double added_energy(const mesh::VertexField& v) const;
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
  std::unordered_map<mesh::VertexId, std::vector<StiffPart>> wanted_;  // stiff for the sake of a vertex, ascending
  std::vector<std::int32_t> cluster_of_;                               // length V
  std::vector<std::unique_ptr<InertiaCluster>> clusters_;
  std::vector<std::int32_t> free_;
  std::vector<InertiaCluster*> ordered_;
  std::size_t num_vertices_ = 0, num_entries_ = 0, largest_ = 0;
  std::vector<std::uint8_t> held_;  // scratch of hold(), length V, 0 outside of it
  std::vector<std::uint8_t> held_of_cluster_;
  mutable std::vector<Lanes16<double>> values_;  // scratch, of one cluster

  // Scratch of updates.
  IndexSet region_;  // vertices that changed and want stiff parts, and those of clusters that are made again
  std::vector<StiffPart> stiff_;
  std::vector<std::int32_t> parent_;
  std::vector<mesh::TriangleId> slots_;
  std::vector<PartAtVertex> parts_, bending_;
  std::vector<StiffPart> row_;
};

}  // namespace kerf::fem
