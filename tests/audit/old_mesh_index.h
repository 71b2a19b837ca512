#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "server/core/mesh/mesh_data.h"
#include "tests/audit/box_grid.h"
#include "tests/audit/exact_geometry.h"

namespace kerf::audit {

// Finds the solid triangles and edges of a mesh as it was before a cut.
class OldMeshIndex {
 public:
  explicit OldMeshIndex(const mesh::MeshData& data);

  [[nodiscard]] const std::vector<std::size_t>& solid_slots() const { return solid_; }
  [[nodiscard]] const std::vector<std::size_t>& solid_slots_at(mesh::PointId p) const { return corners_at_[index(p)]; }
  // Calls `visit(record)` for each solid triangle whose box touches `box` (lattice units).
  template <typename Visit>
  void for_touching(const Eigen::AlignedBox2d& box, const Visit& visit) {
    grid_.for_touching(box, [&](std::size_t i) { visit(data_.triangles[solid_[i]], solid_[i]); });
  }

  enum class EdgeKind { kAbsent, kInner, kOpen };
  // Returns the kind of the side from a to b of a solid triangle; kAbsent if no solid triangle has this side.
  [[nodiscard]] EdgeKind edge_kind(mesh::VertexId a, mesh::VertexId b) const;
  // Returns true if a solid triangle has these corners, given in ascending order.
  [[nodiscard]] bool has_triangle(const std::array<mesh::VertexId, 3>& sorted) const;

 private:
  using Edge = std::pair<std::pair<mesh::VertexId, mesh::VertexId>, bool>;  // from, to; open

  const mesh::MeshData& data_;
  std::vector<std::size_t> solid_;
  BoxGrid grid_;                                        // over the triangles of solid_
  std::vector<std::vector<std::size_t>> corners_at_;    // indices of solid slots, by point
  std::vector<Edge> edges_;                             // sorted
  std::vector<std::array<mesh::VertexId, 3>> corners_;  // of solid triangles; sorted, as is each entry
};

}  // namespace kerf::audit
