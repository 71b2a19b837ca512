#pragma once

#include <optional>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// Edge `corner`, the one opposite that corner, of a triangle.
struct MeshSide {
  TriangleId triangle = kNone;
  int corner = 0;
};

// Walks straight from the middle of t to the target. Returns the first fixed edge on the way, or fills `location`
// (kOutside if the walk lost its way, which rounding may cause in a needle).
std::optional<MeshSide> find_wall(const TriangleMesh& mesh, TriangleId t, const LatticePoint& target,
                                  Location& location);

}  // namespace kerf::mesh
