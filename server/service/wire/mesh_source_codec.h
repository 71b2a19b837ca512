#pragma once

#include <string>

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::wire {

// Decode the mesh of a scene or a component; move text and data out of it. Errors, besides those that scene::validate()
// will find:
//   CHOICE_MISSING ("mesh"), UNKNOWN_ENUM_VALUE
//   LENGTH_MISMATCH  arrays that do not hold whole points or triangles
//   obj and ply      those of read_content() with kind OBJ or PLY
//   outline          FIELD_MISSING ("outline.boundary") and those of decode_curve()
Result<scene::MeshSource> decode_mesh_source(v1::Scene& scene, const FileReader& read_file);
Result<scene::MeshSource> decode_mesh_source(v1::Component& component, const FileReader& read_file);

// Returns the content of a mesh file, decompressed if gzip compressed it. Errors: `kind`_MALFORMED, `kind`_TOO_LARGE.
Result<std::string> unpacked_mesh(std::string file, const std::string& kind, const std::string& field);

// Converts an OBJ file to ObjMesh.text, which must be UTF-8 (see utf8_text).
std::string obj_text(std::string file);

// Names the first reader where a recorded or stored scene names none: it was made before there were others.
void name_first_reader(v1::Scene& scene);

void encode_mesh_source(const scene::MeshSource& mesh, v1::Scene& scene);
void encode_mesh_source(const scene::MeshSource& mesh, v1::Component& component);

}  // namespace kerf::wire
