#pragma once

#include <cstdint>

namespace kerf::mesh {

// A vertex of the opened mesh, the one that is simulated and shown: a point on a cut has one vertex for each connected
// sector of triangles around it. Ids are handed out in order; only an undo takes the last ones back.
using VertexId = std::int32_t;

// A slot of the triangle array. A slot keeps its number for the life of the mesh; what it holds may be rewritten. Slots
// that hold no material (the void around the sheet and in its holes) are not solid.
using TriangleId = std::int32_t;

// A point of the welded rest mesh, where all the vertices that cuts have made of it still lie together. Points of the
// void have no vertex. Ids are handed out in order; only an undo takes the last ones back.
using PointId = std::int32_t;

inline constexpr std::int32_t kNone = -1;

}  // namespace kerf::mesh
