#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "server/core/mesh/ids.h"

namespace kerf::mesh {

// Says how to set the fields of a vertex after an edit: f(vertex) = sum_k weights[k] * f(sources[k]), for any field f.
// All f on the right are values before the edit.
struct VertexSource {
  VertexId vertex = kNone;
  std::array<VertexId, 3> sources{kNone, kNone, kNone};  // vertices from before the edit; may repeat
  Eigen::Vector3d weights{1.0, 0.0, 0.0};                // >= 0, sum 1
};

// Record of one edit of the mesh, in ids that stay valid. The finite elements carry state over with it, and streams
// send topology from it, so meshes are never compared to find differences.
struct MeshEdit {
  std::vector<VertexSource> added_vertices;     // ids consecutive from num_vertices() before the edit
  std::vector<VertexSource> moved_vertices;     // vertices from before the edit that relaxation moved in material space
  std::vector<TriangleId> rewritten_triangles;  // new slots, and slots whose vertices, rest shape, neighbours or
                                                // solidity changed; sorted, unique
  std::vector<VertexId> removed_vertices;       // vertices that lost all their material; sorted, unique
  // For each new piece, the number of the piece that it was part of before the edit. New pieces are numbered
  // consecutively from num_pieces() before the edit. One part of a divided piece keeps its number.
  std::vector<std::int32_t> split_from;
  // Numbers of pieces that lost all their material, in descending order. They are numbers after the splits above. To
  // follow the renumbering, go through the list: the piece with the highest number takes the number that is removed.
  std::vector<std::int32_t> removed_pieces;

  [[nodiscard]] bool empty() const {
    return added_vertices.empty() && moved_vertices.empty() && rewritten_triangles.empty();
  }
};

}  // namespace kerf::mesh
