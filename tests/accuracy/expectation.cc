#include "tests/accuracy/expectation.h"
#include "tests/support/paths.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace kerf::accuracy {

namespace {

using nlohmann::json;

json read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("no file " + file.string());
  return json::parse(stream);
}

const v1::Table& table_of(const v1::RunResult& result, const std::string& name) {
  for (const v1::Table& table : result.tables()) {
    if (table.name() == name) return table;
  }
  throw std::runtime_error("the scene gives no table \"" + name + "\"");
}

int column_of(const v1::Table& table, const std::string& name) {
  for (int i = 0; i < table.columns_size(); ++i) {
    if (table.columns(i) == name) return i;
  }
  throw std::runtime_error("the scene gives no column \"" + name + "\"");
}

std::string with_number(std::string name, std::size_t number) {
  const std::size_t at = name.find('#');
  if (at != std::string::npos) name.replace(at, 1, std::to_string(number));
  return name;
}

// A weighted sum of columns at every row of a table.
std::vector<double> series_of(const v1::Table& table, const json& terms, std::size_t number) {
  std::vector<double> sums(static_cast<std::size_t>(table.rows_size()), 0.0);
  for (const auto& [name, factor] : terms.items()) {
    const int column = name == "1" ? -1 : column_of(table, with_number(name, number));
    for (std::size_t row = 0; row < sums.size(); ++row) {
      const double value = column < 0 ? 1.0 : table.rows(static_cast<int>(row)).values(column);
      sums[row] += factor.get<double>() * value;
    }
  }
  return sums;
}

std::vector<double> evaluate(const v1::Table& table, const json& found, std::size_t number) {
  if (found.contains("sqrt")) {
    std::vector<double> roots = series_of(table, found.at("sqrt").at(0), number);
    for (double& value : roots) value = std::sqrt(value);
    return roots;
  }
  for (const char* const function : {"atan2", "hypot"}) {
    if (!found.contains(function)) continue;
    std::vector<double> first = series_of(table, found.at(function).at(0), number);
    const std::vector<double> second = series_of(table, found.at(function).at(1), number);
    const bool is_angle = std::string(function) == "atan2";
    for (std::size_t i = 0; i < first.size(); ++i) {
      first[i] = is_angle ? std::atan2(first[i], second[i]) : std::hypot(first[i], second[i]);
    }
    return first;
  }
  return series_of(table, found, number);
}

// On the straight lines between the values at ascending times.
double interpolate(const std::vector<double>& times, const std::vector<double>& values, double at) {
  const auto above = std::lower_bound(times.begin(), times.end(), at);
  if (above == times.end()) {
    // Accepts the last row's time up to rounding.
    if (at - times.back() < 1e-9 * std::abs(at)) return values.back();
    throw std::runtime_error("the scene ends before " + std::to_string(at));
  }
  const auto i = static_cast<std::size_t>(above - times.begin());
  if (i == 0) return values.front();
  const double part = (at - times[i - 1]) / (times[i] - times[i - 1]);
  return values[i - 1] + part * (values[i] - values[i - 1]);
}

// Twice the mean time from one passage through zero to the next.
double period_of(const std::vector<double>& times, const std::vector<double>& values) {
  std::vector<double> crossings;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if ((values[i - 1] < 0.0) == (values[i] < 0.0)) continue;
    const double part = values[i - 1] / (values[i - 1] - values[i]);
    crossings.push_back(times[i - 1] + part * (times[i] - times[i - 1]));
  }
  if (crossings.size() < 2) throw std::runtime_error("fewer than two passages through zero: no period");
  return 2.0 * (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
}

// "quantities" of the reference by name; and its rows.
const json& find_quantity(const json& reference, const std::string& name) {
  for (const json& quantity : reference.at("quantities")) {
    if (quantity.at("name") == name) return quantity;
  }
  throw std::runtime_error("the reference has no quantity \"" + name + "\"");
}

std::size_t find_column(const json& quantity, const std::string& name) {
  const json& columns = quantity.at("table").at("columns");
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == name) return i;
  }
  throw std::runtime_error("the reference's table has no column \"" + name + "\"");
}

// Returns the value of the series for the k-th of the rows compared.
double pick(const json& over, const v1::Table& table, const std::vector<double>& series, std::size_t k,
            const json* row_of_reference, const json& quantity) {
  if (series.empty()) throw std::runtime_error("the scene's table is empty");
  const auto times = [&table] { return series_of(table, {{table.columns(0), 1.0}}, 0); };
  if (over.is_object()) {
    const std::size_t column = find_column(quantity, over.at("at").get<std::string>());
    const double at = over.value("factor", 1.0) * row_of_reference->at(column).get<double>();
    return interpolate(times(), series, at);
  }
  if (over.is_number()) return series.at(over.get<std::size_t>());
  const auto how = over.get<std::string>();
  if (how == "each") return series.at(k);
  if (how == "last") return series.back();
  if (how == "max") return *std::max_element(series.begin(), series.end());
  if (how == "min") return *std::min_element(series.begin(), series.end());
  if (how == "period") return period_of(times(), series);
  throw std::runtime_error("no such \"over\": " + how);
}

// Returns the reference of relative errors: the largest of these columns, a number, or the expected value itself.
double scale_of(const json& check, const json& quantity, double expected) {
  if (!check.contains("relative_to")) return std::abs(expected);
  const json& relative = check.at("relative_to");
  if (relative.is_number()) return relative.get<double>();
  double largest = 0.0;
  for (const json& name : relative) {
    const std::size_t column = find_column(quantity, name.get<std::string>());
    for (const json& row : quantity.at("table").at("rows")) {
      largest = std::max(largest, std::abs(row.at(column).get<double>()));
    }
  }
  return largest;
}

std::vector<std::size_t> rows_of(const json& check, const json& quantity) {
  if (check.contains("rows")) return check.at("rows").get<std::vector<std::size_t>>();
  std::vector<std::size_t> rows(quantity.at("table").at("rows").size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  return rows;
}

}  // namespace

const Comparison& CheckedQuantity::worst() const {
  return *std::max_element(comparisons.begin(), comparisons.end(), [](const Comparison& a, const Comparison& b) {
    return std::abs(a.error) < std::abs(b.error);
  });
}

Expectation::Expectation(const std::filesystem::path& file)
    : file_(file),
      json_(read(file)),
      reference_id_(json_.at("reference").get<std::string>()),
      mesh_(json_.at("mesh").get<std::string>()) {
  reference_ = read(test::source_path("tests/data/reference") / (reference_id_ + ".json"));
}

std::filesystem::path Expectation::scene() const {
  std::string name = file_.filename().string();
  name.erase(name.find(".expect"), 7);
  return file_.parent_path() / name;
}

double Expectation::tolerance_of(const json& check) const {
  const json& given = reference_.at("tolerance").at(mesh_);
  const std::string name = check.value("tolerance_of", "rel_tol");
  const bool is_named = given.contains(name);
  const double of_reference = is_named ? given.at(name).get<double>() : check.at("tolerance").get<double>();
  const double tolerance = check.value("tolerance", of_reference);
  // Requires a quotation for references given in words only.
  if ((!is_named || tolerance > of_reference) && !check.contains("because")) {
    throw std::runtime_error("a tolerance of its own without \"because\": " + check.dump());
  }
  return tolerance;
}

CheckedQuantity Expectation::compare_one(const json& check, const v1::RunResult& result) const {
  const json& quantity = find_quantity(reference_, check.at("quantity").get<std::string>());
  const v1::Table& table = table_of(result, check.value("table", "probes"));
  const json over = check.value("over", json("last"));
  const double tolerance = tolerance_of(check);
  const bool is_absolute = check.value("tolerance_of", "rel_tol").starts_with("abs");
  CheckedQuantity checked;
  checked.name = check.at("quantity").get<std::string>();
  const auto add = [&](const std::string& what, std::size_t k, const json* row, double expected) {
    const std::vector<double> series = evaluate(table, check.at("found"), k);
    const double found = pick(over, table, series, k, row, quantity);
    // Compares a quantity that must not change with its own start.
    if (check.value("expected", "reference") == "start") expected = series.front();
    const double scale = is_absolute ? 1.0 : scale_of(check, quantity, expected);
    checked.comparisons.push_back({what, expected, found, (found - expected) / scale, tolerance});
  };
  if (!quantity.contains("table")) {
    add(checked.name, 0, nullptr, quantity.at("value").get<double>());
    return checked;
  }
  const auto column_name = check.at("column").get<std::string>();
  const std::size_t column = find_column(quantity, column_name);
  checked.name += ": " + column_name;
  const std::vector<std::size_t> rows = rows_of(check, quantity);
  const std::size_t first = check.value("first", std::size_t{0});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const json& row = quantity.at("table").at("rows").at(rows[k]);
    add(checked.name + ", row " + std::to_string(rows[k]), first + k, &row, row.at(column).get<double>());
  }
  return checked;
}

std::vector<CheckedQuantity> Expectation::compare(const v1::RunResult& result) const {
  std::vector<CheckedQuantity> all;
  for (const json& check : json_.at("checks")) all.push_back(compare_one(check, result));
  return all;
}

}  // namespace kerf::accuracy
