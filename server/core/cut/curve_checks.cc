#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <type_traits>

#include "server/core/cut/curve.h"

// Implements validate(): the checks of a curve that need no sheet.
namespace kerf::cut {
namespace {

using Eigen::Vector2d;

Status check_scalar(double value, const std::string& field) {
  if (!std::isfinite(value)) return invalid_argument("CURVE_NOT_FINITE", field + " is not a finite number", field);
  if (std::abs(value) > kMaxCoordinateM) {
    return invalid_argument("CURVE_OUT_OF_RANGE",
                            field + " is " + std::to_string(value) + " m, the limit is 10000 m either way", field);
  }
  return Nothing{};
}

Status check_point(const Vector2d& point, const std::string& field) {
  if (std::abs(point.x()) <= kMaxCoordinateM && std::abs(point.y()) <= kMaxCoordinateM) return Nothing{};
  KERF_TRY(check_scalar(point.x(), field + ".x"));
  return check_scalar(point.y(), field + ".y");
}

std::string indexed(const std::string& path, std::size_t index) {
  return path + "[" + std::to_string(index) + "]";
}

Status check_points(const std::vector<Vector2d>& points, const std::string& path) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    KERF_TRY(check_point(points[i], indexed(path, i)));
  }
  const bool distinct =
      std::any_of(points.begin(), points.end(), [&](const Vector2d& point) { return point != points.front(); });
  if (!distinct) return invalid_argument("CURVE_DEGENERATE", "all points of the curve coincide", path);
  return Nothing{};
}

Status check(const CubicBezier& bezier) {
  const std::string path = "cut.curve.bezier.points";
  const std::size_t count = bezier.points.size();
  if (count > 3 * kMaxBezierPieces + 1) {
    return invalid_argument("CURVE_TOO_LONG",
                            std::to_string(count) + " control points; the limit is 193 (64 cubic pieces)", path);
  }
  if (count < 4 || count % 3 != 1) {
    return invalid_argument("CURVE_TOO_SHORT",
                            std::to_string(count) + " control points; a chain of n cubic pieces has 3 n + 1, n >= 1",
                            path);
  }
  return check_points(bezier.points, path);
}

Status check(const Polyline& polyline) {
  const std::string path = "cut.curve.polyline.points";
  const std::size_t count = polyline.points.size();
  if (count > kMaxPolylinePoints) {
    return invalid_argument("CURVE_TOO_LONG", std::to_string(count) + " points; the limit is 4096", path);
  }
  if (count < 2) return invalid_argument("CURVE_TOO_SHORT", "a polyline has at least 2 points", path);
  return check_points(polyline.points, path);
}

Status check_positive(double length, const char* name, const std::string& field) {
  KERF_TRY(check_scalar(length, field));
  if (length > 0.0) return Nothing{};
  return invalid_argument("RADIUS_NOT_POSITIVE",
                          std::string(name) + " is " + std::to_string(length) + " m; it must be above zero", field);
}

Status check_rotation(double rotation, const std::string& field) {
  if (!std::isfinite(rotation)) return invalid_argument("CURVE_NOT_FINITE", field + " is not a finite number", field);
  if (std::abs(rotation) <= kMaxRotation) return Nothing{};
  return invalid_argument("CURVE_OUT_OF_RANGE",
                          field + " is " + std::to_string(rotation) + " rad; the limit is 2 pi either way", field);
}

Status check(const Circle& circle) {
  KERF_TRY(check_point(circle.centre, "cut.curve.circle.center"));
  return check_positive(circle.radius, "the radius", "cut.curve.circle.radius_m");
}

Status check_semi_axes(const Vector2d& semi_axes, const std::string& path) {
  KERF_TRY(check_positive(semi_axes.x(), "the first semi-axis", path + ".semi_axis_x_m"));
  return check_positive(semi_axes.y(), "the second semi-axis", path + ".semi_axis_y_m");
}

Status check(const Ellipse& ellipse) {
  const std::string path = "cut.curve.ellipse";
  KERF_TRY(check_point(ellipse.centre, path + ".center"));
  KERF_TRY(check_semi_axes(ellipse.semi_axes, path));
  return check_rotation(ellipse.rotation, path + ".rotation_rad");
}

template <std::size_t count>
Status check_weights(const std::array<double, count>& weights, const std::string& path) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::string field = indexed(path, i);
    if (!std::isfinite(weights[i])) {
      return invalid_argument("CURVE_NOT_FINITE", field + " is not a finite number", field);
    }
    if (weights[i] >= kMinWeight && weights[i] <= kMaxWeight) continue;
    return invalid_argument("CURVE_WEIGHT",
                            field + " is " + std::to_string(weights[i]) + "; a weight is positive, 1e-6 to 1e6", field);
  }
  const auto [smallest, largest] = std::minmax_element(weights.begin(), weights.end());
  if (*largest <= kMaxWeightRatio * *smallest) return Nothing{};
  return invalid_argument("CURVE_WEIGHT", path + " differ by a factor above 1e6; bring them closer together", path);
}

Status check(const LineTo& line, const std::string& path) {
  return check_point(line.end, path + ".line");
}

Status check(const QuadraticTo& quadratic, const std::string& path) {
  const std::string field = path + ".quadratic";
  KERF_TRY(check_point(quadratic.control, field + ".control"));
  KERF_TRY(check_point(quadratic.end, field + ".end"));
  return check_weights(quadratic.weights, field + ".weights");
}

Status check(const CubicTo& cubic, const std::string& path) {
  const std::string field = path + ".cubic";
  KERF_TRY(check_point(cubic.controls[0], field + ".control_1"));
  KERF_TRY(check_point(cubic.controls[1], field + ".control_2"));
  KERF_TRY(check_point(cubic.end, field + ".end"));
  return check_weights(cubic.weights, field + ".weights");
}

Status check(const ArcTo& arc, const std::string& path) {
  const std::string field = path + ".arc";
  KERF_TRY(check_point(arc.end, field + ".end"));
  KERF_TRY(check_semi_axes(arc.semi_axes, field));
  return check_rotation(arc.rotation, field + ".rotation_rad");
}

// Returns true if a segment has a point other than its start.
bool moves(const Vector2d& from, const Segment& segment) {
  return std::visit(
      [&from](const auto& each) {
        using Kind = std::decay_t<decltype(each)>;
        if constexpr (std::is_same_v<Kind, QuadraticTo>) return each.control != from || each.end != from;
        if constexpr (std::is_same_v<Kind, CubicTo>) {
          return each.controls[0] != from || each.controls[1] != from || each.end != from;
        }
        return each.end != from;
      },
      segment);
}

// Checks a subpath. Sets `moving` to true if it has two distinct points.
Status check(const Subpath& subpath, const std::string& path, bool& moving) {
  KERF_TRY(check_point(subpath.start, path + ".start"));
  if (subpath.segments.empty()) {
    return invalid_argument("CURVE_TOO_SHORT", "a subpath has at least one segment", path + ".segments");
  }
  Vector2d from = subpath.start;
  for (std::size_t i = 0; i < subpath.segments.size(); ++i) {
    const Segment& segment = subpath.segments[i];
    const auto check_as = [&segment](const std::string& name) {
      return std::visit([&name](const auto& each) { return check(each, name); }, segment);
    };
    // Builds the name of a segment only for an error, since a path has thousands of segments.
    if (!check_as({}).ok()) return check_as(indexed(path + ".segments", i));
    moving = moving || moves(from, segment);
    from = std::visit([](const auto& each) { return each.end; }, segment);
  }
  return Nothing{};
}

Status check(const Path& curve) {
  const std::string path = "cut.curve.path.subpaths";
  if (curve.subpaths.empty()) return invalid_argument("CURVE_TOO_SHORT", "a path has at least one subpath", path);
  std::size_t segments = 0;
  for (const Subpath& subpath : curve.subpaths) segments += subpath.segments.size();
  if (std::max(segments, curve.subpaths.size()) > kMaxPathSegments) {
    return invalid_argument("CURVE_TOO_LONG",
                            std::to_string(segments) + " segments; the limit is 10000: make several cuts of it", path);
  }
  bool moving = false;
  for (std::size_t i = 0; i < curve.subpaths.size(); ++i) {
    KERF_TRY(check(curve.subpaths[i], indexed(path, i), moving));
  }
  if (moving) return Nothing{};
  return invalid_argument("CURVE_DEGENERATE", "no subpath has two distinct points", path);
}

}  // namespace

Status validate(const Curve& curve) {
  return std::visit([](const auto& alternative) { return check(alternative); }, curve);
}

}  // namespace kerf::cut
