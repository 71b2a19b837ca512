#include "server/core/cut/fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <variant>

#include <Eigen/Geometry>

#include "server/core/cut/path_flattening.h"
#include "server/core/cut/rational_piece.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// Scales a curve about the point `from`, and moves this point to `to`.
class Placing {
 public:
  Placing(const Vector2d& from, const Vector2d& to, double scale) : from_(from), to_(to), scale_(scale) {}

  [[nodiscard]] Vector2d at(const Vector2d& point) const { return scale_ * (point - from_) + to_; }

  void place(CubicBezier& bezier) const { place(bezier.points); }
  void place(Polyline& polyline) const { place(polyline.points); }
  void place(Circle& circle) const {
    circle.centre = at(circle.centre);
    circle.radius *= scale_;
  }
  void place(Ellipse& ellipse) const {
    ellipse.centre = at(ellipse.centre);
    ellipse.semi_axes *= scale_;
  }
  void place(Path& path) const {
    for (Subpath& subpath : path.subpaths) {
      subpath.start = at(subpath.start);
      for (Segment& segment : subpath.segments) {
        std::visit([this](auto& each) { place(each); }, segment);
      }
    }
  }

 private:
  void place(std::vector<Vector2d>& points) const {
    for (Vector2d& point : points) point = at(point);
  }
  void place(LineTo& line) const { line.end = at(line.end); }
  void place(QuadraticTo& quadratic) const {
    quadratic.control = at(quadratic.control);
    quadratic.end = at(quadratic.end);
  }
  void place(CubicTo& cubic) const {
    for (Vector2d& control : cubic.controls) control = at(control);
    cubic.end = at(cubic.end);
  }
  void place(ArcTo& arc) const {
    arc.semi_axes *= scale_;
    arc.end = at(arc.end);
  }

  Vector2d from_;
  Vector2d to_;
  double scale_;
};

// Returns true if an inner control point lies outside the box along `axis`. If none does and the ends are inside, the
// whole piece is, as it lies in the convex hull of its control points.
bool has_control_point_outside(const Eigen::AlignedBox2d& box, const RationalPiece& piece, int axis) {
  for (int i = 1; i < piece.degree; ++i) {
    const double at = projected(piece.points[static_cast<std::size_t>(i)])[axis];
    if (!(at >= box.min()[axis] && at <= box.max()[axis])) return true;
  }
  return false;
}

void extend(Eigen::AlignedBox2d& box, const RationalPiece& piece) {
  box.extend(piece.start);
  box.extend(piece.end);
  for (int axis = 0; piece.degree > 1 && axis < 2; ++axis) {
    if (!has_control_point_outside(box, piece, axis)) continue;
    for (const double t : turning_parameters(piece, axis)) {
      if (t > 0.0 && t < 1.0) box.extend(split(piece, t).first.end);
    }
  }
}

void extend(Eigen::AlignedBox2d& box, const SubpathPieces& subpath) {
  for (const RationalPiece& piece : subpath.pieces) extend(box, piece);
}

void extend(Eigen::AlignedBox2d& box, const CubicBezier& bezier) {
  const auto& p = bezier.points;
  for (std::size_t i = 0; i + 3 < p.size(); i += 3) {
    extend(box, piece_of(p[i], CubicTo{{p[i + 1], p[i + 2]}, p[i + 3], {1.0, 1.0, 1.0, 1.0}}));
  }
}

void extend(Eigen::AlignedBox2d& box, const Polyline& polyline) {
  for (const Vector2d& point : polyline.points) box.extend(point);
}

void extend(Eigen::AlignedBox2d& box, const Circle& circle) {
  const Vector2d radius = Vector2d::Constant(circle.radius);
  box.extend(circle.centre - radius);
  box.extend(circle.centre + radius);
}

void extend(Eigen::AlignedBox2d& box, const Ellipse& ellipse) {
  extend(box, pieces_of(ellipse));
}

void extend(Eigen::AlignedBox2d& box, const Path& path) {
  for (const Subpath& subpath : path.subpaths) extend(box, pieces_of(subpath));
}

// Returns the place of a line that is only a point, a piece of which all points are the same.
std::optional<Vector2d> mark_of(const Subpath& line) {
  if (line.segments.size() != 1) return std::nullopt;
  const auto* piece = std::get_if<QuadraticTo>(&line.segments.front());
  if (piece == nullptr || piece->control != line.start || piece->end != line.start) return std::nullopt;
  return line.start;
}

// Returns the box that two points at the beginning of a path span, if it begins so and is more than these.
std::optional<Box> frame_of(const Curve& curve) {
  const auto* path = std::get_if<Path>(&curve);
  if (path == nullptr || path->subpaths.size() < 3) return std::nullopt;
  const std::optional<Vector2d> first = mark_of(path->subpaths[0]);
  const std::optional<Vector2d> second = mark_of(path->subpaths[1]);
  if (!first || !second) return std::nullopt;
  return Box{first->cwiseMin(*second), first->cwiseMax(*second)};
}

Status check_coordinate(double value, const std::string& field) {
  if (std::abs(value) <= kMaxCoordinateM) return Nothing{};  // false for NaN
  return invalid_argument("FIT_OUT_OF_RANGE",
                          field + " is " + std::to_string(value) + " m; the limit is 10000 m either way", field);
}

}  // namespace

Status validate(const Fit& fit) {
  for (int axis = 0; fit.box && axis < 2; ++axis) {
    const std::string low = axis == 0 ? "cut.fit.min.x" : "cut.fit.min.y";
    const std::string high = axis == 0 ? "cut.fit.max.x" : "cut.fit.max.y";
    KERF_TRY(check_coordinate(fit.box->low[axis], low));
    KERF_TRY(check_coordinate(fit.box->high[axis], high));
    if (fit.box->high[axis] - fit.box->low[axis] >= kMinFitExtentM) continue;
    return invalid_argument("FIT_EMPTY", high + " must be above " + low, high);
  }
  return Nothing{};
}

Box extent(const Curve& curve) {
  Eigen::AlignedBox2d box;
  std::visit([&box](const auto& alternative) { extend(box, alternative); }, curve);
  return {box.min(), box.max()};
}

Box frame(const Curve& curve) {
  return frame_of(curve).value_or(extent(curve));
}

Status fit_into(const Box& box, Curve& curve) {
  const Box own = frame(curve);
  const Vector2d size = own.high - own.low;
  if (!(size.maxCoeff() >= kMinFitExtentM)) {
    return invalid_argument("CURVE_DEGENERATE", "the curve is smaller than 1e-9 m, too small to be fitted into a box",
                            "cut.curve");
  }
  double scale = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    // Ignores an axis along which the curve has no extent up to rounding: it fits there at any scale.
    if (size[axis] > 1.0e-12 * size.maxCoeff()) {
      scale = std::min(scale, (box.high[axis] - box.low[axis]) / size[axis]);
    }
  }
  const Placing placing(own.low + 0.5 * size, box.low + 0.5 * (box.high - box.low), scale);
  std::visit([&placing](auto& alternative) { placing.place(alternative); }, curve);
  return Nothing{};
}

void shift(const Vector2d& by, Curve& curve) {
  const Placing placing(Vector2d::Zero(), by, 1.0);
  std::visit([&placing](auto& alternative) { placing.place(alternative); }, curve);
}

}  // namespace kerf::cut
