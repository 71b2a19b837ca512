#pragma once

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/core/mesh/mesh_records.h"

namespace kerf::mesh {

// Makes the rest surface of records whose solid triangles, all there are so far, know their neighbours: `surface`, 3 x
// V, m, where their vertices lie. Neighbours of one region that a common affine map from the material plane meets
// within kSameFacet of their longest edge share a facet; the records' regions become the numbers of the facets.
// Refused: MESH_DEGENERATE_TRIANGLE (flatter than kMinFlatness on the surface), field = `surface`.
Status make_facets(const Eigen::Matrix3Xd& surface, MeshRecords& records);

}  // namespace kerf::mesh
