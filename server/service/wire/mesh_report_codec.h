#pragma once

#include "kerf/v1/files.pb.h"
#include "server/base/result.h"

namespace kerf::wire {

// Describes the mesh file of a request; moves its content out of it. Errors: CHOICE_MISSING without a file, those of
// decode_mesh_source(), and of scene::inspect(), with the fields of the request.
Result<v1::MeshReport> inspect_mesh(v1::InspectMeshRequest request);

}  // namespace kerf::wire
