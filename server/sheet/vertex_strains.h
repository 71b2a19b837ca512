#pragma once

#include <vector>

#include "server/fem/model.h"
#include "server/mesh/vertex_field.h"

namespace kerf::sheet {

// The largest principal membrane strain at each vertex (-; Biot, so 0.01 is one per cent longer than at rest; below 0
// where the sheet is shorter in every direction): that of the mean tensor of the triangles around it, weighted with
// their areas at rest. 0 for vertices without material. `x`: 3 x V, m.
std::vector<float> largest_strains(const fem::Model& model, const mesh::VertexField& x);

}  // namespace kerf::sheet
