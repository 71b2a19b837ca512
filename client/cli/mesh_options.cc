#include "client/cli/mesh_options.h"

#include <map>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace kerf::cli {
namespace {

const std::map<std::string, double>& units() {
  static const std::map<std::string, double> table{{"um", 1e-6}, {"mm", 1e-3},   {"cm", 1e-2},
                                                   {"m", 1.0},   {"in", 0.0254}, {"ft", 0.3048}};
  return table;
}

v1::RestShape rest_shape(const std::string& name) {
  if (name == "flat") return v1::REST_SHAPE_FLAT;
  return name == "surface" ? v1::REST_SHAPE_SURFACE : v1::REST_SHAPE_UNSPECIFIED;
}

template <typename Mesh>
void set(const MeshArguments& arguments, Mesh& mesh) {
  mesh.set_rest_shape(rest_shape(arguments.rest));
  v1::MeshReading& reading = *mesh.mutable_reading();
  reading.set_unit_m(unit_m(arguments));
  if (arguments.up == "y") reading.set_up_axis(v1::MeshReading::Y_UP);
  if (arguments.up == "x") reading.set_up_axis(v1::MeshReading::X_UP);
  if (arguments.has_join) reading.set_join_m(arguments.join_m);
  reading.set_ignore_texture_coordinates(arguments.ignores_texture);
  for (const std::string& name : arguments.objects) reading.add_objects(name);
}

}  // namespace

std::vector<CLI::Option*> add_mesh_options(CLI::App& app, MeshArguments& arguments) {
  std::vector<CLI::Option*> options;
  options.push_back(app.add_option("--rest", arguments.rest,
                                   "Rest shape of a mesh file: flat (its texture coordinates, or its plane), surface\n"
                                   "(its positions, curved as they are), or auto: flat where the file allows it")
                        ->check(CLI::IsMember({"auto", "flat", "surface"}))
                        ->capture_default_str());
  const auto note = [&arguments](const std::string& /*text*/) { arguments.has_unit = true; };
  options.push_back(app.add_option("--unit", arguments.unit, "Unit of the numbers in a mesh file")
                        ->check(CLI::IsMember({"um", "mm", "cm", "m", "in", "ft"}))
                        ->each(note)
                        ->capture_default_str());
  options.push_back(app.add_option("--scale", arguments.scale, "Multiply the numbers of a mesh file by this, too")
                        ->check(CLI::Range(1e-9, 1e6))
                        ->each(note));
  options.push_back(app.add_option("--up", arguments.up, "Axis of a mesh file that points up in the world")
                        ->check(CLI::IsMember({"x", "y", "z"}))
                        ->capture_default_str());
  options.push_back(
      app.add_option_function<double>(
             "--join",
             [&arguments](const double& distance) {
               arguments.join_m = distance;
               arguments.has_join = true;
             },
             "Join vertices of a mesh file at most this far apart, and to sides of other faces, in metres;\n"
             "0 joins none. Without this option those are joined that agree as exactly as the file is written")
          ->check(CLI::Range(0.0, 1e4)));
  options.push_back(app.add_flag("--ignore-texture", arguments.ignores_texture,
                                 "Read a mesh file as if it had no texture coordinates"));
  options.push_back(
      app.add_option("--object", arguments.objects, "Read only this object or group of an OBJ file; may be repeated")
          ->type_name("NAME")
          ->take_all());
  return options;
}

double unit_m(const MeshArguments& arguments) {
  return units().at(arguments.unit) * arguments.scale;
}

void set_reading(const MeshArguments& arguments, v1::ObjMesh& mesh) {
  set(arguments, mesh);
}

void set_reading(const MeshArguments& arguments, v1::PlyMesh& mesh) {
  set(arguments, mesh);
}

}  // namespace kerf::cli
