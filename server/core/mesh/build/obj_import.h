#pragma once

#include <string_view>

#include "server/base/result.h"
#include "server/core/mesh/build/face_list.h"

namespace kerf::mesh {

inline constexpr std::size_t kMaxObjLineBytes = 4096;

// Reads Wavefront OBJ text: v, vt and f lines (v, v/vt, v//vn, v/vt/vn, negative indices, polygons split as fans);
// comments and other statements are ignored. For the rest shape see FaceList::assemble. Errors name the line in message
// and field ("obj:17"):
//   OBJ_TOO_LARGE, OBJ_LINE_TOO_LONG, OBJ_NUMBER, OBJ_INDEX, OBJ_FACE, OBJ_MIXED_TEXTURE, OBJ_EMPTY, OBJ_NOT_PLANAR.
Result<ImportedSheet> parse_obj(std::string_view text, RestShape rest_shape = RestShape::kAutomatic);

}  // namespace kerf::mesh
