#pragma once

#include <vector>

#include "server/core/cut/view.h"
#include "server/core/cut/view_crossings.h"

namespace kerf::cut {

// Returns the intervals that the view's layer rule selects, shortened if it selects only a part. `intervals`: in the
// order of ViewCrossings, which the result has too.
std::vector<ViewInterval> select_layers(const mesh::TriangleMesh& mesh, const View& view,
                                        std::vector<ViewInterval> intervals);

// Returns true if the camera sees the side on which a solid triangle is counter-clockwise.
bool faces_camera(const mesh::TriangleMesh& mesh, const Screen& screen, mesh::TriangleId triangle);

}  // namespace kerf::cut
