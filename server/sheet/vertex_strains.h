#pragma once

#include <vector>

#include "server/fem/model.h"
#include "server/mesh/vertex_field.h"

namespace kerf::sheet {

// The principal membrane strain of the largest magnitude at each vertex, the stretch where both are equal (-; Biot, so
// 0.01 is one per cent longer than at rest, -0.01 shorter): that of the mean tensor of the triangles around it,
// weighted with their areas at rest. 0 for vertices without material. `x`: 3 x V, m.
std::vector<float> dominant_strains(const fem::Model& model, const mesh::VertexField& x);

}  // namespace kerf::sheet
