#pragma once

#include <cstdint>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Record of the undo of one edit; the counterpart of MeshEdit. Ids from num_vertices and num_slots on are gone.
struct RevertedEdit {
  std::int32_t num_vertices = 0;  // after
  std::int32_t num_slots = 0;     // after
  // Vertices that are gone, ids consecutive from num_vertices, with the sources that they were made from. Their mass
  // and momentum go back to these sources, which all remain, in the shares given by the weights.
  std::vector<VertexSource> removed_vertices;
  // Vertices whose old rest position is back: fields as sources say, with every field read as it was before the revert.
  std::vector<VertexSource> moved_vertices;
  // Vertices whose removed material is back: fields as sources say, read as it was before the revert. Each is
  // extrapolated from a triangle of the nearest material that was left, so weights may be below 0. The source is the
  // vertex itself if none of its piece was left.
  std::vector<VertexSource> restored_vertices;
  std::vector<TriangleId> rewritten_triangles;  // as in MeshEdit, of the slots that remain; sorted, unique
};

// Returns true if the vertex was a copy of one other, as on a lip, and not a point of its own.
[[nodiscard]] inline bool is_copy(const VertexSource& source) {
  return source.sources[0] == source.sources[1] && source.sources[0] == source.sources[2];
}

// Undoes `edit`, the last edit of `mesh` that is not undone yet, bit for bit. O(touched).
RevertedEdit revert(TriangleMesh& mesh, const CommittedEdit& edit);

}  // namespace kerf::mesh
