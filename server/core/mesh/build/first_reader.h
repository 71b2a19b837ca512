#pragma once

#include "server/base/result.h"
#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/build/sheet_assembly.h"

namespace kerf::mesh {

// Makes a sheet as Kerf did before it mended mesh files, for recordings and stores of that time. No vertices are
// joined, and polygons are fans. Errors: MIXED_TEXTURE (some corners have a texture coordinate, others do not),
// NOT_PLANAR.
Result<ImportedSheet> assemble_as_first(const MeshFile& file, RestShape rest_shape);

}  // namespace kerf::mesh
