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
  // The mesh has made these edits.
  void note(std::span<const mesh::MeshEdit* const> edits);
  // The mesh is another one: no patch leads from what viewers have to it.
  void replace();

  // The mesh as of `version`, which has grown with each call of the above. Of a version that was asked for before it is
  // the same object. Slots that edits since the last one rewrote and slots whose piece number changed have the new
  // version; so do vertices added and moved.
  [[nodiscard]] std::shared_ptr<const Topology> at(const mesh::TriangleMesh& mesh, std::int32_t version) const;

 private:
  mutable std::shared_ptr<const Topology> latest_;   // null: to be made in full
  mutable std::vector<mesh::TriangleId> rewritten_;  // since then; may repeat
  mutable std::vector<mesh::VertexId> moved_;        // since then; may repeat
};

}  // namespace kerf::sheet
