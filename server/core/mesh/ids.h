#pragma once

#include <cstddef>
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

// Most vertices (of the opened mesh) that a sheet may have: importers refuse more, and cuts that would make more.
inline constexpr std::int32_t kMaxVertices = 500'000;

inline constexpr std::size_t kMaxMeshFileBytes = 64u << 20;

// Selects the part of a mesh file that gives the rest shape.
enum class RestShape {
  kAutomatic,  // kFlat where there are texture coordinates or the positions lie in one plane, else kSurface
  kFlat,       // the texture coordinates, metres; without any the positions, which must lie in one plane
  kSurface,    // the positions, however curved; texture coordinates, where there are some, only say where cuts go
};

}  // namespace kerf::mesh
