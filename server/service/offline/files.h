#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kerf/v1/files.pb.h"
#include "kerf/v1/geometry.pb.h"
#include "kerf/v1/scene.pb.h"
#include "server/base/disk.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

// Reads what a client takes from files and command lines: scenes, meshes, drawings and paths. Each reader refuses files
// that a server would refuse for their size (FILE_TOO_LARGE).
namespace kerf::offline {

// Reads a scene file, and the files named in it, which are relative to it. Errors: those of the files and of
// wire::decode_scene_file.
Result<scene::SheetConfig> read_scene(Disk& disk, const std::string& path);
v1::Scene to_message(const scene::SheetConfig& config);

// Replaces choices of a scene by name; an empty name keeps the scene's own.
struct Overrides {
  std::string integrator = {};    // One of integrator_names().
  std::string precision = {};     // "double" or "mixed"; explicit integrator only.
  std::string solver = {};        // One of solver_names(); implicit integrators only.
  std::string fidelity = {};      // "exact" or "real-time".
  std::string membrane_law = {};  // "corotational" or "green".

  [[nodiscard]] bool change_integrator() const { return !(integrator.empty() && precision.empty() && solver.empty()); }
};
// Sets what the overrides name in `config`. If a name is unknown, leaves `config` unchanged and returns
// kInvalidArgument UNKNOWN_CHOICE; its field is the member of Overrides.
Status apply(const Overrides& overrides, scene::SheetConfig& config);
// Returns the default settings of an integrator with the overrides applied. Errors: those of apply().
Result<v1::Integrator> integrator_message(const Overrides& overrides);

std::vector<std::string> integrator_names();
std::vector<std::string> solver_names();

// Read a mesh file, at most 64 MiB, without parsing it, also compressed by gzip. An OBJ file becomes UTF-8, see
// utf8_text().
Result<v1::ObjMesh> read_obj(Disk& disk, const std::string& path);
Result<v1::PlyMesh> read_ply(Disk& disk, const std::string& path);

// Reads a drawing of at most 16 MiB, SVG or DXF, which its content tells, without parsing it. An SVG may be in any
// encoding or compressed by gzip. Embedded pictures and fonts are left out; the rest has at most 512 KiB. Errors: those
// of svg::outline_text().
Result<v1::Curve> read_drawing(Disk& disk, const std::string& path, const v1::DrawingReading& reading);

// Describes a drawing in a file. Errors: those of read_drawing() and wire::inspect_drawing().
Result<v1::DrawingReport> inspect_drawing(Disk& disk, const std::string& path, const v1::DrawingReading& reading);

struct DrawingSize {
  double width = 0.0;          // m, box of the lines to cut, before the drawing is fitted.
  double height = 0.0;         // m
  double fitted_width = 0.0;   // m, box that a cut fits: of the lines, or of the page.
  double fitted_height = 0.0;  // m
  bool is_placed = false;      // The drawing keeps its size.
};
// Returns the size of a curve that is a drawing. Errors: those of wire::decode_curve().
Result<DrawingSize> size_of_drawing(const v1::Curve& curve);

// Parses SVG path data, with coordinates in metres and y up. A text without segments gives an empty path.
// kInvalidArgument SVG_PATH: the message names the fault and its byte.
Result<v1::Path> parse_path(std::string_view data);

}  // namespace kerf::offline
