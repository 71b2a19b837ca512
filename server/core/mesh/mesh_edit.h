#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::mesh {

// Interpolation of the fields of a vertex: any field f of `vertex` becomes sum_k weights[k] * f(sources[k]), with every
// f read as it was before the edit.
struct VertexSource {
  VertexId vertex = kNone;
  std::array<VertexId, 3> sources{kNone, kNone, kNone};  // existed before the edit; may repeat
  Eigen::Vector3d weights{1.0, 0.0, 0.0};                // >= 0, sum 1
};

// Record of one edit of the mesh, in ids that stay valid. cut writes it, fem carries state over with it, stream sends
// topology from it and tests check invariants on it. So two meshes are never compared to find their differences.
struct MeshEdit {
  std::vector<VertexSource> added_vertices;     // ids consecutive from the former num_vertices()
  std::vector<VertexSource> moved_vertices;     // existed before; their rest position changed (relaxation)
  std::vector<TriangleId> rewritten_triangles;  // slots whose vertices, rest shape or solidity changed, or whose
                                                // neighbours did; new slots included; sorted, unique
  std::vector<VertexId> removed_vertices;       // lost all of their material; sorted, unique
  // For each new piece, numbered consecutively from the former num_pieces(): the number of the piece that it was part
  // of before the edit. One part of that piece keeps its number.
  std::vector<std::int32_t> split_from;
  // Numbers of pieces all of whose material was removed, as after the splits, in descending order. One by one each
  // number is given up, and the piece with the highest number then takes it.
  std::vector<std::int32_t> removed_pieces;

  [[nodiscard]] bool empty() const {
    return added_vertices.empty() && moved_vertices.empty() && rewritten_triangles.empty();
  }
};

}  // namespace kerf::mesh
