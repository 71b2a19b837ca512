#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/interact.h"

// Implements actions on a live sheet: grabs, pins, gravity, wind.
namespace kerf::cli {
namespace {

constexpr const char* kVector = "X,Y,Z";
constexpr const char* kNone = "none";

using Service = v1::InteractionService::Stub;

// Sets `vector`. Returns kDone, or an exit code after printing the error.
int read_vector(const std::string& text, const std::string& option, v1::Vec3& vector) {
  const Parsed<v1::Vec3> parsed = parse_vector(text);
  if (const auto* wrong = std::get_if<UsageError>(&parsed)) return misuse(option + ": " + wrong->message);
  vector = std::get<v1::Vec3>(parsed);
  return kDone;
}

struct GrabArguments {
  std::string id;
  std::string grab_id;
  std::optional<std::int32_t> vertex;
  std::optional<std::string> point;
  std::optional<std::string> target;
  double stiffness_npm = 0.0;
};

int grab(const Session& session, const GrabArguments& arguments) {
  v1::GrabPointRequest request;
  request.set_name("sheets/" + arguments.id);
  v1::Grab& grab = *request.mutable_grab();
  grab.set_grab_id(arguments.grab_id);
  grab.set_stiffness_npm(arguments.stiffness_npm);
  if (arguments.vertex) grab.set_vertex(*arguments.vertex);
  if (arguments.point) {
    const Parsed<std::vector<v1::Vec2>> points = parse_points(*arguments.point);
    if (const auto* wrong = std::get_if<UsageError>(&points)) return misuse("--at: " + wrong->message);
    if (std::get<std::vector<v1::Vec2>>(points).size() != 1) return misuse("--at: one point x,y in metres");
    *grab.mutable_material() = std::get<std::vector<v1::Vec2>>(points).front();
  }
  if (arguments.target) {
    if (const int code = read_vector(*arguments.target, "--to", *grab.mutable_target()); code != kDone) return code;
  }
  return interact(session, &Service::GrabPoint, request);
}

int drag(const Session& session, const GrabArguments& arguments) {
  v1::DragPointRequest request;
  request.set_name("sheets/" + arguments.id);
  request.mutable_drag()->set_grab_id(arguments.grab_id);
  v1::Vec3& target = *request.mutable_drag()->mutable_target();
  if (const int code = read_vector(*arguments.target, kVector, target); code != kDone) return code;
  return interact(session, &Service::DragPoint, request);
}

int release(const Session& session, const GrabArguments& arguments) {
  v1::ReleasePointRequest request;
  request.set_name("sheets/" + arguments.id);
  request.mutable_release()->set_grab_id(arguments.grab_id);
  return interact(session, &Service::ReleasePoint, request);
}

int set_pins(const Session& session, const std::string& id, const std::vector<std::string>& places) {
  v1::SetSheetPinsRequest request;
  request.set_name("sheets/" + id);
  for (const std::string& place : places) {
    if (place == kNone && places.size() == 1) break;
    const Parsed<v1::Region> region = parse_region(place);
    if (const auto* wrong = std::get_if<UsageError>(&region)) return misuse("PLACE: " + wrong->message);
    *request.mutable_set_pins()->add_pins() = std::get<v1::Region>(region);
  }
  request.mutable_set_pins();
  return interact(session, &Service::SetSheetPins, request);
}

int set_gravity(const Session& session, const std::string& id, const std::string& gravity) {
  v1::SetSheetGravityRequest request;
  request.set_name("sheets/" + id);
  v1::Vec3& vector = *request.mutable_set_gravity()->mutable_gravity_mps2();
  if (const int code = read_vector(gravity, kVector, vector); code != kDone) return code;
  return interact(session, &Service::SetSheetGravity, request);
}

struct WindArguments {
  std::string id;
  std::string velocity;
  double air_density_kgpm3 = 0.0;
  double drag_coefficient = 0.0;
};

int set_wind(const Session& session, const WindArguments& arguments) {
  v1::SetSheetWindRequest request;
  request.set_name("sheets/" + arguments.id);
  v1::SetWind& set_wind = *request.mutable_set_wind();
  if (arguments.velocity != kNone) {
    v1::Wind& wind = *set_wind.mutable_wind();
    wind.set_air_density_kgpm3(arguments.air_density_kgpm3);
    wind.set_drag_coefficient(arguments.drag_coefficient);
    const int code = read_vector(arguments.velocity, kVector, *wind.mutable_velocity_mps());
    if (code != kDone) return code;
  }
  return interact(session, &Service::SetSheetWind, request);
}

void add_grabs(CLI::App& sheet, Session& session) {
  const auto arguments = std::make_shared<GrabArguments>();
  const auto add = [&sheet, &session, arguments](const std::string& name, const std::string& help,
                                                 int (*action)(const Session&, const GrabArguments&)) {
    CLI::App* command = sheet.add_subcommand(name, help);
    add_sheet_id(*command, arguments->id);
    command->add_option("NAME", arguments->grab_id, "Name of the grab, 1 to 63 bytes")->required();
    command->callback([&session, arguments, action] {
      session.action = [&session, arguments, action] { return action(session, *arguments); };
    });
    return command;
  };
  CLI::App* begin = add("grab",
                        "Pull at a point of a sheet by a spring, until it is released.\n"
                        "Example: kerf sheet grab demo hand --at 0.5,0.1 --to 0.5,0.4,0.8",
                        &grab);
  CLI::Option_group* point = begin->add_option_group("point");
  point->add_option("--at", arguments->point, "The point, metres in material coordinates")->type_name("X,Y");
  point->add_option("--vertex", arguments->vertex, "The vertex, instead of --at");
  point->require_option(1);
  begin->add_option("--to", arguments->target, "Where it is pulled, metres (default: where it is now)")
      ->type_name(kVector);
  begin->add_option("--stiffness", arguments->stiffness_npm,
                    "Stiffness of the spring, N/m, up to 1e6; 0: as stiff as stays stable");
  CLI::App* move = add("drag", "Move a grabbed point", &drag);
  move->add_option("TARGET", arguments->target, "Where to move it, metres")->required()->type_name(kVector);
  add("release", "Let a grabbed point go", &release);
}

}  // namespace

void add_interaction_commands(CLI::App& sheet, Session& session) {
  add_grabs(sheet, session);

  const auto id = std::make_shared<std::string>();
  const auto places = std::make_shared<std::vector<std::string>>();
  CLI::App* pins = sheet.add_subcommand("pins",
                                        "Hold these places of a sheet where they are now, and no others.\n"
                                        "Example: kerf sheet pins demo left 0.9,0,1,0.1");
  add_sheet_id(*pins, *id);
  pins->add_option("PLACE", *places,
                   "top, bottom, left, right, corners, top-corners, all; X,Y: the nearest vertex; X0,Y0,X1,Y1: a box; "
                   "or none, alone")
      ->required();
  pins->callback(
      [&session, id, places] { session.action = [&session, id, places] { return set_pins(session, *id, *places); }; });

  const auto vector = std::make_shared<std::string>();
  CLI::App* gravity = sheet.add_subcommand("gravity", "Set gravity.\nExample: kerf sheet gravity demo 0,0,-1.62");
  add_sheet_id(*gravity, *id);
  gravity->add_option("GRAVITY", *vector, "Acceleration, m/s^2")->required()->type_name(kVector);
  gravity->callback([&session, id, vector] {
    session.action = [&session, id, vector] { return set_gravity(session, *id, *vector); };
  });

  const auto wind = std::make_shared<WindArguments>();
  CLI::App* air = sheet.add_subcommand("wind", "Set the wind.\nExample: kerf sheet wind demo 0,5,0");
  add_sheet_id(*air, wind->id);
  air->add_option("VELOCITY", wind->velocity, "Velocity, m/s; 0,0,0 is still air, none removes the air")
      ->required()
      ->type_name(kVector);
  air->add_option("--density", wind->air_density_kgpm3, "Density of the air, kg/m^3, up to 100 (default 1.2)");
  air->add_option("--drag", wind->drag_coefficient, "Drag coefficient, up to 10 (default 1)");
  air->callback([&session, wind] { session.action = [&session, wind] { return set_wind(session, *wind); }; });
}

}  // namespace kerf::cli
