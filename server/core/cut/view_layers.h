#pragma once

#include <vector>

#include "server/core/cut/view.h"
#include "server/core/cut/view_crossings.h"

namespace kerf::cut {

// What the view's layer rule leaves of the intervals (in the order of ViewCrossings), shortened where only a part is
// left; in the same order.
std::vector<ViewInterval> select_layers(const mesh::TriangleMesh& mesh, const View& view,
                                        std::vector<ViewInterval> intervals);

// Whether the side on which a solid triangle is counter-clockwise is seen.
bool faces_camera(const mesh::TriangleMesh& mesh, const Screen& screen, mesh::TriangleId triangle);

}  // namespace kerf::cut
