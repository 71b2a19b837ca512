#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/core/mesh/mesh_edit.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/snapshot.h"

namespace kerf::sheet {

// The topology of a sheet as viewers get it, made when one is asked for: a cut that nobody watches pays nothing for it.
// Versions in between that nobody asked for are passed over.
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
