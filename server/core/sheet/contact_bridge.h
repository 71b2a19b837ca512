#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/contact_solver.h"
#include "server/core/contact/self_contact.h"
#include "server/core/fem/element/contact_constraint.h"
#include "server/core/fem/model/local_inertia.h"
#include "server/core/fem/step/step_stats.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/ids.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/cluster_inertia.h"

namespace kerf {
template <class T>
struct Fields;
}  // namespace kerf

namespace kerf::sheet {

// Connects ContactSolver to the interface through which integrators call contact, since fem and contact may not include
// each other. Copyable.
class ContactBridge : public fem::ContactConstraint {
 public:
  void set_colliders(std::span<const contact::Collider> colliders) { solver_.set_colliders(colliders); }
  // Sets the least distance of the sheet's middle surface from colliders, m, >= 0.
  void set_half_thickness(double half_thickness) { half_thickness_ = half_thickness; }
  void set_calm(bool is_calm) { is_calm_ = is_calm; }
  // Must be called after every change of pins or topology. `pinned` vertices, and `removed` ones, which have no
  // material, are left alone. O(pinned + removed + new vertices). Allocates memory.
  void set_vertices(std::int32_t num_vertices, const std::vector<mesh::VertexId>& pinned,
                    const std::vector<mesh::VertexId>& removed);

  void begin(const linear::VertexField& x) override;
  [[nodiscard]] bool has_bodies() const override { return !solver_.empty(); }
  [[nodiscard]] int num_inside() const override { return solver_.num_inside(); }
  [[nodiscard]] bool is_calm() const override { return is_calm_; }
  void enforce(double dt, fem::State& state) override;
  std::span<const std::int32_t> find_due_blocks(double dt, double travel) override {
    return solver_.find_due_blocks(dt, travel);
  }
  std::uint32_t enforce_block(std::int32_t block, mesh::VertexLanes& vertices) override {
    return solver_.resolve(block, vertices);
  }
  std::size_t find_gaps(int vertex, const Eigen::Vector3d& x, double reach,
                        std::array<fem::SurfaceGap, kMaxGaps>& gaps) const override;

  // Sets up contact of the sheet with itself after each change of the topology, if it is on. Allocates memory.
  void set_mesh(const mesh::TriangleMesh& mesh);
  // set_mesh() must be called next if self-contact was off before.
  void set_self_contact(const scene::SelfContact& settings);
  [[nodiscard]] const scene::SelfContact& self_contact() const { return settings_; }
  // Distance that middle surfaces keep from each other, m.
  [[nodiscard]] double self_thickness() const { return settings_.thickness.value_or(2.0 * half_thickness_); }
  [[nodiscard]] bool touches_itself() const override { return settings_.is_on; }
  // Sets is_apart to 1 for each vertex at positions x (m) to which no other part of the sheet is nearer than `reach`
  // (m).
  void find_apart(double reach, const linear::VertexField& x, std::vector<std::uint8_t>& is_apart) {
    self_contact_.find_apart(reach, x, is_apart);
  }
  std::span<const mesh::VertexId> begin_self_contact(double h, int substeps, const Eigen::Vector3d& gravity,
                                                     std::span<const double> inverse_mass,
                                                     const fem::LocalInertia& inertia, fem::State& state) override;
  [[nodiscard]] int next_self_contact() const override { return self_contact_.next_phase(); }
  std::span<const mesh::VertexId> make_self_contact(fem::State& state) override;
  void end_self_contact(fem::State& state) override;
  // Begins to count contact of the sheet with itself; take_self_stats() returns what happened since, in a step that
  // ended at positions x, m.
  void begin_self_stats() { before_ = self_contact_.counters(); }
  fem::SelfContactStats take_self_stats(const linear::VertexField& x);

  [[nodiscard]] bool empty() const { return solver_.empty() && !settings_.is_on; }
  [[nodiscard]] std::int64_t phases() const { return solver_.counters().phases; }
  [[nodiscard]] std::int64_t blocks() const { return solver_.counters().blocks; }

 private:
  friend struct Fields<ContactBridge>;
  contact::ContactSolver solver_;
  contact::SelfContact self_contact_;
  ClusterInertia clusters_;
  scene::SelfContact settings_;
  contact::SelfContactCounters before_;  // see begin_self_stats()
  double half_thickness_ = 0.0;
  bool is_calm_ = false;
  std::vector<mesh::VertexId> excluded_;
  std::vector<std::uint8_t> is_excluded_;  // by vertex: 1 if contact leaves it alone
  linear::VertexField x_before_;           // m, positions at the start of the present substep
};

}  // namespace kerf::sheet
