#pragma once

#include <cstdint>
#include <span>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Returns the mesh with other regions: labels >= 0, one per slot; those of void slots are not read. Where the rest
// shape is curved, a facet of several regions becomes one facet for each.
TriangleMesh with_regions(const TriangleMesh& mesh, std::span<const std::int32_t> regions);

}  // namespace kerf::mesh
