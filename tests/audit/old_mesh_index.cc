#include "tests/audit/old_mesh_index.h"

#include <algorithm>

namespace kerf::audit {

OldMeshIndex::OldMeshIndex(const mesh::MeshData& data) : data_(data), grid_({}), corners_at_(data.points.size()) {
  std::vector<Eigen::AlignedBox2d> boxes;
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const mesh::TriangleRecord& r = data.triangles[t];
    if (!is_solid(r)) continue;
    Eigen::AlignedBox2d box;
    for (std::size_t k = 0; k < 3; ++k) {
      box.extend(as_vector(data.points[index(r.points[k])].at));
      corners_at_[index(r.points[k])].push_back(t);
      const bool is_open = (r.locks[k] & (mesh::kLockCut | mesh::kLockBorder)) != 0;
      edges_.push_back({{r.vertices[(k + 1) % 3], r.vertices[(k + 2) % 3]}, is_open});
    }
    boxes.push_back(box);
    solid_.push_back(t);
    corners_.push_back(r.vertices);
    std::sort(corners_.back().begin(), corners_.back().end());
  }
  std::sort(edges_.begin(), edges_.end());
  std::sort(corners_.begin(), corners_.end());
  grid_ = BoxGrid(std::move(boxes));
}

OldMeshIndex::EdgeKind OldMeshIndex::edge_kind(mesh::VertexId a, mesh::VertexId b) const {
  const auto found = std::lower_bound(edges_.begin(), edges_.end(), Edge{{a, b}, false});
  if (found == edges_.end() || found->first != std::pair{a, b}) return EdgeKind::kAbsent;
  return found->second ? EdgeKind::kOpen : EdgeKind::kInner;
}

bool OldMeshIndex::has_triangle(const std::array<mesh::VertexId, 3>& sorted) const {
  return std::binary_search(corners_.begin(), corners_.end(), sorted);
}

}  // namespace kerf::audit
