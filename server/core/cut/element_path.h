#pragma once

#include "server/core/cut/curve.h"
#include "server/core/cut/path_scale.h"
#include "server/core/cut/simplify.h"

namespace kerf::cut {

// The path of Method::kElement: the curve's crossings with the edges of the mesh joined by chords, as the source has
// it, with the point of largest curvature added in an element where the chord is longer than the segment between the
// middles of the two edges crossed, and further points where the tolerance asks for them. `curve`: flattened to less
// than the tolerance. One of straight pieces (deviation 0) keeps all its points.
ScaledCurve element_path(const mesh::TriangleMesh& mesh, const FlatCurve& curve, const PathScale& scale);

}  // namespace kerf::cut
