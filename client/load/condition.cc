#include "client/load/condition.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "client/load/metrics.h"

namespace kerf::load {
namespace {

constexpr std::string_view kSpaces = " \t";

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

std::string list_of_units(Unit unit) {
  std::string list;
  for (const auto& [name, factor] : units_of(unit)) list += (list.empty() ? "" : ", ") + std::string(name);
  return list;
}

// Reads a number and its unit, from `text` to its end.
Status read_limit(const std::string& text, const Metric& metric, Condition& condition) {
  const std::string& whole = condition.text;
  double value = 0.0;
  const auto [rest, wrong] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (wrong != std::errc() || !std::isfinite(value)) {
    return invalid_argument("BAD_CONDITION", '"' + whole + "\": \"" + text + "\" is no number", "--fail-if");
  }
  const std::string unit = trimmed({rest, static_cast<std::size_t>(text.data() + text.size() - rest)});
  const auto& known = units_of(metric.unit);
  const auto found = std::find_if(known.begin(), known.end(), [&](const auto& each) { return each.first == unit; });
  condition.of_ratio = unit == "x";
  condition.limit = found == known.end() ? value : value * found->second;
  if (found != known.end() || condition.of_ratio) return Nothing{};
  const std::string wants = known.front().first.empty()
                                ? "takes a number without a unit"
                                : "takes a number with one of the units " + list_of_units(metric.unit);
  return invalid_argument("BAD_UNIT",
                          '"' + whole + "\": " + metric.name + " " + wants +
                              (unit.empty() ? ", and none is given" : ", not \"" + unit + '"'),
                          "--fail-if");
}

}  // namespace

bool Condition::holds(double value) const {
  switch (relation) {
    case Relation::kAbove:
      return value > limit;
    case Relation::kAtLeast:
      return value >= limit;
    case Relation::kBelow:
      return value < limit;
    case Relation::kAtMost:
      return value <= limit;
  }
  return false;
}

std::string metric_word(const std::string& text) {
  const std::string whole = trimmed(text);
  const auto usual = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return {whole.begin(), std::find_if_not(whole.begin(), whole.end(), usual)};
}

Result<Condition> parse_condition(const std::string& text) {
  Condition condition;
  condition.text = trimmed(text);
  condition.metric = metric_word(text);
  const std::string rest = trimmed(condition.text.substr(condition.metric.size()));
  if (condition.metric.empty() || rest.empty() || (rest[0] != '<' && rest[0] != '>')) {
    return invalid_argument(
        "BAD_CONDITION",
        '"' + condition.text + "\": write a metric, one of > >= < <=, and a limit, such as cut_p99>50ms", "--fail-if");
  }
  const Metric* metric = find_metric(condition.metric);
  if (metric == nullptr) {
    return invalid_argument("UNKNOWN_METRIC", '"' + condition.text + "\": there is no metric " + condition.metric,
                            "--fail-if");
  }
  const bool equal = rest.size() > 1 && rest[1] == '=';
  using Relation = Condition::Relation;
  condition.relation =
      rest[0] == '>' ? (equal ? Relation::kAtLeast : Relation::kAbove) : (equal ? Relation::kAtMost : Relation::kBelow);
  KERF_TRY(read_limit(trimmed(rest.substr(equal ? 2 : 1)), *metric, condition));
  return condition;
}

}  // namespace kerf::load
