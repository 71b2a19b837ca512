#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "server/core/cut/curve.h"
#include "server/core/cut/path_flattening.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr int kMaxChords = 4096;  // most chords of a Bezier piece, or of an eighth of a circle

// Bounds the rounding of a point computed in a few operations from coordinates of this size.
double rounding_bound(double coordinate) {
  return 16.0 * std::numeric_limits<double>::epsilon() * coordinate;
}

double largest_coordinate(const std::vector<Vector2d>& points) {
  double largest = 0.0;
  for (const Vector2d& point : points) largest = std::max(largest, point.cwiseAbs().maxCoeff());
  return largest;
}

void append(Stroke& stroke, const Vector2d& point) {
  if (stroke.points.empty() || stroke.points.back() != point) stroke.points.push_back(point);
}

using Piece = std::array<Vector2d, 4>;

Vector2d evaluate(const Piece& p, double t) {
  const double s = 1.0 - t;
  const Vector2d ab = s * p[0] + t * p[1];
  const Vector2d bc = s * p[1] + t * p[2];
  const Vector2d cd = s * p[2] + t * p[3];
  const Vector2d abc = s * ab + t * bc;
  const Vector2d bcd = s * bc + t * cd;
  return s * abc + t * bcd;
}

// Appends the real roots of a t^2 + b t + c, at most 2, by the formula without cancellation. A slightly negative
// discriminant counts as 0.
void append_roots(double a, double b, double c, std::vector<double>& roots) {
  const double discriminant = std::max(b * b - 4.0 * a * c, 0.0);
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  if (a != 0.0) roots.push_back(q / a);
  if (q != 0.0) roots.push_back(c / q);
}

// Returns the parameters in (0, 1) where the derivative B'(t) vanishes: at cusps, and where a curve on a straight line
// turns back.
std::vector<double> cusps(const Piece& p) {
  const Vector2d d0 = p[1] - p[0];
  const Vector2d d1 = p[2] - p[1];
  const Vector2d d2 = p[3] - p[2];
  const Vector2d a = d0 - 2.0 * d1 + d2;
  const Vector2d b = 2.0 * (d1 - d0);
  std::vector<double> candidates;
  for (int axis = 0; axis < 2; ++axis) append_roots(a[axis], b[axis], d0[axis], candidates);
  const double scale = d0.norm() + d1.norm() + d2.norm();
  std::vector<double> found;
  for (const double t : candidates) {
    if (!(t > 0.0 && t < 1.0)) continue;
    const Vector2d hodograph = (a * t + b) * t + d0;
    if (hodograph.norm() <= 1e-7 * scale) found.push_back(t);
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Appends the chords of a piece to `stroke`. Returns the proven bound on their distance from the piece, m.
double flatten_piece(const Piece& p, double tolerance, Stroke& stroke) {
  const double second = std::max((p[0] - 2.0 * p[1] + p[2]).norm(), (p[1] - 2.0 * p[2] + p[3]).norm());
  const double wanted = std::ceil(std::sqrt(0.75 * second / tolerance));
  const int chords = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMaxChords)));
  const std::vector<double> cusp_parameters = cusps(p);
  auto cusp = cusp_parameters.begin();
  append(stroke, p[0]);
  for (int i = 1; i <= chords; ++i) {
    const double t = static_cast<double>(i) / chords;
    // Cusps are extra points: they only shorten the parameter range of a chord, so the bound holds.
    for (; cusp != cusp_parameters.end() && *cusp < t; ++cusp) append(stroke, evaluate(p, *cusp));
    append(stroke, i == chords ? p[3] : evaluate(p, t));
  }
  return 0.75 * second / (static_cast<double>(chords) * chords);
}

FlatCurve flat(const CubicBezier& bezier, double tolerance) {
  FlatCurve result;
  Stroke stroke;
  for (std::size_t i = 0; i + 3 < bezier.points.size(); i += 3) {
    const Piece piece{bezier.points[i], bezier.points[i + 1], bezier.points[i + 2], bezier.points[i + 3]};
    result.deviation_m = std::max(result.deviation_m, flatten_piece(piece, tolerance, stroke));
  }
  result.deviation_m += rounding_bound(largest_coordinate(bezier.points));
  if (stroke.points.size() >= 2) result.strokes.push_back(std::move(stroke));
  return result;
}

FlatCurve flat(const Polyline& polyline, double /*tolerance*/) {
  FlatCurve result;
  Stroke stroke;
  for (const Vector2d& point : polyline.points) append(stroke, point);
  if (stroke.points.size() >= 2) result.strokes.push_back(std::move(stroke));
  return result;
}

// Returns points of the unit circle from 0 to 45 degrees by the rational parametrisation ((1 - u^2) / (1 + u^2), 2 u /
// (1 + u^2)), u = tan(angle / 2) in [0, tan(pi / 8)]. It takes correctly rounded operations only, so that every machine
// gets the same bits, unlike with sine and cosine.
std::vector<Vector2d> unit_octant(int chords) {
  const double u_end = std::sqrt(2.0) - 1.0;
  std::vector<Vector2d> points;
  for (int i = 0; i <= chords; ++i) {
    const double u = u_end * i / chords;
    const double w = 1.0 + u * u;
    points.emplace_back((1.0 - u * u) / w, 2.0 * u / w);
  }
  return points;
}

FlatCurve flat(const Circle& circle, double tolerance) {
  // d(angle)/du = 2 / (1 + u^2) <= 2, so a chord spans at most step = 2 tan(pi / 8) / chords, and
  // r (1 - cos(step / 2)) <= r step^2 / 8.
  const double span = 2.0 * (std::sqrt(2.0) - 1.0);
  const double wanted = std::ceil(span * std::sqrt(circle.radius / (8.0 * tolerance)));
  const int chords = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMaxChords)));
  const std::vector<Vector2d> octant = unit_octant(chords);
  std::vector<Vector2d> quadrant(octant.begin(), octant.end());
  for (int i = chords - 1; i > 0; --i) {
    const Vector2d& mirrored = octant[static_cast<std::size_t>(i)];
    quadrant.emplace_back(mirrored.y(), mirrored.x());
  }
  Stroke stroke;
  for (int quarter = 0; quarter < 4; ++quarter) {
    for (const Vector2d& unit : quadrant) append(stroke, circle.centre + circle.radius * unit);
    for (Vector2d& unit : quadrant) unit = Vector2d(-unit.y(), unit.x());
  }
  append(stroke, stroke.points.front());
  FlatCurve result;
  const double step = span / chords;
  result.deviation_m =
      circle.radius * step * step / 8.0 + rounding_bound(circle.centre.cwiseAbs().maxCoeff() + circle.radius);
  if (stroke.points.size() >= 2) result.strokes.push_back(std::move(stroke));
  return result;
}

FlatCurve flat(const Ellipse& ellipse, double tolerance) {
  return flatten_ellipse(ellipse, tolerance);
}

FlatCurve flat(const Path& path, double tolerance) {
  return flatten_path(path, tolerance);
}

}  // namespace

FlatCurve flatten(const Curve& curve, double tolerance) {
  return std::visit([tolerance](const auto& alternative) { return flat(alternative, tolerance); }, curve);
}

}  // namespace kerf::cut
