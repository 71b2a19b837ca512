#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "server/base/result.h"
#include "server/mesh/mesh_import.h"

namespace kerf::mesh {

inline constexpr std::size_t kMaxObjBytes = 64u << 20;
inline constexpr std::size_t kMaxObjLineBytes = 4096;
inline constexpr int kMaxObjFaceCorners = 64;

// What an OBJ file says, for import_mesh and for the state to start from.
struct ObjSheet {
  IndexedMesh sheet;                        // rest shape, m
  Eigen::Matrix3Xd world;                   // 3 x V, m, where the vertices start
  std::vector<std::int32_t> obj_positions;  // V, the `v` line (from 0) each vertex comes from
};

// Reads Wavefront OBJ text: v, vt and f lines (v, v/vt, v//vn, v/vt/vn, negative indices, polygons split as fans);
// comments and other statements are ignored. If every face corner has a texture coordinate, these are the rest shape
// in metres, and a position used with two texture coordinates becomes two vertices (a seam). Else the positions must
// lie in one plane, which gives the rest shape; a plane close to x-y keeps x, y as they are. Vertices are numbered in
// the order of their v lines, then of their vt lines; positions without a face are dropped. Refusals name the line in
// message and field ("obj:17"):
//   OBJ_TOO_LARGE, OBJ_LINE_TOO_LONG, OBJ_NUMBER, OBJ_INDEX, OBJ_FACE, OBJ_MIXED_TEXTURE, OBJ_EMPTY, OBJ_NOT_PLANAR.
Result<ObjSheet> parse_obj(std::string_view text);

}  // namespace kerf::mesh
