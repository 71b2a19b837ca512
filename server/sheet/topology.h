#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "server/mesh/mesh_edit.h"
#include "server/mesh/triangle_mesh.h"
#include "server/sheet/snapshot.h"

namespace kerf::sheet {

// The whole mesh as of `version`; no patch from an older version leads to it.
std::shared_ptr<const Topology> full_topology(const mesh::TriangleMesh& mesh, std::int32_t version);

// The mesh after `edits`, which brought it from `previous` to `version`. Slots the edits rewrote and slots whose piece
// number changed get the new version; so do added and moved vertices.
std::shared_ptr<const Topology> edited_topology(const Topology& previous, const mesh::TriangleMesh& mesh,
                                                std::span<const mesh::MeshEdit* const> edits, std::int32_t version);

}  // namespace kerf::sheet
