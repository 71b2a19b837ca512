#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

namespace kerf::scene {

// Describes a mesh file and the sheet that it makes; kerf.v1.MeshReport without Protocol Buffers.
struct MeshInspection {
  std::string format;
  std::int32_t file_vertices = 0;
  std::int32_t file_faces = 0;
  bool has_texture = false;  // the material coordinates are the file's texture coordinates
  std::vector<std::pair<std::string, std::int32_t>> objects;  // and their faces
  // Numbers of the sheet; 0 if the file makes none.
  std::int32_t num_vertices = 0;
  std::int32_t num_triangles = 0;
  std::int32_t pieces = 0;
  std::int32_t borders = 0;
  Eigen::AlignedBox3d extent;  // m, in the world; empty if the file makes no sheet
  double area = 0.0;           // m^2, of the rest shape
  double shortest_edge = 0.0;  // m, of the rest shape
  double longest_edge = 0.0;   // m
  bool is_flat = false;
  std::vector<std::string> notes;   // see BuiltMesh::notes
  std::vector<std::string> faults;  // each keeps the file from being a sheet
};

// Reads a mesh file and makes the sheet of it. Faults of faces and vertices are no errors. Errors: those of
// build_source() for a file that cannot be read at all, or an invalid reading.
Result<MeshInspection> inspect(const ObjSource& obj);
Result<MeshInspection> inspect(const PlySource& ply);

}  // namespace kerf::scene
