#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/drawing_options.h"
#include "client/cli/inspect_drawing.h"
#include "client/cli/mesh_options.h"
#include "server/base/disk.h"
#include "server/service/offline/files.h"
#include "server/service/offline/inspect.h"

namespace kerf::cli {
namespace {

constexpr int kMostObjects = 10;  // listed without --json

struct InspectArguments {
  std::string file;
  MeshArguments mesh;
  DrawingArguments drawing;
};

std::string counted(int count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// Writes a length in the unit that suits it, with three digits.
std::string length(double metres) {
  std::array<char, 48> text{};
  const bool is_small = metres < 0.1;
  std::snprintf(text.data(), text.size(), is_small ? "%.3g mm" : "%.3g m", is_small ? 1e3 * metres : metres);
  return text.data();
}

void print_report(const v1::MeshReport& report) {
  std::printf("%s\n", report.format().c_str());
  if (report.file_faces() > 0) {
    std::printf("  the file has %s and %s\n", counted(report.file_vertices(), "vertex", "vertices").c_str(),
                counted(report.file_faces(), "face", "faces").c_str());
  }
  for (int i = 0; i < std::min(report.objects_size(), kMostObjects); ++i) {
    const v1::MeshObject& object = report.objects(i);
    std::printf("  object %s: %s\n", object.name().c_str(), counted(object.faces(), "face", "faces").c_str());
  }
  if (report.objects_size() > kMostObjects)
    std::printf("  and %d more objects\n", report.objects_size() - kMostObjects);
  if (report.num_vertices() > 0) {
    const v1::Vec3 &low = report.extent().min(), &high = report.extent().max();
    std::printf("  it makes a %s sheet: %s, %s, %s, %s\n", report.flat() ? "flat" : "curved",
                counted(report.num_vertices(), "vertex", "vertices").c_str(),
                counted(report.num_triangles(), "triangle", "triangles").c_str(),
                counted(report.pieces(), "piece", "pieces").c_str(),
                counted(report.borders(), "border", "borders").c_str());
    std::printf("  size %s x %s x %s, area %.4g m2, edges of %s to %s\n", length(high.x() - low.x()).c_str(),
                length(high.y() - low.y()).c_str(), length(high.z() - low.z()).c_str(), report.area_m2(),
                length(report.shortest_edge_m()).c_str(), length(report.longest_edge_m()).c_str());
    if (report.texture_coordinates()) {
      std::printf("  material coordinates are the file's texture coordinates\n");
    }
  }
  for (const std::string& note : report.notes()) std::printf("  note: %s\n", note.c_str());
  for (const std::string& fault : report.faults()) std::printf("  fault: %s\n", fault.c_str());
  if (report.faults_size() > 0) std::printf("  it makes no sheet as it is\n");
}

int inspect_mesh(const Session& session, v1::InspectMeshRequest request) {
  const Result<v1::MeshReport> report = offline::inspect_mesh(std::move(request));
  if (!report.ok()) return refuse(report.error());
  if (session.json) {
    std::printf("%s\n", to_script_json(*report).c_str());
  } else {
    print_report(*report);
  }
  return report->faults().empty() ? kDone : kRefused;
}

int inspect(const Session& session, const InspectArguments& arguments) {
  RealDisk disk;
  v1::InspectMeshRequest mesh;
  switch (offline::kind_of_file(disk, arguments.file)) {
    case offline::FileKind::kPly: {
      Result<v1::PlyMesh> ply = offline::read_ply(disk, arguments.file);
      if (!ply.ok()) return refuse(ply.error());
      set_reading(arguments.mesh, *ply);
      *mesh.mutable_ply() = std::move(ply).value();
      return inspect_mesh(session, std::move(mesh));
    }
    case offline::FileKind::kObj:
      break;
    case offline::FileKind::kSvg:
    case offline::FileKind::kDxf:
      return inspect_drawing(session, arguments.file, arguments.drawing, arguments.mesh.unit);
  }
  Result<v1::ObjMesh> obj = offline::read_obj(disk, arguments.file);
  if (!obj.ok()) return refuse(obj.error());
  set_reading(arguments.mesh, *obj);
  *mesh.mutable_obj() = std::move(obj).value();
  return inspect_mesh(session, std::move(mesh));
}

}  // namespace

void add_inspect_command(CLI::App& app, Session& session) {
  const auto arguments = std::make_shared<InspectArguments>();
  CLI::App* inspecting =
      app.add_subcommand("inspect",
                         "Describe a mesh file or a drawing without a server: what is in it, what is mended, and each\n"
                         "fault with its line. Exit code 1 if a mesh file makes no sheet.\n"
                         "Example: kerf inspect deploy/examples/panel.obj --unit mm");
  inspecting->add_option("FILE", arguments->file, "File: OBJ, PLY, SVG or DXF, known by its content")
      ->required()
      ->type_name(value::kFile);
  inspecting->group(group::kSheets);
  add_mesh_options(*inspecting, arguments->mesh);
  add_choice_options(*inspecting, arguments->drawing);
  inspecting->callback(
      [&session, arguments] { session.action = [&session, arguments] { return inspect(session, *arguments); }; });
}

}  // namespace kerf::cli
