#include "client/load/comparison.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

namespace kerf::load {
namespace {

using Json = nlohmann::ordered_json;

// Settings outside "plan" that make two runs hard to compare.
constexpr std::array<const char*, 3> kCircumstances{"server_version", "server_workers", "processors"};

Result<Json> parse_report(const NamedReport& report) {
  Json json = Json::parse(report.json, nullptr, false);
  if (!json.is_object() || !json.contains("metrics") || !json["metrics"].is_object() || !json["plan"].is_object()) {
    return invalid_argument("NOT_A_REPORT", report.name + " is no report of `kerf --json load`", "--compare");
  }
  return json;
}

void add_changes(const Json& first, const Json& second, std::vector<ChangedSetting>& changes) {
  const auto text_of = [](const Json& object, const std::string& name) {
    return object.contains(name) ? object[name].dump() : std::string("none");
  };
  const auto add = [&](const std::string& name, const Json& a, const Json& b) {
    if (text_of(a, name) != text_of(b, name)) changes.push_back({name, text_of(a, name), text_of(b, name)});
  };
  for (const char* name : kCircumstances) add(name, first, second);
  for (const auto& [name, value] : first["plan"].items()) add(name, first["plan"], second["plan"]);
  for (const auto& [name, value] : second["plan"].items()) {
    if (!first["plan"].contains(name)) add(name, first["plan"], second["plan"]);
  }
}

struct Cell {
  std::optional<double> value;
  bool enough = false;
};

Cell figure_in(const Json& report, const std::string& name) {
  const auto found = report["metrics"].find(name);
  if (found == report["metrics"].end() || !found->is_object() || !found->contains("value")) return {};
  const Json& value = (*found)["value"];
  return {value.is_number() ? std::optional(value.get<double>()) : std::nullopt, found->value("enough", false)};
}

std::string text_cell(const std::optional<double>& value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value.value_or(0.0));
  return value ? text.data() : "-";
}

}  // namespace

std::optional<double> ComparedMetric::ratio() const {
  if (!first || !second || *first == 0.0) return std::nullopt;
  return *second / *first;
}

Result<Comparison> compare(const NamedReport& first, const NamedReport& second) {
  KERF_TRY_ASSIGN(const Json a, parse_report(first));
  KERF_TRY_ASSIGN(const Json b, parse_report(second));
  Comparison comparison{first.name, second.name, {}, {}};
  add_changes(a, b, comparison.settings);
  for (const Metric& metric : metrics()) {
    const Cell one = figure_in(a, metric.name);
    const Cell other = figure_in(b, metric.name);
    if (!one.value && !other.value) continue;
    comparison.metrics.push_back({metric.name, std::string(units_of(metric.unit).front().first), metric.better,
                                  one.value, other.value, one.enough && other.enough});
  }
  return comparison;
}

Result<std::vector<Judgement>> judge(const Comparison& comparison, const std::vector<Condition>& conditions) {
  using Verdict = Judgement::Verdict;
  std::vector<Judgement> judged;
  for (const Condition& condition : conditions) {
    if (!condition.of_ratio) {
      return invalid_argument("NOT_A_RATIO",
                              "--fail-if: \"" + condition.text + "\": with --compare a limit is a ratio, such as 1.2x",
                              "--fail-if");
    }
    const auto metric = std::find_if(comparison.metrics.begin(), comparison.metrics.end(),
                                     [&](const ComparedMetric& each) { return each.name == condition.metric; });
    const bool there = metric != comparison.metrics.end();
    Judgement judgement{condition, {there ? metric->ratio() : std::nullopt}, Verdict::kUndecided};
    if (judgement.figure.value && metric->enough) {
      judgement.verdict = condition.holds(*judgement.figure.value) ? Verdict::kFailed : Verdict::kPassed;
    }
    judged.push_back(std::move(judgement));
  }
  return judged;
}

std::string to_text(const Comparison& comparison) {
  std::string text = "first   " + comparison.first + "\nsecond  " + comparison.second + "\n";
  for (const ChangedSetting& setting : comparison.settings) {
    text += "differs " + setting.name + ": " + setting.first + " and " + setting.second + "\n";
  }
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), "\n%-20s %-6s %12s %12s %9s\n", "metric", "unit", "first", "second", "ratio");
  text += line.data();
  bool any_few = false;
  for (const ComparedMetric& metric : comparison.metrics) {
    std::snprintf(line.data(), line.size(), "%-20s %-6s %12s %12s %9s%s\n", metric.name.c_str(), metric.unit.c_str(),
                  text_cell(metric.first).c_str(), text_cell(metric.second).c_str(), text_cell(metric.ratio()).c_str(),
                  metric.enough ? "" : " *");
    any_few = any_few || !metric.enough;
    text += line.data();
  }
  return any_few ? text + "* of too few values in at least one of them\n" : text;
}

std::string to_json(const Comparison& comparison, const std::vector<Judgement>& judged) {
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  Json json{{"first", comparison.first}, {"second", comparison.second}, {"settings", Json::array()}};
  for (const ChangedSetting& setting : comparison.settings) {
    const auto value = [](const std::string& text) { return Json::parse(text, nullptr, false); };
    Json first = value(setting.first);
    Json second = value(setting.second);
    json["settings"].push_back({{"name", setting.name},
                                {"first", first.is_discarded() ? Json(nullptr) : std::move(first)},
                                {"second", second.is_discarded() ? Json(nullptr) : std::move(second)}});
  }
  for (const ComparedMetric& metric : comparison.metrics) {
    json["metrics"][metric.name] = {{"unit", metric.unit},
                                    {"first", number(metric.first)},
                                    {"second", number(metric.second)},
                                    {"ratio", number(metric.ratio())},
                                    {"enough", metric.enough}};
  }
  json["fail_if"] = Json::array();
  for (const Judgement& judgement : judged) {
    json["fail_if"].push_back({{"condition", judgement.condition.text},
                               {"verdict", name_of(judgement.verdict)},
                               {"ratio", number(judgement.figure.value)}});
  }
  return json.dump(2) + "\n";
}

}  // namespace kerf::load
