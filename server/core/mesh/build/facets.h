#pragma once

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/build/element_names.h"
#include "server/core/mesh/mesh_data.h"

namespace kerf::mesh {

// Makes the facets of a curved rest shape: groups of triangles that one affine map takes from the material plane to
// `surface`. `surface`: 3 x V, m, positions of the vertices. `data` must hold only solid triangles, with their
// neighbours. A triangle joins the facet of a neighbour of its region if that facet's map meets its corners. The
// tolerance is kSameFacet times its longest edge. Afterwards TriangleRecord::region is the number of the facet. Error:
// MESH_DEGENERATE_TRIANGLE (flatter than kMinFlatness on the surface), field = `surface`.
Status make_facets(const Eigen::Matrix3Xd& surface, MeshData& data, const ElementNames& names);

}  // namespace kerf::mesh
