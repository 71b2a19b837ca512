#pragma once

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/wire/scene_codec.h"

namespace kerf::wire {

// Scene.mesh. Beside what sheet::validate() will check: CHOICE_MISSING ("mesh"), UNKNOWN_ENUM_VALUE, LENGTH_MISMATCH
// (arrays that do not hold whole points or triangles), OBJ_FILE_REFUSED, OBJ_TWICE, and the errors of `read_file` with
// field "obj.file".
Result<sheet::MeshSource> decode_mesh_source(const v1::Scene& scene, const FileReader& read_file);

void encode_mesh_source(const sheet::MeshSource& mesh, v1::Scene& scene);

}  // namespace kerf::wire
