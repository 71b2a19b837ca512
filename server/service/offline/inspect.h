#pragma once

#include <string>

#include "kerf/v1/files.pb.h"
#include "server/base/disk.h"
#include "server/base/result.h"

// Describes files without a server.
namespace kerf::offline {

enum class FileKind { kObj, kPly, kSvg, kDxf };

// Tells the kind of a file by its first bytes, and where these leave a doubt by the end of its name. Files that gzip
// compressed count as what they hold. Those of unknown kind, and those that cannot be read, count as OBJ.
FileKind kind_of_file(Disk& disk, const std::string& path);

// Describes a mesh file, as FileService.InspectMesh does.
Result<v1::MeshReport> inspect_mesh(v1::InspectMeshRequest request);

}  // namespace kerf::offline
