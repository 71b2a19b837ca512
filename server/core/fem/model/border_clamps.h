#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/element/bending_edge.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/linear/row_store.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

// The clamps of a flat sheet. A border edge is clamped if both its ends are.
class BorderClamps {
 public:
  BorderClamps() = default;
  // `clamps` is sorted by vertex and unique.
  explicit BorderClamps(std::vector<Clamp> clamps) : clamps_(std::move(clamps)) {}

  [[nodiscard]] bool empty() const { return clamps_.empty(); }
  // Returns the derivative of x by the material coordinates that clamps hold at edge `k` of a solid slot. Returns
  // nothing if the edge is not clamped.
  [[nodiscard]] std::optional<Eigen::Matrix<double, 3, 2>> gradient_at(const RestSheet& sheet, mesh::TriangleId slot,
                                                                       std::size_t k) const;
  // Returns the slope h x_nu that is held at each edge of a solid slot (see fit_bending), m; 0 at edges without a
  // clamp.
  [[nodiscard]] std::array<Eigen::Vector3d, 3> held_slopes(const RestSheet& sheet, mesh::TriangleId slot) const;
  // Adds the slots around the clamped vertices to `slots`, with repetitions. Vertices that the elements do not have are
  // left out.
  void add_slots(const RestElements& elements, std::vector<mesh::TriangleId>& slots) const;

 private:
  [[nodiscard]] const Clamp* find(mesh::VertexId vertex) const;

  std::vector<Clamp> clamps_;  // sorted by vertex
};

// Returns the forces of clamps on a sheet with these patches and edge terms, both by slot.
ClampForces make_clamp_forces(const RestSheet& sheet, const BorderClamps& clamps, std::span<const BendingPatch> patches,
                              const linear::RowStore<BendingEdge>& edges);

// Returns a moment along the border edge opposite corner `edge` of a solid slot; see EdgeMoment. `moment_per_length` is
// in N m per m of the edge at rest. It is valid until the mesh or the clamps change. On a clamped edge it has no
// effect, since the clamp carries it. On a curved rest shape, or without bending, the slope is that of the triangle
// alone.
EdgeMoment make_edge_moment(const RestSheet& sheet, const BorderClamps& clamps, mesh::TriangleId slot, int edge,
                            double moment_per_length);

}  // namespace kerf::fem
