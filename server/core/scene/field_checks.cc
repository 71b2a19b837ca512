#include "server/core/scene/field_checks.h"

#include <cmath>
#include <sstream>
#include <string_view>

namespace kerf::scene {

namespace {

constexpr const char* kComponents[] = {".x", ".y", ".z"};

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

// Returns an error of cut::validate() with its path "cut.curve" replaced by `field`.
Error renamed(Error error, const std::string& field) {
  constexpr std::string_view kCurve = "cut.curve";
  for (std::string* text : {&error.field, &error.message}) {
    if (const std::size_t at = text->find(kCurve); at != std::string::npos) text->replace(at, kCurve.size(), field);
  }
  return error;
}

}  // namespace

std::string indexed(const std::string& field, std::size_t index) {
  return field + "[" + std::to_string(index) + "]";
}

Status check_number(double value, double low, double high, const std::string& field) {
  if (!std::isfinite(value)) return invalid_argument("NOT_FINITE", field + " must be a finite number", field);
  if (value >= low && value <= high) return Nothing{};
  return invalid_argument("OUT_OF_RANGE",
                          field + " is " + text(value) + "; must be in " + text(low) + ".." + text(high), field);
}

Status check_integer(std::int64_t value, std::int64_t low, std::int64_t high, const std::string& field) {
  if (value >= low && value <= high) return Nothing{};
  return invalid_argument(
      "OUT_OF_RANGE",
      field + " is " + std::to_string(value) + "; must be in " + std::to_string(low) + ".." + std::to_string(high),
      field);
}

Status check_count(std::size_t count, std::size_t limit, const std::string& unit, const std::string& field) {
  if (count <= limit) return Nothing{};
  return invalid_argument(
      "TOO_MANY", field + " has " + std::to_string(count) + " " + unit + "; the limit is " + std::to_string(limit),
      field);
}

Status check_vector(const Eigen::Vector3d& value, double limit, const std::string& field) {
  for (int k = 0; k < 3; ++k) {
    KERF_TRY(check_number(value[k], -limit, limit, field + kComponents[k]));
  }
  return Nothing{};
}

Status check_vector(const Eigen::Vector2d& value, double limit, const std::string& field) {
  for (int k = 0; k < 2; ++k) {
    KERF_TRY(check_number(value[k], -limit, limit, field + kComponents[k]));
  }
  return Nothing{};
}

Status check_length(const Eigen::Vector3d& value, double limit, const std::string& field) {
  KERF_TRY(check_vector(value, limit, field));
  if (value.norm() <= limit) return Nothing{};
  return invalid_argument("OUT_OF_RANGE", field + " has length " + text(value.norm()) + "; the limit is " + text(limit),
                          field);
}

Status check_curve(const cut::Curve& curve, const std::string& field) {
  if (const Status valid = cut::validate(curve); !valid.ok()) return renamed(valid.error(), field);
  return Nothing{};
}

Status check_vertex_id(mesh::VertexId vertex, const std::string& field) {
  if (vertex >= 0) return Nothing{};
  return invalid_argument("UNKNOWN_VERTEX", field + " is " + std::to_string(vertex) + "; vertex ids start at 0", field);
}

}  // namespace kerf::scene
