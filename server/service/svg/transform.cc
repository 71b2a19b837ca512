#include "server/service/svg/transform.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/core/cut/arc.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Affine rotation(double degrees) {
  const Vector2d direction = cut::unit_vector_of_degrees(degrees);
  const Matrix2d linear{{direction.x(), -direction.y()}, {direction.y(), direction.x()}};
  return {linear, Vector2d::Zero()};
}

double tangent(double degrees) {
  const Vector2d direction = cut::unit_vector_of_degrees(degrees);
  return direction.y() / direction.x();
}

Affine linear_map(double xx, double xy, double yx, double yy) {
  const Matrix2d linear{{xx, xy}, {yx, yy}};
  return {linear, Vector2d::Zero()};
}

std::optional<Affine> function_value(std::string_view name, const std::vector<double>& n) {
  const std::size_t count = n.size();
  if (name == "matrix" && count == 6) {
    Affine map = linear_map(n[0], n[2], n[1], n[3]);
    map.shift = Vector2d(n[4], n[5]);
    return map;
  }
  if (name == "translate" && (count == 1 || count == 2)) return translation({n[0], count == 2 ? n[1] : 0.0});
  if (name == "scale" && (count == 1 || count == 2)) return linear_map(n[0], 0.0, 0.0, n[count - 1]);
  if (name == "translateX" && count == 1) return translation({n[0], 0.0});
  if (name == "translateY" && count == 1) return translation({0.0, n[0]});
  if (name == "scaleX" && count == 1) return linear_map(n[0], 0.0, 0.0, 1.0);
  if (name == "scaleY" && count == 1) return linear_map(1.0, 0.0, 0.0, n[0]);
  if (name == "skew" && count == 1) return linear_map(1.0, tangent(n[0]), 0.0, 1.0);
  if (name == "skew" && count == 2) return linear_map(1.0, tangent(n[0]), tangent(n[1]), 1.0);
  if (name == "rotate" && count == 1) return rotation(n[0]);
  if (name == "rotate" && count == 3) {
    const Vector2d about(n[1], n[2]);
    return translation(about) * rotation(n[0]) * translation(-about);
  }
  if (name == "skewX" && count == 1) return linear_map(1.0, tangent(n[0]), 0.0, 1.0);
  if (name == "skewY" && count == 1) return linear_map(1.0, 0.0, tangent(n[0]), 1.0);
  return std::nullopt;
}

// Returns the pixels or degrees of a unit.
std::optional<double> unit_value(std::string_view unit) {
  if (unit.empty() || unit == "px" || unit == "deg") return 1.0;
  if (unit == "grad") return 0.9;
  if (unit == "rad") return 57.29577951308232;
  if (unit == "turn") return 360.0;
  return parse_length("1" + std::string(unit), 0.0);
}

// Parses arguments such as "(1, 2 3)"; returns nothing if they are malformed.
std::optional<std::vector<double>> arguments(Scanner& scanner) {
  std::vector<double> numbers;
  scanner.skip_blanks();
  if (!scanner.accept('(')) return std::nullopt;
  scanner.skip_blanks();
  while (!scanner.accept(')')) {
    const std::optional<double> number = scanner.number();
    const std::optional<double> unit = number ? unit_value(scanner.word()) : std::nullopt;
    if (!unit || numbers.size() == 6) return std::nullopt;
    numbers.push_back(*number * *unit);
    scanner.skip_separator();
  }
  return numbers;
}

// Returns the position of the view box within the spare room of the viewport, -, 0..1. `text` is an alignment such as
// "xMinYMax"; `at` is the index of its part for this axis.
double alignment(std::string_view text, std::size_t at) {
  const std::string_view word = text.size() == 8 ? text.substr(at, 3) : std::string_view("Mid");
  if (word == "Min") return 0.0;
  return word == "Max" ? 1.0 : 0.5;
}

}  // namespace

std::optional<Affine> parse_transform(std::string_view text) {
  Scanner scanner(text);
  Affine map;
  scanner.skip_blanks();
  while (!scanner.at_end()) {
    const std::string_view name = scanner.word();
    const std::optional<std::vector<double>> numbers = arguments(scanner);
    const std::optional<Affine> next = numbers ? function_value(name, *numbers) : std::nullopt;
    if (!next) return std::nullopt;
    map = map * *next;
    scanner.skip_separator();
  }
  return map;
}

std::optional<Vector2d> parse_origin(std::string_view text, const Viewport& viewport) {
  Vector2d origin = 0.5 * viewport.size;
  int axis = 0;
  for (std::string_view rest = trimmed(text); !rest.empty(); ++axis) {
    const std::size_t end = rest.find_first_of(" \t\n\r\f");
    const std::string_view word = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : trimmed(rest.substr(end));
    if (axis == 2) return std::nullopt;
    if (word == "center") continue;
    if (word == "left" || word == "right") {
      origin.x() = word == "left" ? 0.0 : viewport.width();
    } else if (word == "top" || word == "bottom") {
      origin.y() = word == "top" ? 0.0 : viewport.height();
    } else {
      const std::optional<double> length = parse_length(word, viewport.size[axis]);
      if (!length) return std::nullopt;
      origin[axis] = *length;
    }
  }
  return origin;
}

std::optional<Rectangle> parse_view_box(std::string_view text) {
  Scanner scanner(text);
  Eigen::Vector4d numbers;
  scanner.skip_blanks();
  for (double& number : numbers) {
    const std::optional<double> value = scanner.number();
    if (!value) return std::nullopt;
    number = *value;
    scanner.skip_separator();
  }
  if (!scanner.at_end() || numbers[2] < 0.0 || numbers[3] < 0.0) return std::nullopt;
  return Rectangle{numbers.head<2>(), numbers.tail<2>()};
}

Affine view_box_transform(const Rectangle& view_box, const Rectangle& viewport, std::string_view aspect_ratio) {
  const std::string_view value = trimmed(aspect_ratio);
  const std::size_t blank = value.find(' ');
  const std::string_view align = value.substr(0, blank);
  Vector2d scale = viewport.size.cwiseQuotient(view_box.size);
  if (align != "none") {
    const bool slice = blank != std::string_view::npos && trimmed(value.substr(blank)) == "slice";
    scale = Vector2d::Constant(slice ? scale.maxCoeff() : scale.minCoeff());
  }
  const Vector2d room = viewport.size - scale.cwiseProduct(view_box.size);
  const Vector2d share(alignment(align, 1), alignment(align, 5));
  Affine map;
  map.linear = scale.asDiagonal();
  map.shift = viewport.corner + share.cwiseProduct(room) - scale.cwiseProduct(view_box.corner);
  return map;
}

}  // namespace kerf::svg
