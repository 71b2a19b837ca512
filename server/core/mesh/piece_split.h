#pragma once

#include <span>
#include <vector>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Returns all but one of the components that a piece has fallen into, each as the list of its slots. `seeds` are solid
// slots beside fresh cuts, at least one in each component that a cut has made. Grows all components at once, one slot
// each in turn, and merges those that meet. Stops in a piece when only one component still grows. So the cost is that
// of the smaller components. A cut that separates nothing costs about as much as the way around its tip.
std::vector<std::vector<TriangleId>> split_off_components(const TriangleMesh& mesh, std::span<const TriangleId> seeds);

}  // namespace kerf::mesh
