#pragma once

#include "server/core/mesh/mesh_edit.h"
#include "tests/audit/mesh_audit.h"
#include "tests/audit/old_mesh_index.h"

namespace kerf::audit {

// Checks the sources of all vertices that an edit added or moved: the old vertices from which they inherit. Sources are
// old vertices of one old triangle on the right side of every old lip, with weights that give back rest positions. Both
// lips of a new cut inherit bit-identical values. `old_index`: index of `old`.
Finding find_source_flaw(const mesh::MeshData& old, const mesh::MeshData& now, const mesh::MeshEdit& edit,
                         OldMeshIndex& old_index);

}  // namespace kerf::audit
