#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/drawing_options.h"
#include "client/cli/mesh_options.h"
#include "client/cli/progress.h"
#include "client/cli/scene_options.h"
#include "client/cpp/client.h"
#include "client/cpp/transfers.h"
#include "server/base/disk.h"
#include "server/service/offline/files.h"

namespace kerf::cli {
namespace {

struct CreateArguments {
  std::string id;
  std::string grid = "50x50";
  std::string size = "1x1";
  std::string obj;      // A file, instead of a grid.
  std::string ply;      // A file, instead of a grid.
  std::string outline;  // A drawing, instead of a grid.
  DrawingArguments reading;
  std::string edge;  // Longest edge of an outline.
  MeshArguments mesh;
  std::string pin = "top";
  std::string material;
  std::vector<std::string> parts;  // Parts of other materials: x0,y0,x1,y1=PRESET.
  std::string scene;               // A file, instead of all of the above.
  offline::Overrides overrides;
  bool paused = false;
};

// Takes a mesh that was read from a file. Returns kDone, or an exit code after printing the error.
template <typename Mesh>
int take(Result<Mesh> read, const MeshArguments& arguments, Mesh& mesh) {
  if (!read.ok()) return refuse(read.error());
  mesh = std::move(read).value();
  set_reading(arguments, mesh);
  return kDone;
}

// Adds an outline from a drawing, at true size. Returns kDone, or an exit code after printing the error.
int add_outline(const CreateArguments& arguments, v1::OutlineMesh& outline) {
  Parsed<v1::DrawingReading> reading = to_reading(arguments.reading);
  if (const auto* wrong = std::get_if<UsageError>(&reading)) return misuse(wrong->message);
  std::get<v1::DrawingReading>(reading).set_true_size(true);
  if (arguments.mesh.has_unit) std::get<v1::DrawingReading>(reading).set_unit_m(unit_m(arguments.mesh));
  const Parsed<double> edge = parse_length(arguments.edge.empty() ? "0" : arguments.edge);
  if (const auto* wrong = std::get_if<UsageError>(&edge)) return misuse("--edge: " + wrong->message);
  RealDisk disk;
  Result<v1::Curve> drawing =
      offline::read_drawing(disk, arguments.outline, std::get<v1::DrawingReading>(std::move(reading)));
  if (!drawing.ok()) return refuse(drawing.error());
  *outline.mutable_boundary() = std::move(drawing).value();
  outline.set_edge_length_m(std::get<double>(edge));
  return kDone;
}

// Adds the sheet's mesh. Returns kDone, or an exit code after printing the error.
int add_mesh(const CreateArguments& arguments, v1::Scene& scene) {
  if (!arguments.outline.empty()) return add_outline(arguments, *scene.mutable_outline());
  if (const std::string& path = arguments.obj.empty() ? arguments.ply : arguments.obj; !path.empty()) {
    RealDisk disk;
    return arguments.obj.empty() ? take(offline::read_ply(disk, path), arguments.mesh, *scene.mutable_ply())
                                 : take(offline::read_obj(disk, path), arguments.mesh, *scene.mutable_obj());
  }
  const Parsed<GridSize> grid = parse_grid(arguments.grid);
  const Parsed<SheetSize> size = parse_size(arguments.size);
  if (const auto* wrong = std::get_if<UsageError>(&grid)) return misuse("--grid: " + wrong->message);
  if (const auto* wrong = std::get_if<UsageError>(&size)) return misuse("--size: " + wrong->message);
  scene.mutable_grid()->set_columns(std::get<GridSize>(grid).columns);
  scene.mutable_grid()->set_rows(std::get<GridSize>(grid).rows);
  scene.mutable_grid()->set_width_m(std::get<SheetSize>(size).width);
  scene.mutable_grid()->set_height_m(std::get<SheetSize>(size).height);
  return kDone;
}

// Adds the parts of other materials. Returns kDone, or an exit code after printing the error.
int add_parts(const std::vector<std::string>& parts, v1::Scene& scene) {
  for (const std::string& part : parts) {
    const std::size_t equals = part.find('=');
    const Parsed<v1::MaterialBox> box = parse_fit(part.substr(0, equals));
    const auto* corners = std::get_if<v1::MaterialBox>(&box);
    if (equals == std::string::npos || corners == nullptr || !corners->has_min()) {
      return misuse("--part: \"" + part + "\" is not x0,y0,x1,y1=PRESET, such as 0.5,0,1,1=rubber");
    }
    v1::RegionMaterial& added = *scene.add_materials();
    *added.mutable_region()->mutable_box() = *corners;
    added.mutable_material()->set_preset(part.substr(equals + 1));
  }
  return kDone;
}

// Replaces `scene` by the content of a scene file and of the files named in it. Returns kDone, or an exit code after
// printing the error.
int add_scene_file(const CreateArguments& arguments, v1::Scene& scene) {
  RealDisk disk;
  Result<scene::SheetConfig> config = offline::read_scene(disk, arguments.scene);
  if (!config.ok()) return refuse(config.error());
  if (const Status known = offline::apply(arguments.overrides, *config); !known.ok()) return refuse(known.error());
  scene = offline::to_message(*config);
  return kDone;
}

// Adds the sheet described by the options. Returns kDone, or an exit code after printing the error.
int add_options(const CreateArguments& arguments, v1::Scene& scene) {
  if (const int code = add_mesh(arguments, scene); code != kDone) return code;
  if (!arguments.material.empty()) scene.mutable_material()->set_preset(arguments.material);
  if (const int code = add_parts(arguments.parts, scene); code != kDone) return code;
  if (arguments.pin == "top") scene.add_pins()->set_edge(v1::Region::TOP);
  if (arguments.pin == "corners") scene.add_pins()->set_edge(v1::Region::CORNERS);
  if (arguments.overrides.fidelity == "real-time") scene.set_fidelity(v1::REAL_TIME);
  if (!arguments.overrides.change_integrator()) return kDone;
  const Result<v1::Integrator> integrator = offline::integrator_message(arguments.overrides);
  if (!integrator.ok()) return refuse(integrator.error());
  *scene.mutable_integrator() = *integrator;
  return kDone;
}

int create_sheet(const Session& session, const CreateArguments& arguments) {
  v1::CreateSheetRequest request;
  request.set_sheet_id(arguments.id);
  request.set_paused(arguments.paused);
  v1::Scene& scene = *request.mutable_scene();
  const int code = arguments.scene.empty() ? add_options(arguments, scene) : add_scene_file(arguments, scene);
  if (code != kDone) return code;
  scene.clear_sheet_id();

  client::Client client = connect(session.server);
  v1::Sheet sheet;
  const grpc::Status status = [&] {
    const WaitingNote note(session, "creating the sheet from " + std::to_string(request.ByteSizeLong()) + " bytes");
    return client::create_sheet(client, std::move(request), sheet);
  }();
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  if (!session.json) {
    for (const std::string& note : sheet.mesh_notes()) std::printf("  note: %s\n", note.c_str());
  }
  return kDone;
}

int list_sheets(const Session& session) {
  client::Client client = connect(session.server);
  v1::ListSheetsResponse all;
  v1::ListSheetsRequest request;
  do {
    v1::ListSheetsResponse page;
    const grpc::Status status = client.call(&v1::SheetService::Stub::ListSheets, client.sheets(), request, page);
    if (!status.ok()) return refuse(status, session.server);
    request.set_page_token(page.next_page_token());
    all.mutable_sheets()->MergeFrom(page.sheets());
  } while (!request.page_token().empty());
  if (session.json) {
    std::printf("%s\n", to_script_json(all).c_str());
  } else if (all.sheets().empty()) {
    std::printf("no sheets\n");
  } else {
    for (const v1::Sheet& sheet : all.sheets()) std::printf("%s\n", describe(sheet, session.verbose).c_str());
  }
  return kDone;
}

// Makes a call that takes a sheet's name and returns the sheet.
template <typename Request>
int call_with_name(const Session& session, const std::string& id,
                   grpc::Status (v1::SheetService::Stub::*method)(grpc::ClientContext*, const Request&, v1::Sheet*)) {
  client::Client client = connect(session.server);
  Request request;
  request.set_name("sheets/" + id);
  v1::Sheet sheet;
  const grpc::Status status = client.call(method, client.sheets(), request, sheet);
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  return kDone;
}

// Asks for confirmation at a terminal if others watch the sheet. If the server cannot be reached, the reset reports it.
int reset_sheet(const Session& session, const std::string& id, bool is_sure) {
  if (!is_sure && isatty(STDIN_FILENO) != 0) {
    client::Client client = connect(session.server);
    v1::GetSheetRequest request;
    request.set_name("sheets/" + id);
    v1::Sheet sheet;
    const grpc::Status status = client.call(&v1::SheetService::Stub::GetSheet, client.sheets(), request, sheet);
    if (status.ok() && sheet.viewers() > 0) {
      std::fprintf(stderr, "%d %s %s: reset it for everyone? [y/N] ", sheet.viewers(),
                   sheet.viewers() == 1 ? "viewer watches" : "viewers watch", id.c_str());
      std::string answer;
      std::getline(std::cin, answer);
      if (answer != "y" && answer != "Y" && answer != "yes") {
        std::fprintf(stderr, "nothing was reset\n");
        return kDone;
      }
    }
  }
  return call_with_name(session, id, &v1::SheetService::Stub::ResetSheet);
}

int delete_sheet(const Session& session, const std::string& id) {
  client::Client client = connect(session.server);
  v1::DeleteSheetRequest request;
  request.set_name("sheets/" + id);
  google::protobuf::Empty nothing;
  const grpc::Status status = client.call(&v1::SheetService::Stub::DeleteSheet, client.sheets(), request, nothing);
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s\n", session.json ? to_script_json(nothing).c_str() : ("sheets/" + id + " deleted").c_str());
  return kDone;
}

int step_sheet(const Session& session, const std::string& id, std::int32_t ticks) {
  client::Client client = connect(session.server);
  v1::StepSheetRequest request;
  request.set_name("sheets/" + id);
  request.set_ticks(ticks);
  v1::Sheet sheet;
  const grpc::Status status = [&] {
    const StepProgress progress(session, request.name(), ticks);
    return client.call(&v1::SheetService::Stub::StepSheet, client.sheets(), request, sheet, std::chrono::hours(24));
  }();
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  return kDone;
}

void add_create(CLI::App& sheet, Session& session) {
  const auto arguments = std::make_shared<CreateArguments>();
  CLI::App* create = sheet.add_subcommand("create",
                                          "Create a sheet from a grid, a mesh file or a scene file.\n"
                                          "Example: kerf sheet create flag --grid 50x50 --size 1x1 --pin top");
  create
      ->add_option("ID", arguments->id, "Name of the sheet: small letters, digits and hyphens, beginning with a letter")
      ->required();
  CLI::Option* grid = create->add_option("--grid", arguments->grid, "Vertices along x and y")
                          ->type_name("COLUMNSxROWS")
                          ->capture_default_str();
  CLI::Option* size =
      create
          ->add_option("--size", arguments->size, "Width and height in metres; the sheet spans (0,0) to (width,height)")
          ->type_name("WIDTHxHEIGHT")
          ->capture_default_str();
  CLI::Option* obj =
      create
          ->add_option("--obj", arguments->obj,
                       "Take the mesh from this Wavefront OBJ file: its positions place the sheet, its texture\n"
                       "coordinates in metres are material coordinates; see --rest. At most 64 MiB")
          ->type_name(value::kFile);
  CLI::Option* ply = create
                         ->add_option("--ply", arguments->ply,
                                      "Take the mesh from this PLY file, text or binary; texture coordinates are s t, "
                                      "u v or texture_u texture_v")
                         ->type_name(value::kFile);
  CLI::Option* outline =
      create
          ->add_option(
              "--outline", arguments->outline,
              "Make a sheet of what the closed lines of this drawing surround, SVG or DXF, at true size: lines\n"
              "within a line are holes; the lower left corner of the page is (0,0); --unit replaces the drawing's\n"
              "own unit")
          ->type_name(value::kFile)
          ->excludes(grid)
          ->excludes(size);
  add_choice_options(*create, arguments->reading);
  for (const char* option : {"--only", "--all-shapes"}) create->get_option(option)->needs(outline);
  create
      ->add_option("--edge", arguments->edge,
                   "Longest edge of its triangles, 5mm or 0.005 (metres); default: 1/32 of the larger side")
      ->needs(outline)
      ->type_name("LENGTH");
  for (CLI::Option* file : {obj, ply}) file->excludes(grid)->excludes(size)->excludes(outline);
  obj->excludes(ply);
  CLI::Option* scene =
      create
          ->add_option(
              "--scene", arguments->scene,
              "Take everything from this scene file (JSON form of kerf.v1.Scene, as `kerf run` reads it) except its\n"
              "sheet_id and analysis; `kerf analyze` measures its probes. At most 1 MiB without its mesh file")
          ->type_name(value::kFile);
  for (CLI::Option* other : {grid, size, obj, ply, outline}) scene->excludes(other);
  add_integrator_options(*create, "the default, or the scene's", arguments->overrides);
  add_fidelity_option(*create, "the default, or the scene's", arguments->overrides);
  for (CLI::Option* option : add_mesh_options(*create, arguments->mesh)) {
    option->excludes(grid)->excludes(size)->excludes(scene);
    const std::string name = option->get_name();
    if (name != "--unit" && name != "--scale") option->excludes(outline);
  }
  create->add_option("--pin", arguments->pin, "Vertices held: top (the edge y = height), corners, none")
      ->check(CLI::IsMember({"top", "corners", "none"}))
      ->excludes(scene)
      ->capture_default_str();
  create->add_option("--material", arguments->material, "Material preset; `kerf info` lists them")
      ->type_name(value::kMaterial)
      ->excludes(scene);
  create
      ->add_option("--part", arguments->parts,
                   "Give the part in this box another material, x0,y0,x1,y1=PRESET, in metres on the\n"
                   "undeformed sheet; may be repeated, and later boxes win")
      ->type_name("BOX=MATERIAL")
      ->excludes(scene)
      ->take_all();
  create->add_flag("--paused", arguments->paused, "Start paused");
  create->callback(
      [&session, arguments] { session.action = [&session, arguments] { return create_sheet(session, *arguments); }; });
}

}  // namespace

void add_sheet_commands(CLI::App& app, Session& session) {
  CLI::App* sheet = app.add_subcommand("sheet", "Create, list, run and remove sheets");
  sheet->group(group::kSheets)->require_subcommand(1);
  add_create(*sheet, session);
  add_settings_commands(*sheet, session);
  add_interaction_commands(*sheet, session);
  add_state_commands(*sheet, session);
  add_recording_commands(*sheet, session);
  CLI::App* list = sheet->add_subcommand("list", "List all sheets (also: ls)");
  list->alias("ls");
  list->callback([&session] { session.action = [&session] { return list_sheets(session); }; });
  add_sheet_command(*sheet, session, "get", "Show one sheet, with the measurements and counts of the server",
                    [](const Session& s, const std::string& id) {
                      Session verbose = s;
                      verbose.verbose = true;
                      return call_with_name(verbose, id, &v1::SheetService::Stub::GetSheet);
                    });
  add_sheet_command(*sheet, session, "delete", "Remove a sheet (also: rm)", delete_sheet)->alias("rm");
  add_sheet_command(*sheet, session, "pause", "Stop a sheet's clock", [](const Session& s, const std::string& id) {
    return call_with_name(s, id, &v1::SheetService::Stub::PauseSheet);
  });
  add_sheet_command(*sheet, session, "resume", "Resume a paused sheet", [](const Session& s, const std::string& id) {
    return call_with_name(s, id, &v1::SheetService::Stub::ResumeSheet);
  });
  const auto is_sure = std::make_shared<bool>(false);
  add_sheet_command(*sheet, session, "reset",
                    "Play the scene again from its beginning, without cuts; `kerf undo` undoes that",
                    [is_sure](const Session& s, const std::string& id) { return reset_sheet(s, id, *is_sure); })
      ->add_flag("--yes", *is_sure, "Do not ask, even if others watch the sheet");

  const auto id = std::make_shared<std::string>();
  const auto ticks = std::make_shared<std::int32_t>(1);
  CLI::App* step = sheet->add_subcommand("step", "Run exactly N ticks of a paused sheet, as fast as it can");
  add_sheet_id(*step, *id);
  step->add_option("N", *ticks, "Ticks, 1..100000")->required()->check(CLI::Range(1, 100000));
  step->callback(
      [&session, id, ticks] { session.action = [&session, id, ticks] { return step_sheet(session, *id, *ticks); }; });
}

}  // namespace kerf::cli
