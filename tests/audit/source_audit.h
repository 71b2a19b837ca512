#pragma once

#include "server/core/mesh/mesh_edit.h"
#include "tests/audit/mesh_audit.h"
#include "tests/audit/old_mesh_index.h"

namespace kerf::audit {

// Checks what the vertices that an edit added or moved are said to inherit from. Sources are old vertices of one old
// triangle on the right side of every old lip, with weights that give back rest positions. Both lips of a new cut
// inherit the same bits. `old_index`: of `old`.
Finding find_source_flaw(const mesh::MeshData& old, const mesh::MeshData& now, const mesh::MeshEdit& edit,
                         OldMeshIndex& old_index);

}  // namespace kerf::audit
