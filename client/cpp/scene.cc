#include "client/cpp/scene.h"

#include <utility>

#include <google/protobuf/util/json_util.h>

namespace kerf::client {

v1::Scene grid_scene(std::int32_t columns, std::int32_t rows, double width_m, double height_m) {
  v1::Scene scene;
  v1::GridMesh& grid = *scene.mutable_grid();
  grid.set_columns(columns);
  grid.set_rows(rows);
  grid.set_width_m(width_m);
  grid.set_height_m(height_m);
  return scene;
}

v1::Scene obj_scene(std::string text, v1::RestShape rest) {
  v1::Scene scene;
  scene.mutable_obj()->set_text(std::move(text));
  scene.mutable_obj()->set_rest_shape(rest);
  return scene;
}

v1::Scene ply_scene(std::string content, v1::RestShape rest) {
  v1::Scene scene;
  scene.mutable_ply()->set_data(std::move(content));
  scene.mutable_ply()->set_rest_shape(rest);
  return scene;
}

v1::Scene mesh_scene(std::span<const double> material_positions, std::span<const std::int32_t> triangles) {
  v1::Scene scene;
  scene.mutable_inline_()->mutable_material_positions()->Assign(material_positions.begin(), material_positions.end());
  scene.mutable_inline_()->mutable_triangles()->Assign(triangles.begin(), triangles.end());
  return scene;
}

v1::Scene outline_scene(v1::Curve boundary, std::vector<v1::Curve> holes, double edge_length_m) {
  v1::Scene scene;
  v1::OutlineMesh& outline = *scene.mutable_outline();
  *outline.mutable_boundary() = std::move(boundary);
  for (v1::Curve& hole : holes) *outline.add_holes() = std::move(hole);
  outline.set_edge_length_m(edge_length_m);
  return scene;
}

Result<v1::Scene> json_scene(const std::string& json) {
  v1::Scene scene;
  const auto status = google::protobuf::util::JsonStringToMessage(json, &scene);
  if (status.ok()) return scene;
  return Failure{grpc::StatusCode::INVALID_ARGUMENT,
                 "SCENE_MALFORMED",
                 "this is not a scene in JSON: " + std::string(status.message()),
                 {}};
}

void pin(v1::Region::Edge edge, v1::Scene& scene) {
  scene.add_pins()->set_edge(edge);
}

}  // namespace kerf::client
