#include "server/core/scene/mesh_source.h"

#include <string>
#include <utility>

#include "server/base/check.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "server/core/mesh/build/obj_import.h"
#include "server/core/mesh/build/ply_import.h"
#include "server/core/scene/outline_source.h"

namespace kerf::scene {

namespace {

Eigen::Matrix3Xd place(const mesh::TriangleMesh& mesh, const Placement& placement) {
  Eigen::Matrix3Xd positions(3, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Eigen::Vector2d at = mesh.rest_position(v);
    positions.col(v) = placement.origin + at.x() * placement.x_axis + at.y() * placement.y_axis;
  }
  return positions;
}

Error with_field(Error error, std::string field) {
  error.field = std::move(field);
  return error;
}

Result<BuiltMesh> build(const GridSource& grid, const Placement& placement, std::int32_t /*max_vertices*/) {
  mesh::GridConfig config;
  config.num_x = grid.columns;
  config.num_y = grid.rows;
  config.width = grid.width;
  config.height = grid.height;
  Result<mesh::TriangleMesh> built = grid.pattern == GridPattern::kJitteredDelaunay
                                         ? mesh::make_jittered_grid(config, grid.seed)
                                         : mesh::make_grid(config);
  if (!built.ok()) return with_field(built.error(), "grid");
  Eigen::Matrix3Xd positions = place(*built, placement);
  return BuiltMesh{std::move(built).value(), std::move(positions)};
}

// Builds a mesh from the content of a file. Positions need no check against the limits of the world, as those of the
// reader are tighter.
Result<BuiltMesh> build(Result<mesh::ImportedSheet> parsed, const std::string& field) {
  if (!parsed.ok()) return with_field(parsed.error(), field);
  Result<mesh::TriangleMesh> built = mesh::import_mesh(parsed->sheet);
  if (!built.ok()) return with_field(built.error(), field);
  return BuiltMesh{std::move(built).value(), std::move(parsed->world)};
}

Result<BuiltMesh> build(const ObjSource& obj, const Placement& /*placement*/, std::int32_t /*max_vertices*/) {
  return build(mesh::parse_obj(obj.text, obj.rest_shape), "obj.text");
}

Result<BuiltMesh> build(const PlySource& ply, const Placement& /*placement*/, std::int32_t /*max_vertices*/) {
  return build(mesh::parse_ply(ply.data, ply.rest_shape), "ply.data");
}

Result<BuiltMesh> build(const ArraySource& arrays, const Placement& placement, std::int32_t /*max_vertices*/) {
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
  Eigen::Matrix3Xd positions = given.cols() > 0 ? given : place(*built, placement);
  return BuiltMesh{std::move(built).value(), std::move(positions)};
}

Result<BuiltMesh> build(const OutlineSource& outline, const Placement& placement, std::int32_t max_vertices) {
  KERF_TRY_ASSIGN(mesh::TriangleMesh built, mesh_outline(outline, max_vertices));
  Eigen::Matrix3Xd positions = place(built, placement);
  return BuiltMesh{std::move(built), std::move(positions)};
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

Result<BuiltMesh> build_mesh(const MeshSource& source, const Placement& placement, std::int32_t max_vertices) {
  Result<BuiltMesh> built = std::visit([&](const auto& s) { return build(s, placement, max_vertices); }, source);
  if (built.ok()) {
    KERF_CHECK(built->positions.cols() == built->mesh.num_vertices(), "importer lost or added vertices");
  }
  return built;
}

}  // namespace kerf::scene
