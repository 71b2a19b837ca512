#pragma once

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/mesh_data.h"

namespace kerf::mesh {

// Makes the rest surface of records that hold only solid triangles so far, with their neighbours. `surface`: 3 x V, m,
// positions of their vertices. Neighbours of one region share a facet if one affine map from the material plane meets
// both within kSameFacet of their longest edge; the records' regions become the numbers of the facets. Error:
// MESH_DEGENERATE_TRIANGLE (flatter than kMinFlatness on the surface), field = `surface`.
Status make_facets(const Eigen::Matrix3Xd& surface, MeshData& data);

}  // namespace kerf::mesh
