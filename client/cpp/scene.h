#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "client/cpp/geometry.h"
#include "client/cpp/result.h"
#include "kerf/v1/scene.pb.h"

// Makes scenes for new sheets. Each has only its mesh; material, pins, wind, colliders and all else are fields of
// kerf.v1.Scene, described in proto/kerf/v1/scene.proto:
//
//   v1::Scene scene = client::grid_scene(60, 40, 1.5, 1.0);
//   scene.mutable_material()->set_preset("silk");
//   client::pin(v1::Region::TOP, scene);
namespace kerf::client {

// Returns a rectangle of columns x rows vertices, 2..1000 each, from (0, 0) to (width_m, height_m).
v1::Scene grid_scene(std::int32_t columns, std::int32_t rows, double width_m, double height_m);
// Return a mesh file's content as a scene. Units, axes and other choices are fields of its `reading`, see
// kerf.v1.MeshReading.
v1::Scene obj_scene(std::string text, v1::RestShape rest = v1::REST_SHAPE_UNSPECIFIED);
v1::Scene ply_scene(std::string content, v1::RestShape rest = v1::REST_SHAPE_UNSPECIFIED);
// Returns a mesh. material_positions: 2 V numbers, x, y interleaved, m. triangles: 3 T vertices in 0..V-1.
v1::Scene mesh_scene(std::span<const double> material_positions, std::span<const std::int32_t> triangles);
// Returns a flat sheet inside a closed curve, with holes. edge_length_m: the longest wanted; 0: 1/32 of the larger
// side.
v1::Scene outline_scene(v1::Curve boundary, std::vector<v1::Curve> holes = {}, double edge_length_m = 0.0);
// Parses a scene file's text. INVALID_ARGUMENT SCENE_MALFORMED if it is malformed. The server refuses files named in
// it.
Result<v1::Scene> json_scene(const std::string& json);

// Pins one more edge of the sheet at its initial place.
void pin(v1::Region::Edge edge, v1::Scene& scene);

}  // namespace kerf::client
