#include "server/service/svg/shapes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "server/core/cut/arc.h"
#include "server/service/svg/css_scanner.h"
#include "server/service/svg/scanner.h"

namespace kerf::svg {
namespace {

using Eigen::Vector2d;

constexpr double kAbsent = -1.0;  // Marks a missing length; lengths are never negative.

double styled_length(const std::string& value, double whole, double otherwise) {
  return parse_length(value, whole).value_or(otherwise);
}

PathData one(cut::Subpath subpath) {
  PathData data;
  data.subpaths.push_back(std::move(subpath));
  return data;
}

PathData ellipse(const Vector2d& centre, const Vector2d& semi_axes) {
  if (!(semi_axes.minCoeff() > 0.0)) return {};
  const cut::EllipsePieces pieces = cut::ellipse_pieces({centre, semi_axes, 0.0});
  cut::Subpath subpath{pieces.start, {}, true};
  for (const cut::QuadraticTo& quarter : pieces.quarters.segments) subpath.segments.emplace_back(quarter);
  return one(std::move(subpath));
}

PathData circle_of(const Declared& declared, const Viewport& viewport) {
  const Vector2d centre(styled_length(declared[Property::kCx], viewport.width(), 0.0),
                        styled_length(declared[Property::kCy], viewport.height(), 0.0));
  return ellipse(centre, Vector2d::Constant(styled_length(declared[Property::kR], viewport.diagonal(), 0.0)));
}

// Returns both radii of an ellipse or of a rectangle's corners. A missing radius equals the other one.
Vector2d radii_of(const Declared& declared, const Viewport& viewport) {
  Vector2d radii(styled_length(declared[Property::kRx], viewport.width(), kAbsent),
                 styled_length(declared[Property::kRy], viewport.height(), kAbsent));
  if (radii.x() < 0.0) radii.x() = radii.y();
  if (radii.y() < 0.0) radii.y() = radii.x();
  return radii.cwiseMax(0.0);
}

PathData ellipse_of(const Declared& declared, const Viewport& viewport) {
  const Vector2d centre(styled_length(declared[Property::kCx], viewport.width(), 0.0),
                        styled_length(declared[Property::kCy], viewport.height(), 0.0));
  return ellipse(centre, radii_of(declared, viewport));
}

PathData rectangle_of(const Declared& declared, const Viewport& viewport) {
  const Vector2d low(styled_length(declared[Property::kX], viewport.width(), 0.0),
                     styled_length(declared[Property::kY], viewport.height(), 0.0));
  const Vector2d size(styled_length(declared[Property::kWidth], viewport.width(), 0.0),
                      styled_length(declared[Property::kHeight], viewport.height(), 0.0));
  if (!(size.minCoeff() > 0.0)) return {};
  const Vector2d high = low + size;
  const Vector2d r = radii_of(declared, viewport).cwiseMin(0.5 * size);
  if (r.minCoeff() == 0.0) {
    return one({low, {cut::LineTo{{high.x(), low.y()}}, cut::LineTo{high}, cut::LineTo{{low.x(), high.y()}}}, true});
  }
  const auto corner = [&r](double x, double y) { return cut::ArcTo{r, 0.0, false, true, {x, y}}; };
  return one({{low.x() + r.x(), low.y()},
              {cut::LineTo{{high.x() - r.x(), low.y()}}, corner(high.x(), low.y() + r.y()),
               cut::LineTo{{high.x(), high.y() - r.y()}}, corner(high.x() - r.x(), high.y()),
               cut::LineTo{{low.x() + r.x(), high.y()}}, corner(low.x(), high.y() - r.y()),
               cut::LineTo{{low.x(), low.y() + r.y()}}, corner(low.x() + r.x(), low.y())},
              true});
}

PathData line_of(const pugi::xml_node& node, const Viewport& viewport) {
  const Vector2d from(length_of(node, "x1", viewport.width(), 0.0), length_of(node, "y1", viewport.height(), 0.0));
  const Vector2d to(length_of(node, "x2", viewport.width(), 0.0), length_of(node, "y2", viewport.height(), 0.0));
  return one({from, {cut::LineTo{to}}, false});
}

// Parses the points up to the first error, as with path data.
PathData points_of(const pugi::xml_node& node, bool closed, std::size_t max_segments) {
  Scanner scanner(node.attribute("points").value());
  PathData data;
  std::vector<Vector2d> points;
  scanner.skip_blanks();
  while (!scanner.at_end() && points.size() <= max_segments + 1) {
    const std::optional<double> x = scanner.number();
    scanner.skip_separator();
    const std::optional<double> y = x ? scanner.number() : std::nullopt;
    if (!y) {
      data.error = "byte " + std::to_string(scanner.position()) + ": a number is missing";
      break;
    }
    points.emplace_back(*x, *y);
    scanner.skip_separator();
  }
  if (points.size() < 2) return data;
  cut::Subpath subpath{points.front(), {}, closed};
  for (std::size_t i = 1; i < points.size(); ++i) subpath.segments.emplace_back(cut::LineTo{points[i]});
  data.subpaths.push_back(std::move(subpath));
  return data;
}

// Reads the property d: none, or path("...").
PathData styled_path(const std::string& value, std::size_t max_segments) {
  CssScanner scanner(value);
  const std::string function = lower(scanner.identifier());
  if (function == "none") return {};
  PathData faulty;
  faulty.error = "the property d, which must be none or path(\"...\")";
  if (function != "path" || !scanner.accept('(')) return faulty;
  scanner.skip_blanks();
  const char quote = scanner.peek();
  if (quote != '"' && quote != '\'') return faulty;
  return parse_path_data(scanner.quoted(), max_segments);
}

}  // namespace

bool is_shape(std::string_view element) {
  constexpr std::array<std::string_view, 7> kShapes{"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"};
  return std::find(kShapes.begin(), kShapes.end(), element) != kShapes.end();
}

PathData outline_of(const pugi::xml_node& node, std::string_view element, const Declared& declared,
                    const Viewport& viewport, std::size_t max_segments) {
  if (element == "rect") return rectangle_of(declared, viewport);
  if (element == "circle") return circle_of(declared, viewport);
  if (element == "ellipse") return ellipse_of(declared, viewport);
  if (element == "line") return line_of(node, viewport);
  if (element == "polyline") return points_of(node, false, max_segments);
  if (element == "polygon") return points_of(node, true, max_segments);
  const std::string& styled = declared[Property::kD];
  return styled.empty() ? parse_path_data(node.attribute("d").value(), max_segments)
                        : styled_path(styled, max_segments);
}

}  // namespace kerf::svg
