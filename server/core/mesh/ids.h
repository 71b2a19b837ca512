#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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

// Versions of the reader of mesh files. Recordings and stores name the one that made their sheet, so that it is made
// again with every bit. The first joins no vertices, mends nothing and splits polygons as fans. The second joins
// vertices to each other, not to sides in which they lie.
inline constexpr std::int32_t kFirstReader = 1;
inline constexpr std::int32_t kSecondReader = 2;
inline constexpr std::int32_t kNewestReader = 3;

// Names the axis of the file that points up in the world.
enum class UpAxis {
  kZ,
  kY,  // x, y, z of the file become x, -z, y
  kX,  // x, y, z of the file become -z, y, x
};

// Chooses how a mesh file becomes a sheet. The first reader knows the rest shape alone.
struct MeshReading {
  RestShape rest_shape = RestShape::kAutomatic;
  double unit_m = 1.0;  // m, 1e-9..1e6; metres of a unit of the file, also of its texture coordinates
  UpAxis up_axis = UpAxis::kZ;
  // Joins vertices at most this far apart in space and in the chart, m, 0..1e4; absent: as exactly as the file's
  // numbers are written. Joins vertices to sides of other faces, too. 0 keeps equal places apart, as lips of a cut.
  std::optional<double> join_m = std::nullopt;
  bool ignore_texture = false;            // as if the file had no texture coordinates
  std::vector<std::string> objects = {};  // OBJ: names of the objects and groups that are read, at most 64; none: all
  std::int32_t version = kNewestReader;

  friend bool operator==(const MeshReading&, const MeshReading&) = default;
};

}  // namespace kerf::mesh
