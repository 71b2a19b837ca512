#pragma once

#include <cstddef>
#include <vector>

#include "server/core/cut/cut.h"
#include "tests/audit/mesh_audit.h"

namespace kerf::audit {

// Checks that the quality in the report matches the triangles that the cut made. Angles come from side lengths, heights
// from the area. `old_solid`: slots of the old mesh with material.
Finding find_shape_flaw(const mesh::MeshData& old, const mesh::MeshData& now, const std::vector<std::size_t>& old_solid,
                        const cut::CutOutcome& outcome);

}  // namespace kerf::audit
