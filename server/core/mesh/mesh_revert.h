#pragma once

#include <cstdint>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Record of the undo of one edit, the counterpart of MeshEdit. Vertices from num_vertices on and slots from num_slots
// on no longer exist.
struct RevertedEdit {
  std::int32_t num_vertices = 0;  // number of vertices after the undo
  std::int32_t num_slots = 0;     // number of slots after the undo
  // Vertices that no longer exist, ids consecutive from num_vertices, with the sources from which the edit made them.
  // Their mass and momentum go back to these sources, which all remain, in the shares given by the weights.
  std::vector<VertexSource> removed_vertices;
  // Vertices back at their old rest position, and how to set their fields; source fields are values before the undo.
  std::vector<VertexSource> moved_vertices;
  // Vertices whose removed material is back, and how to set their fields; source fields are values before the undo.
  // Each is extrapolated from a triangle of the nearest material that the edit had left, so weights may be negative. If
  // nothing of its piece was left, the source is the vertex itself.
  std::vector<VertexSource> restored_vertices;
  std::vector<TriangleId> rewritten_triangles;  // as in MeshEdit, without slots that no longer exist; sorted, unique
};

// Returns true if the vertex was made as a copy of a single vertex, as on a lip, and not at a new point.
[[nodiscard]] inline bool is_copy(const VertexSource& source) {
  return source.sources[0] == source.sources[1] && source.sources[0] == source.sources[2];
}

// Undoes `edit` bit for bit; it must be the last edit of `mesh` that is not undone yet. Costs O(records touched by the
// edit).
RevertedEdit revert(TriangleMesh& mesh, const CommittedEdit& edit);

}  // namespace kerf::mesh
