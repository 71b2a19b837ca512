#include "client/cli/drawing_options.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace kerf::cli {
namespace {

struct UnitName {
  std::string_view name;
  double metres;
};

constexpr std::array<UnitName, 9> kUnitNames{{
    {"mm", 1e-3},
    {"cm", 1e-2},
    {"m", 1.0},
    {"um", 1e-6},
    {"in", 0.0254},
    {"inch", 0.0254},
    {"ft", 0.3048},
    {"pt", 0.0254 / 72.0},
    {"px", 0.0254 / 96.0},
}};

constexpr const char* kLengths = "a length such as 1mm, 0.5cm, 2in or 0.001 (metres)";

}  // namespace

void add_choice_options(CLI::App& command, DrawingArguments& arguments) {
  command
      .add_option("--only", arguments.only,
                  "Of a drawing, take only shapes that this names: \"stroke=red\", \"fill=#00f\", \"layer=NAME\",\n"
                  "\".CLASS\" or \"#ID\"; may be given several times. `kerf inspect FILE` lists what there is")
      ->type_name("SELECTOR")
      ->allow_extra_args(false);
  command.add_flag("--all-shapes", arguments.all_shapes,
                   "Of a drawing, take also shapes that are hidden or paint nothing");
}

void add_unit_option(CLI::App& command, DrawingArguments& arguments) {
  command.add_option("--unit", arguments.unit,
                     "Length of a unit of the drawing instead of its own: mm, cm, m, in, pt, px, or metres");
}

void add_place_options(CLI::App& command, DrawingArguments& arguments) {
  CLI::Option* true_size =
      command.add_flag("--true-size", arguments.true_size, "Keep the drawing's own size instead of fitting it");
  command
      .add_option("--at", arguments.at, "Where the lower left corner of its page lies: \"x,y\" in metres (default 0,0)")
      ->needs(true_size);
  command.add_flag("--fit-page", arguments.fit_page, "Fit the drawing's page, rather than its outlines")
      ->excludes(true_size);
}

Parsed<double> parse_length(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, value);
  std::string_view unit(stop, static_cast<std::size_t>(end - stop));
  while (!unit.empty() && unit.front() == ' ') unit.remove_prefix(1);
  if (fault == std::errc() && unit.empty()) return value;
  for (const UnitName& each : kUnitNames) {
    if (fault == std::errc() && each.name == unit) return value * each.metres;
  }
  return UsageError{"'" + text + "': give " + kLengths};
}

Parsed<v1::DrawingReading> to_reading(const DrawingArguments& arguments) {
  v1::DrawingReading reading;
  for (const std::string& selector : arguments.only) reading.add_only(selector);
  reading.set_all_shapes(arguments.all_shapes);
  reading.set_true_size(arguments.true_size);
  reading.set_fit_page(arguments.fit_page);
  if (arguments.at) {
    Parsed<std::vector<v1::Vec2>> points = parse_points(*arguments.at);
    const auto* at = std::get_if<std::vector<v1::Vec2>>(&points);
    if (at == nullptr || at->size() != 1)
      return UsageError{"--at: '" + *arguments.at + "': give a point such as 0.1,0.2"};
    *reading.mutable_at() = at->front();
  }
  if (arguments.unit) {
    const bool is_name = arguments.unit->find_first_of("0123456789") == std::string::npos;
    Parsed<double> unit = parse_length(is_name ? "1" + *arguments.unit : *arguments.unit);
    if (std::holds_alternative<UsageError>(unit)) {
      return UsageError{"--unit: '" + *arguments.unit + "': give mm, cm, m, in, pt, px, or metres"};
    }
    reading.set_unit_m(std::get<double>(unit));
  }
  return reading;
}

}  // namespace kerf::cli
