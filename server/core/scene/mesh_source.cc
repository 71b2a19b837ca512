#include "server/core/scene/mesh_source.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/base/check.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/ply_import.h"
#include "server/core/scene/components.h"
#include "server/core/scene/outline_source.h"

namespace kerf::scene {

namespace {

Error with_field(Error error, std::string field) {
  error.field = std::move(field);
  return error;
}

Result<SourceMesh> build(const GridSource& grid, std::int32_t /*max_vertices*/) {
  mesh::GridConfig config;
  config.num_x = grid.columns;
  config.num_y = grid.rows;
  config.width = grid.width;
  config.height = grid.height;
  Result<mesh::TriangleMesh> built = grid.pattern == GridPattern::kJitteredDelaunay
                                         ? mesh::make_jittered_grid(config, grid.seed)
                                         : mesh::make_grid(config);
  if (!built.ok()) return with_field(built.error(), "grid");
  return SourceMesh{std::move(built).value(), {}, {}, {}};
}

// Builds a mesh from the content of a file. Positions need no check against the limits of the world, as those of the
// reader are tighter.
Result<SourceMesh> build(const Result<mesh::MeshFile>& file, const mesh::MeshReading& reading,
                         const std::string& field) {
  if (!file.ok()) return with_field(file.error(), field);
  Result<mesh::FileSheet> made = mesh::make_sheet(*file, reading);
  if (!made.ok()) return with_field(made.error(), field);
  mesh::ImportedSheet& imported = made->imported;
  return SourceMesh{std::move(made->mesh), std::move(imported.world), std::move(imported.sheet.surface),
                    std::move(imported.notes)};
}

Result<SourceMesh> build(const ObjSource& obj, std::int32_t /*max_vertices*/) {
  return build(mesh::read_obj(obj.text, obj.reading.version), obj.reading, "obj.text");
}

Result<SourceMesh> build(const PlySource& ply, std::int32_t /*max_vertices*/) {
  return build(mesh::read_ply(ply.data), ply.reading, "ply.data");
}

Result<SourceMesh> build(const ArraySource& arrays, std::int32_t /*max_vertices*/) {
  mesh::IndexedMesh indexed;
  indexed.rest = arrays.material_positions;
  indexed.triangles = arrays.triangles;
  indexed.surface = arrays.rest_positions;
  Result<mesh::TriangleMesh> built = mesh::import_mesh(indexed);
  if (!built.ok()) {
    const std::string& field = built.error().field;
    return with_field(built.error(), field == "rest"      ? "inline.material_positions"
                                     : field == "surface" ? "inline.rest_positions"
                                                          : "inline.triangles");
  }
  const Eigen::Matrix3Xd& given = arrays.positions.cols() > 0 ? arrays.positions : arrays.rest_positions;
  return SourceMesh{std::move(built).value(), given, arrays.rest_positions, {}};
}

Result<SourceMesh> build(const OutlineSource& outline, std::int32_t max_vertices) {
  KERF_TRY_ASSIGN(mesh::TriangleMesh built, mesh_outline(outline, max_vertices));
  return SourceMesh{std::move(built), {}, {}, {}};
}

}  // namespace

MaterialPoint BuiltMesh::at(const Eigen::Vector2d& material) const {
  const std::optional<MaterialPoint> found = find_material_point(mesh, material);
  return found ? *found : nearest_material_point(mesh, material);
}

Eigen::Matrix<double, 3, 2> BuiltMesh::gradient_at(const MaterialPoint& point) const {
  const std::array<mesh::VertexId, 3>& corner = point.vertices;
  Eigen::Matrix2d rest;
  rest << mesh.rest_position(corner[1]) - mesh.rest_position(corner[0]),
      mesh.rest_position(corner[2]) - mesh.rest_position(corner[0]);
  Eigen::Matrix<double, 3, 2> edges;
  edges << positions.col(corner[1]) - positions.col(corner[0]), positions.col(corner[2]) - positions.col(corner[0]);
  return edges * rest.inverse();
}

double BuiltMesh::size() const {
  if (components.empty()) return mesh.bounding_box().sizes().maxCoeff();
  double largest = 0.0;
  for (const ComponentPlace& component : components) largest = std::max(largest, component.extent.sizes().maxCoeff());
  return largest;
}

Result<SourceMesh> build_source(const MeshSource& source, std::int32_t max_vertices) {
  Result<SourceMesh> built = std::visit([&](const auto& s) { return build(s, max_vertices); }, source);
  if (built.ok()) {
    const Eigen::Index given = built->positions.cols();
    KERF_CHECK(given == 0 || given == built->mesh.num_vertices(), "importer lost or added vertices");
  }
  return built;
}

Eigen::Matrix3Xd place(const mesh::TriangleMesh& mesh, const Placement& placement) {
  Eigen::Matrix3Xd positions(3, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    positions.col(v) = placement.origin + at.x() * placement.x_axis + at.y() * placement.y_axis;
  }
  return positions;
}

Result<BuiltMesh> build_mesh(const SheetConfig& config) {
  if (!config.components.empty()) return build_components(config);
  KERF_TRY_ASSIGN(SourceMesh built, build_source(config.mesh, config.max_vertices));
  Eigen::Matrix3Xd positions =
      built.positions.cols() > 0 ? std::move(built.positions) : place(built.mesh, config.placement);
  return BuiltMesh{std::move(built.mesh), std::move(positions), {}, std::move(built.notes)};
}

}  // namespace kerf::scene
