#pragma once

#include <string>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::wire {

// Scene.mesh. Beside what sheet::validate() will check: CHOICE_MISSING ("mesh"), UNKNOWN_ENUM_VALUE, LENGTH_MISMATCH
// (arrays that do not hold whole points or triangles), for obj and ply those of read_content() with kind OBJ or PLY,
// for an outline FIELD_MISSING ("outline.boundary") and those of decode_curve(). Text and data are moved out of the
// scene.
Result<sheet::MeshSource> decode_mesh_source(v1::Scene& scene, const FileReader& read_file);

// An OBJ file as ObjMesh.text, which is UTF-8 as every string of a message: other bytes than ASCII, which mean nothing
// in an OBJ file but in names and comments, become question marks.
std::string obj_text(std::string file);

void encode_mesh_source(const sheet::MeshSource& mesh, v1::Scene& scene);

}  // namespace kerf::wire
