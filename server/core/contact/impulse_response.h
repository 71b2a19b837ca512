#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/contact/shared_inertia.h"
#include "server/core/mesh/ids.h"

namespace kerf::contact {

// The velocities that impulses on vertices give. Most vertices move alone, by their own mass; groups share inertia.
class ImpulseResponse {
 public:
  // Must be called before begin() after each change of the topology.
  void resize(std::size_t num_vertices);
  // Begins a step. `inverse_mass`: 1/kg, by vertex; 0 is never moved. `shared` may be null, and must outlive the step.
  void begin(std::span<const double> inverse_mass, const SharedInertia* shared);

  // 1/kg, of the vertex alone.
  [[nodiscard]] double inverse_mass(mesh::VertexId v) const { return inverse_mass_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] bool is_shared(mesh::VertexId v) const { return group_[static_cast<std::size_t>(v)] >= 0; }
  // Returns the vertices that share inertia with v, v among them. For vertices that do.
  [[nodiscard]] std::span<const mesh::VertexId> group_of(mesh::VertexId v) const {
    return shared_->vertices(static_cast<std::size_t>(group_[static_cast<std::size_t>(v)]));
  }
  // Returns the speed sum w_i n.v_i (m/s) due to impulses w_i n of 1 N s in all. 1/kg; n is a unit vector.
  [[nodiscard]] double mobility(std::span<const mesh::VertexId> vertices, std::span<const double> weights,
                                const Eigen::Vector3d& normal);
  // Calls change(vertex, velocity) for all vertices that impulses w_i `impulse` (N s) on `vertices` move, with the
  // change of their velocity, m/s. May call it more than once for a vertex.
  template <typename Change>
  void push(std::span<const mesh::VertexId> vertices, std::span<const double> weights, const Eigen::Vector3d& impulse,
            const Change& change) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double inverse = inverse_mass(vertices[i]);
      if (weights[i] == 0.0 || inverse == 0.0) continue;
      if (!is_shared(vertices[i])) {
        change(vertices[i], Eigen::Vector3d(weights[i] * inverse * impulse));
        continue;
      }
      const std::span<const Eigen::Array3d> velocities = velocities_of(vertices[i]);
      const std::span<const mesh::VertexId> group = group_of(vertices[i]);
      for (std::size_t k = 0; k < group.size(); ++k) {
        if (inverse_mass(group[k]) == 0.0) continue;
        change(group[k], Eigen::Vector3d(weights[i] * (velocities[k] * impulse.array()).matrix()));
      }
    }
  }

 private:
  // Returns SharedInertia::respond() of a vertex, computed once a step.
  std::span<const Eigen::Array3d> velocities_of(mesh::VertexId v);

  const SharedInertia* shared_ = nullptr;
  std::vector<double> inverse_mass_;
  std::vector<std::int32_t> group_, place_, first_;  // by vertex: -1 in no group; in it; in velocities_, -1 if not yet
  std::vector<mesh::VertexId> grouped_;
  std::vector<Eigen::Array3d> velocities_;
};

}  // namespace kerf::contact
