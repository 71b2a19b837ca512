#pragma once

#include <optional>

#include "server/core/mesh/triangle_mesh.h"

namespace kerf::mesh {

// The edge of a triangle opposite its corner `corner`.
struct MeshSide {
  TriangleId triangle = kNone;
  int corner = 0;
};

// Walks straight from the middle of triangle t to the target. Returns the first fixed edge on the way, if there is one.
// Otherwise sets `location` to the place of the target. This is kOutside if the walk did not find it, which rounding
// may cause in a needle.
std::optional<MeshSide> find_wall(const TriangleMesh& mesh, TriangleId t, const LatticePoint& target,
                                  Location& location);

}  // namespace kerf::mesh
