#pragma once

#include <cstdint>
#include <memory>

#include "server/mesh/mesh_edit.h"
#include "server/mesh/triangle_mesh.h"
#include "server/sheet/snapshot.h"

namespace kerf::sheet {

// The whole mesh as of `version`; no patch from an older version leads to it.
std::shared_ptr<const Topology> full_topology(const mesh::TriangleMesh& mesh, std::int32_t version);

// The mesh after `edit`, which brought it from `previous` to `version`. Slots the edit rewrote and slots whose piece
// number changed get the new version; so do added and moved vertices.
std::shared_ptr<const Topology> edited_topology(const Topology& previous, const mesh::TriangleMesh& mesh,
                                                const mesh::MeshEdit& edit, std::int32_t version);

}  // namespace kerf::sheet
