#pragma once

#include <vector>

#include "server/core/fem/model/model.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::sheet {

// Returns for each vertex the principal strain of the membrane that is largest in magnitude, with its sign (-). If a
// stretch and a compression are equally large, it is the stretch. It is Biot strain: 0.01 is one per cent longer than
// at rest, -0.01 one per cent shorter. It comes from the mean tensor of the triangles around the vertex, weighted by
// their rest areas. 0 for vertices without material. `x`: 3 x V, m.
std::vector<float> dominant_strains(const fem::Model& model, const linear::VertexField& x);

}  // namespace kerf::sheet
