#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/simplify.h"

namespace kerf::cut {

// Makes the path of Method::kElement: chords between the crossings of the curve with the edges of the mesh. If a chord
// is longer than the line between the middles of the two crossed edges, the curve's point of largest curvature is
// added. More points are added if the tolerance requires them. `curve`: flattened finer than the tolerance. A curve of
// straight pieces (deviation_m 0) keeps all its points.
ScaledCurve element_path(const mesh::TriangleMesh& mesh, const FlatCurve& curve, const PathScale& scale);

}  // namespace kerf::cut
