#pragma once

#include <string>
#include <vector>

#include "server/base/result.h"
#include "server/mesh/mesh_edit.h"
#include "server/mesh/triangle_mesh.h"
#include "server/sheet/command.h"

namespace kerf::sheet {

// Vertices that the regions name on the mesh as it is now: sorted, unique. `regions` must be valid. A vertex counts as
// on an edge of the material bounding box within 1e-9 of the box's size. Errors: kInvalidArgument UNKNOWN_VERTEX with
// the path below `field`.
Result<std::vector<mesh::VertexId>> find_pinned(const mesh::TriangleMesh& mesh, const std::vector<PinRegion>& regions,
                                                const std::string& field);

// Pins after an edit: a new vertex is pinned where everything that it comes from is, so both copies of a split vertex
// and a new vertex on an edge between two pinned ones. Those left without material are not. `pinned`: sorted, unique;
// stays so.
void inherit_pins(const mesh::MeshEdit& edit, std::vector<mesh::VertexId>& pinned);

}  // namespace kerf::sheet
