#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/snapshot.h"

namespace kerf::sheet {

// Makes the topology of a sheet for viewers on demand, so that a cut without viewers costs nothing here. Versions that
// were never requested are skipped.
class LazyTopology {
 public:
  // Notes edits that the mesh has made.
  void add_edits(std::span<const mesh::MeshEdit* const> edits);
  // Notes that the mesh was replaced: no patch leads to it from a topology that viewers have.
  void replace();

  // Returns the topology at `version`, which must grow with each call of the functions above. Returns the same object
  // again if the version has not grown since the last call. Slots rewritten since that call, and slots whose piece
  // number changed, get the new version; so do vertices added and moved.
  [[nodiscard]] std::shared_ptr<const Topology> at(const mesh::TriangleMesh& mesh, std::int32_t version) const;

 private:
  mutable std::shared_ptr<const Topology> latest_;   // null: to be made in full
  mutable std::vector<mesh::TriangleId> rewritten_;  // since then; may repeat
  mutable std::vector<mesh::VertexId> moved_;        // since then; may repeat
};

}  // namespace kerf::sheet
