#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/interact.h"
#include "client/cpp/client.h"
#include "server/service/wire/json.h"

// Implements the settings of a live sheet: its material, its self-contact, its speed.
namespace kerf::cli {
namespace {

struct MaterialArguments {
  std::string id;
  std::string preset;
  std::vector<std::string> numbers;  // FIELD=VALUE
  std::optional<std::int32_t> part;
};

// Reads the material given by the preset and the numbers that override it. Returns kDone, or an exit code after
// printing the error.
int read_material(const MaterialArguments& arguments, v1::Material& material) {
  nlohmann::json json = nlohmann::json::object();
  if (!arguments.preset.empty()) json["preset"] = arguments.preset;
  for (const std::string& number : arguments.numbers) {
    const std::size_t equals = number.find('=');
    const nlohmann::json value = equals == std::string::npos
                                     ? nlohmann::json()
                                     : nlohmann::json::parse(number.substr(equals + 1), nullptr, false);
    if (!value.is_number()) {
      return misuse("--with: \"" + number + "\" is not FIELD=NUMBER, such as thickness_m=0.001");
    }
    json[number.substr(0, equals)] = value;
  }
  // Replaces invalid UTF-8, which matches no field and no preset, so that the error names it.
  const Status read = wire::from_json(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), material);
  return read.ok() ? kDone : refuse(read.error());
}

int set_material(const Session& session, const MaterialArguments& arguments) {
  v1::SetSheetMaterialRequest request;
  request.set_name("sheets/" + arguments.id);
  v1::SetMaterial& set_material = *request.mutable_set_material();
  if (const int code = read_material(arguments, *set_material.mutable_material()); code != kDone) return code;
  if (arguments.part) set_material.set_part(*arguments.part);
  return interact(session, &v1::InteractionService::Stub::SetSheetMaterial, request);
}

struct SelfContactArguments {
  std::string id;
  std::string mode;
  std::optional<double> friction;
  std::optional<double> thickness_m;
  bool material_thickness = false;
};

int set_self_contact(const Session& session, const SelfContactArguments& arguments) {
  if (arguments.mode.empty() && !arguments.friction && !arguments.thickness_m && !arguments.material_thickness) {
    return misuse("give on, off, --friction, --thickness or --material-thickness");
  }
  v1::SetSheetSelfContactRequest request;
  request.set_name("sheets/" + arguments.id);
  v1::SetSelfContact& change = *request.mutable_set_self_contact();
  if (!arguments.mode.empty()) change.set_mode(arguments.mode == "on" ? v1::SelfContact::ON : v1::SelfContact::OFF);
  if (arguments.friction) change.set_friction(*arguments.friction);
  if (arguments.thickness_m) change.set_thickness_m(*arguments.thickness_m);
  change.set_material_thickness(arguments.material_thickness);
  return interact(session, &v1::InteractionService::Stub::SetSheetSelfContact, request);
}

int set_speed(const Session& session, const std::string& id, double speed) {
  v1::SetSheetSpeedRequest request;
  request.set_name("sheets/" + id);
  request.set_speed(speed);
  client::Client client = connect(session.server);
  v1::Sheet sheet;
  const grpc::Status status = client.call(&v1::SheetService::Stub::SetSheetSpeed, client.sheets(), request, sheet);
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  return kDone;
}

}  // namespace

void add_settings_commands(CLI::App& sheet, Session& session) {
  const auto arguments = std::make_shared<MaterialArguments>();
  CLI::App* material = sheet.add_subcommand("material",
                                            "Change the material of a running sheet, which keeps moving.\n"
                                            "Example: kerf sheet material demo silk --with thickness_m=0.0002");
  add_sheet_id(*material, arguments->id);
  material->add_option("PRESET", arguments->preset, "Material preset; `kerf info` lists them (default: demo)")
      ->type_name(value::kMaterial);
  material
      ->add_option("--with", arguments->numbers,
                   "FIELD=NUMBER, a field of kerf.v1.Material that replaces the preset's; may be repeated")
      ->take_all();
  material->add_option("--part", arguments->part,
                       "Only this one of the parts that the sheet was created with, from 0; -1: the rest of the sheet");
  material->callback(
      [&session, arguments] { session.action = [&session, arguments] { return set_material(session, *arguments); }; });

  const auto contact = std::make_shared<SelfContactArguments>();
  CLI::App* folds = sheet.add_subcommand("self-contact",
                                         "Turn contact of a sheet with itself on or off, or change its settings.\n"
                                         "Example: kerf sheet self-contact demo on --friction 0.5");
  add_sheet_id(*folds, contact->id);
  folds->add_option("MODE", contact->mode, "on or off (default: as it is)")->check(CLI::IsMember({"on", "off"}));
  folds->add_option("--friction", contact->friction, "Friction of folds and pieces on each other, 0..10");
  CLI::Option* thickness =
      folds->add_option("--thickness", contact->thickness_m, "Distance that they keep, metres, 1e-6 to 0.1");
  folds->add_flag("--material-thickness", contact->material_thickness, "They keep the thickness of the material again")
      ->excludes(thickness);
  folds->callback(
      [&session, contact] { session.action = [&session, contact] { return set_self_contact(session, *contact); }; });

  const auto id = std::make_shared<std::string>();
  const auto speed = std::make_shared<double>(1.0);
  CLI::App* pace = sheet.add_subcommand("speed", "Slow motion or time lapse: the same ticks at another pace");
  add_sheet_id(*pace, *id);
  pace->add_option("SPEED", *speed, "Simulated seconds per second, 0.01..4; 1 is real time")->required();
  pace->callback(
      [&session, id, speed] { session.action = [&session, id, speed] { return set_speed(session, *id, *speed); }; });
}

}  // namespace kerf::cli
