// Bytes -> a mesh file, PLY or OBJ -> mesh. Whatever the bytes, the answer is a value, and the mesh is sound.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "server/base/check.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/ply_import.h"
#include "server/core/mesh/build/sheet_assembly.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  mesh::MeshReading reading;
  reading.rest_shape = size % 2 == 0 ? mesh::RestShape::kAutomatic : mesh::RestShape::kSurface;
  reading.version = mesh::kFirstReader + static_cast<std::int32_t>(size % mesh::kNewestReader);
  const Result<mesh::MeshFile> parts =
      file.starts_with("ply") ? mesh::read_ply(file) : mesh::read_obj(file, reading.version);
  if (!parts.ok()) {
    KERF_CHECK(!parts.error().reason.empty() && !parts.error().message.empty(), "a refusal says why");
    return 0;
  }
  const Result<mesh::FileSheet> made = mesh::make_sheet(*parts, reading);
  if (made.ok()) KERF_CHECK(!made->mesh.find_violation(), "the mesh is sound");
  const Result<mesh::ImportedSheet> sheet = mesh::assemble(*parts, reading);
  if (!sheet.ok()) {
    KERF_CHECK(!sheet.error().reason.empty() && !sheet.error().message.empty(), "a refusal says why");
    return 0;
  }
  const bool is_curved = sheet->sheet.surface.cols() > 0;
  KERF_CHECK((is_curved ? sheet->sheet.surface : sheet->world).cols() == sheet->world.cols() &&
                 (sheet->sheet.rest.cols() == sheet->world.cols() || (is_curved && sheet->sheet.rest.cols() == 0)),
             "a place for each vertex");
  const Result<mesh::TriangleMesh> built = mesh::import_mesh(sheet->sheet);
  if (built.ok()) KERF_CHECK(!built->find_violation(), "the mesh is sound");
  return 0;
}
