#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/simplify.h"

namespace kerf::cut {

// Makes the path of Method::kElement: chords join the curve's crossings with the edges of the mesh, as in the source.
// An element gets the point of largest curvature if its chord is longer than the segment between the middles of the two
// crossed edges. Further points are added where the tolerance requires them. `curve`: flattened to less than the
// tolerance. One of straight pieces (deviation 0) keeps all its points.
ScaledCurve element_path(const mesh::TriangleMesh& mesh, const FlatCurve& curve, const PathScale& scale);

}  // namespace kerf::cut
