#pragma once

#include <cstdint>
#include <span>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Returns a copy of the mesh with other regions. `regions`: one label >= 0 per slot; those of void slots are ignored.
// If the rest shape is curved, a facet with several of the new regions is divided into one facet for each.
TriangleMesh with_regions(const TriangleMesh& mesh, std::span<const std::int32_t> regions);

}  // namespace kerf::mesh
