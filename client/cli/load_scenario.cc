#include "client/cli/load_scenario.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/suggestions.h"
#include "server/base/disk.h"

namespace kerf::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostScenarioBytes = 1 << 20;

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

// Returns the texts of a value as on a command line; empty if its kind is wrong.
std::vector<std::string> texts_of(const Json& value, bool repeatable) {
  const auto is_one = [](const Json& each) { return each.is_string() || each.is_number() || each.is_boolean(); };
  if (is_one(value)) return {text_of(value)};
  std::vector<std::string> texts;
  if (!repeatable || !value.is_array() || !std::all_of(value.begin(), value.end(), is_one)) return texts;
  for (const Json& each : value) texts.push_back(text_of(each));
  return texts;
}

}  // namespace

Status read_scenario(const CLI::App& command, const std::string& file) {
  const auto wrong = [&](const std::string& why) {
    return invalid_argument("BAD_SCENARIO", file + ": " + why, "--scenario");
  };
  RealDisk disk;
  KERF_TRY_ASSIGN(const std::string text, disk.read_file(file, kMostScenarioBytes));
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    return wrong(error.what());
  }
  if (!json.is_object()) return wrong("it is no JSON object of options");
  std::vector<std::string> names;
  for (const CLI::Option* option : options_of(command)) {
    const std::string name = option_name(*option).substr(2);
    if (name != "help" && name != "scenario" && name != "compare") names.push_back(name);
  }
  for (const auto& [name, value] : json.items()) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      return wrong("there is no option \"" + name + '"' + did_you_mean(near_names(name, names)));
    }
    CLI::Option* option = const_cast<CLI::App&>(command).get_option("--" + name);
    if (!option->empty()) continue;
    const std::vector<std::string> texts = texts_of(value, is_repeatable(*option));
    if (texts.empty()) return wrong('"' + name + "\" has the wrong kind of value");
    if (!takes_value(*option) && !value.is_boolean()) return wrong('"' + name + "\" is true or false");
    for (const std::string& each : texts) option->add_result(each);
    try {
      option->run_callback();
    } catch (const CLI::Error& error) {
      return wrong(error.what());
    }
  }
  return Nothing{};
}

}  // namespace kerf::cli
