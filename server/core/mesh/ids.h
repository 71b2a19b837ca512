#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf::mesh {

// A vertex of the opened mesh, the one that is simulated and shown. A point on a cut has one vertex for each connected
// sector of triangles around it. Ids count up from 0; only an undo removes the last ones.
using VertexId = std::int32_t;

// A slot: a place in the triangle array. Its number never changes, but the triangle in it may be replaced. A slot is
// solid if its triangle has material; the others are void and fill the surroundings and holes of the sheet.
using TriangleId = std::int32_t;

// A point of the welded mesh, in material space. All vertices that cuts have made of it lie at this one point. Points
// inside the void have no vertex. Ids count up from 0; only an undo removes the last ones.
using PointId = std::int32_t;

inline constexpr std::int32_t kNone = -1;

// Most vertices of the opened mesh that a sheet may have. Importers refuse larger sheets, and cuts that would need more
// are refused.
inline constexpr std::int32_t kMaxVertices = 500'000;

inline constexpr std::size_t kMaxMeshFileBytes = 64u << 20;

// Selects the part of a mesh file that gives the rest shape.
enum class RestShape {
  kAutomatic,  // kFlat where there are texture coordinates or the positions lie in one plane, else kSurface
  kFlat,       // the texture coordinates, metres; without any the positions, which must lie in one plane
  kSurface,    // the positions, however curved; texture coordinates, if any, are only the chart that cuts are drawn in
};

}  // namespace kerf::mesh
