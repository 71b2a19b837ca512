#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/snapshot.h"

namespace kerf::sheet {

// Makes the topology of a sheet for viewers when it is requested, so that cuts without viewers cost nearly nothing
// here. Versions that were never requested are skipped.
class LazyTopology {
 public:
  // Must be called after edits of the mesh.
  void add_edits(std::span<const mesh::MeshEdit* const> edits);
  // Must be called after the mesh was replaced or an edit undone: viewers need the next topology in full.
  void replace();

  // Returns the topology at `version`, which must grow with each call of the functions above. Returns the same object
  // again if the version has not grown since the last call. Slots rewritten since that call, and slots whose piece
  // number changed, get the new version; so do vertices added and moved.
  [[nodiscard]] std::shared_ptr<const Topology> at(const mesh::TriangleMesh& mesh, std::int32_t version) const;

 private:
  mutable std::shared_ptr<const Topology> latest_;   // null: the next topology is made in full
  mutable std::vector<mesh::TriangleId> rewritten_;  // slots rewritten since latest_, may repeat
  mutable std::vector<mesh::VertexId> moved_;        // vertices moved since latest_, may repeat
};

}  // namespace kerf::sheet
