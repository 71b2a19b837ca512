#pragma once

#include <string_view>

#include "server/base/result.h"
#include "server/core/mesh/build/mesh_file.h"
#include "server/core/mesh/build/sheet_assembly.h"

namespace kerf::mesh {

// Reads Wavefront OBJ text: v, vt, f, o and g lines (v, v/vt, v//vn, v/vt/vn, negative indices). Lines end with LF, CR
// LF or CR; a backslash at the end joins the next line. Comments and other statements are ignored. Errors name the
// first line in message and field ("obj:17"), and the message lists up to kMaxShownFaults faults:
//   OBJ_TOO_LARGE, OBJ_NUMBER, OBJ_INDEX, OBJ_FACE, OBJ_EMPTY.
// `version`: the first reader ends lines at LF only.
// `faults`: gets the list, if that is the error.
Result<MeshFile> read_obj(std::string_view text, std::int32_t version = kNewestReader, FaultList* faults = nullptr);

// Reads OBJ text and makes a sheet of it. Errors: those of read_obj() and assemble().
Result<ImportedSheet> parse_obj(std::string_view text, const MeshReading& reading = {});

}  // namespace kerf::mesh
