#include "server/service/wire/mesh_report_codec.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "server/base/text_encoding.h"
#include "server/core/scene/mesh_inspection.h"
#include "server/service/wire/geometry_codec.h"
#include "server/service/wire/mesh_source_codec.h"

namespace kerf::wire {
namespace {

constexpr std::size_t kMaxObjects = 256;
constexpr std::size_t kMaxTextBytes = 1000;  // of a name, a note or a fault

v1::MeshReport encode_report(const scene::MeshInspection& found) {
  v1::MeshReport report;
  report.set_format(found.format);
  report.set_file_vertices(found.file_vertices);
  report.set_file_faces(found.file_faces);
  report.set_num_vertices(found.num_vertices);
  report.set_num_triangles(found.num_triangles);
  report.set_pieces(found.pieces);
  report.set_borders(found.borders);
  if (found.num_vertices > 0) {
    encode_vector(found.extent.min(), *report.mutable_extent()->mutable_min());
    encode_vector(found.extent.max(), *report.mutable_extent()->mutable_max());
  }
  report.set_area_m2(found.area);
  report.set_shortest_edge_m(found.shortest_edge);
  report.set_longest_edge_m(found.longest_edge);
  report.set_flat(found.is_flat);
  report.set_texture_coordinates(found.has_texture);
  for (std::size_t i = 0; i < std::min(found.objects.size(), kMaxObjects); ++i) {
    v1::MeshObject& object = *report.add_objects();
    object.set_name(shortened(found.objects[i].first, kMaxTextBytes));
    object.set_faces(found.objects[i].second);
  }
  for (const std::string& note : found.notes) report.add_notes(shortened(note, kMaxTextBytes));
  for (const std::string& fault : found.faults) report.add_faults(shortened(fault, kMaxTextBytes));
  return report;
}

}  // namespace

Result<v1::MeshReport> inspect_mesh(v1::InspectMeshRequest request) {
  v1::Scene scene;
  if (request.has_obj()) *scene.mutable_obj() = std::move(*request.mutable_obj());
  if (request.has_ply()) *scene.mutable_ply() = std::move(*request.mutable_ply());
  if (!scene.has_obj() && !scene.has_ply()) {
    return invalid_argument("CHOICE_MISSING", "one of obj or ply must be given", "mesh");
  }
  KERF_TRY_ASSIGN(const scene::MeshSource source, decode_mesh_source(scene, {}));
  const auto* const obj = std::get_if<scene::ObjSource>(&source);
  KERF_TRY_ASSIGN(const scene::MeshInspection found,
                  obj != nullptr ? scene::inspect(*obj) : scene::inspect(std::get<scene::PlySource>(source)));
  return encode_report(found);
}

}  // namespace kerf::wire
