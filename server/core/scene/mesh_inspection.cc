#include "server/core/scene/mesh_inspection.h"

#include <algorithm>
#include <limits>

#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/ply_import.h"

namespace kerf::scene {
namespace {

void measure(const mesh::FileSheet& sheet, MeshInspection& report) {
  const mesh::TriangleMesh& made = sheet.mesh;
  report.num_vertices = made.num_vertices();
  report.num_triangles = made.num_solid_triangles();
  report.pieces = made.num_pieces();
  report.borders = static_cast<std::int32_t>(made.num_boundary_loops());
  report.is_flat = !made.is_curved();
  report.has_texture = sheet.imported.is_charted;
  report.shortest_edge = std::numeric_limits<double>::infinity();
  const Eigen::Matrix3Xd& world = sheet.imported.world;
  for (Eigen::Index v = 0; v < world.cols(); ++v) report.extent.extend(Eigen::Vector3d(world.col(v)));
  for (mesh::TriangleId t = 0; t < report.num_triangles; ++t) {
    report.area += made.area(t);
    const std::array<mesh::VertexId, 3>& corners = made.vertices(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::VertexId a = corners[k], b = corners[(k + 1) % 3];
      const double length = report.is_flat ? (made.rest_position(a) - made.rest_position(b)).norm()
                                           : (world.col(a) - world.col(b)).norm();
      report.shortest_edge = std::min(report.shortest_edge, length);
      report.longest_edge = std::max(report.longest_edge, length);
    }
  }
}

Result<MeshInspection> inspect(const Result<mesh::MeshFile>& file, const mesh::FaultList& in_reading,
                               const std::string& format, const mesh::MeshReading& reading) {
  MeshInspection report;
  report.format = format;
  if (!file.ok()) {
    if (in_reading.empty()) return file.error();
    report.faults = in_reading.lines();
    return report;
  }
  report.format = file->format;
  report.file_vertices = static_cast<std::int32_t>(file->positions.size());
  report.file_faces = static_cast<std::int32_t>(file->faces.size());
  report.objects = file->object_sizes();
  mesh::FaultList faults;
  const Result<mesh::FileSheet> sheet = mesh::make_sheet(*file, reading, &faults);
  if (sheet.ok()) {
    report.notes = sheet->imported.notes;
    measure(*sheet, report);
  } else {
    report.faults = faults.empty() ? std::vector<std::string>{sheet.error().message} : faults.lines();
  }
  return report;
}

}  // namespace

Result<MeshInspection> inspect(const ObjSource& obj) {
  KERF_TRY(validate(MeshSource(obj)));
  mesh::FaultList faults;
  return inspect(mesh::read_obj(obj.text, obj.reading.version, &faults), faults, "OBJ", obj.reading);
}

Result<MeshInspection> inspect(const PlySource& ply) {
  KERF_TRY(validate(MeshSource(ply)));
  mesh::FaultList faults;
  return inspect(mesh::read_ply(ply.data, &faults), faults, "PLY", ply.reading);
}

}  // namespace kerf::scene
