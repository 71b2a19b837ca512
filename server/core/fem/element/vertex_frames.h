#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "server/core/fem/element/element_block.h"
#include "server/core/linear/vertex_field.h"

namespace kerf::fem {

// Finds a rotation for each vertex that turns with the sheet around it, at x (3 x V, m). Its columns are two tangents,
// from the area-weighted frames of its triangles, and the normal. It is the identity at vertices without material or
// without a normal. `frames` must have V entries.
void find_vertex_frames(std::span<const ElementBlock> blocks, const linear::VertexField& x,
                        std::vector<Eigen::Matrix3d>& frames);

}  // namespace kerf::fem
