#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "kerf/v1/scene.pb.h"
#include "server/service/offline/files.h"

// Options that choose how a mesh file is read.
namespace kerf::cli {

struct MeshArguments {
  std::string rest = "auto";
  std::string unit = "m";
  double scale = 1.0;
  bool has_unit = false;  // --unit or --scale was given.
  std::string up = "z";
  double join_m = 0.0;
  bool has_join = false;
  bool ignores_texture = false;
  std::vector<std::string> objects;
};

// Adds --rest, --unit, --scale, --up, --join, --ignore-texture and --object, and returns them.
std::vector<CLI::Option*> add_mesh_options(CLI::App& app, MeshArguments& arguments);

// Returns the metres of a unit of the file.
double unit_m(const MeshArguments& arguments);
// Sets the rest shape and the reading of an ObjMesh or PlyMesh.
void set_reading(const MeshArguments& arguments, v1::ObjMesh& mesh);
void set_reading(const MeshArguments& arguments, v1::PlyMesh& mesh);

}  // namespace kerf::cli
