#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::contact {

// Groups of vertices that share inertia, as those of tiny triangles do: an impulse on one of them moves all.
class SharedInertia {
 public:
  virtual ~SharedInertia() = default;
  [[nodiscard]] virtual std::size_t num_groups() const = 0;
  // No vertex is in two groups.
  [[nodiscard]] virtual std::span<const mesh::VertexId> vertices(std::size_t group) const = 0;
  // Sets, for each of vertices(group), the velocity along x, y and z (m/s) due to an impulse of 1 N s along that axis
  // on the vertex at `place` of them.
  virtual void respond(std::size_t group, std::size_t place, std::span<Eigen::Array3d> velocities) const = 0;
};

}  // namespace kerf::contact
