#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "server/core/fem/element/bending.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/mesh/ids.h"

namespace kerf::fem {

class BorderClamps;

// Returns the corner of `slot` that is not on its edge to its neighbour `from`.
std::size_t corner_across(const mesh::TriangleMesh& mesh, mesh::TriangleId slot, mesh::TriangleId from);

// Returns the vertices of the bending patch of a slot, as in BendingPatch; all kNone for a slot without material.
std::array<mesh::VertexId, 6> patch_vertices(const RestSheet& sheet, mesh::TriangleId slot);

// Returns the patch of a solid slot of a flat rest shape.
PatchGeometry flat_patch(const RestSheet& sheet, const BorderClamps& clamps, mesh::TriangleId slot);

// Holds where the six vertices of a patch lie on the rest surface, for make_rest_bending(). A patch is bent if it has
// triangles of more than one facet.
struct PatchSurface {
  std::array<Eigen::Vector3d, 6> at;  // m
  bool is_bent = false;
};
// Returns the patch of a solid slot of a curved rest shape, unfolded along its edges.
PatchGeometry curved_patch(const RestSheet& sheet, mesh::TriangleId slot, PatchSurface& surface);

}  // namespace kerf::fem
