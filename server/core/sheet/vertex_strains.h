#pragma once

#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::sheet {

// The maximum absolute principal strain of the membrane at each vertex, with its sign; the stretch if both are equal
// (-; Biot, so 0.01 is one per cent longer than at rest, -0.01 shorter). It is that of the mean tensor of the triangles
// around it, weighted with their areas at rest. 0 for vertices without material. `x`: 3 x V, m.
std::vector<float> dominant_strains(const fem::Model& model, const mesh::VertexField& x);

}  // namespace kerf::sheet
