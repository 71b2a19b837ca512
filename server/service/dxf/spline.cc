#include "server/service/dxf/spline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kerf::dxf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAccuracy = 1.0e-6;  // -; of the spline's size
constexpr int kMaxHalvings = 10;

Vector2d flat(const Vector3d& point) {
  return point.head<2>() / point.z();
}

// Inserts the knot `t` once (Boehm 1980), into the span that begins at knot `span`.
void insert_knot(double t, std::size_t span, int degree, std::vector<double>& knots, std::vector<Vector3d>& points) {
  const auto p = static_cast<std::size_t>(degree);
  std::vector<Vector3d> result;
  result.reserve(points.size() + 1);
  for (std::size_t i = 0; i <= points.size(); ++i) {
    if (i + p <= span) {
      result.push_back(points[i]);
    } else if (i > span) {
      result.push_back(points[i - 1]);
    } else {
      const double width = knots[i + p] - knots[i];
      const double share = width > 0.0 ? (t - knots[i]) / width : 0.0;
      result.push_back((1.0 - share) * points[i - 1] + share * points[i]);
    }
  }
  points = std::move(result);
  knots.insert(knots.begin() + static_cast<std::ptrdiff_t>(span) + 1, t);
}

// A point of a Bezier piece of any degree, and its derivative by the parameter, by de Casteljau's algorithm.
struct PointAndTangent {
  Vector2d point;
  Vector2d tangent;
};
PointAndTangent evaluated(std::vector<Vector3d> points, double t) {
  const auto degree = static_cast<double>(points.size() - 1);
  while (points.size() > 2) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) points[i] = (1.0 - t) * points[i] + t * points[i + 1];
    points.pop_back();
  }
  const Vector3d at = (1.0 - t) * points[0] + t * points[1];
  const Vector3d by = degree * (points[1] - points[0]);
  const Vector2d point = flat(at);
  return {point, (by.head<2>() - by.z() * point) / at.z()};
}

// Follows a Bezier piece between two parameters by cubic segments with its points and tangents.
void follow(const std::vector<Vector3d>& piece, double from, double to, double allowed, int halvings,
            cut::Subpath& line) {
  const PointAndTangent a = evaluated(piece, from);
  const PointAndTangent b = evaluated(piece, to);
  const double third = (to - from) / 3.0;
  const Vector2d first = a.point + third * a.tangent;
  const Vector2d second = b.point - third * b.tangent;
  double worst = 0.0;
  for (const double t : {0.25, 0.5, 0.75}) {
    const double s = 1.0 - t;
    const Vector2d on = s * s * s * a.point + 3.0 * s * s * t * first + 3.0 * s * t * t * second + t * t * t * b.point;
    worst = std::max(worst, (on - evaluated(piece, from + t * (to - from)).point).norm());
  }
  if (worst <= allowed || halvings == 0) {
    line.segments.emplace_back(cut::CubicTo{{first, second}, b.point});
    return;
  }
  const double middle = 0.5 * (from + to);
  follow(piece, from, middle, allowed, halvings - 1, line);
  follow(piece, middle, to, allowed, halvings - 1, line);
}

void add_piece(const std::vector<Vector3d>& piece, double size, cut::Subpath& line) {
  const double w = piece.front().z();
  if (piece.size() == 2) {
    line.segments.emplace_back(cut::LineTo{flat(piece[1])});
  } else if (piece.size() == 3) {
    line.segments.emplace_back(
        cut::QuadraticTo{flat(piece[1]), flat(piece[2]), {1.0, piece[1].z() / w, piece[2].z() / w}});
  } else if (piece.size() == 4) {
    line.segments.emplace_back(cut::CubicTo{
        {flat(piece[1]), flat(piece[2])}, flat(piece[3]), {1.0, piece[1].z() / w, piece[2].z() / w, piece[3].z() / w}});
  } else {
    follow(piece, 0.0, 1.0, kAccuracy * size, kMaxHalvings, line);
  }
}

}  // namespace

bool is_valid(const Spline& spline) {
  const std::size_t count = spline.points.size();
  if (spline.degree < 1 || spline.degree > kMaxDegree) return false;
  const auto degree = static_cast<std::size_t>(spline.degree);
  return count > degree && spline.knots.size() == count + degree + 1 &&
         std::is_sorted(spline.knots.begin(), spline.knots.end()) && spline.knots[degree] < spline.knots[count] &&
         (spline.weights.empty() || spline.weights.size() == count) &&
         std::all_of(spline.weights.begin(), spline.weights.end(), [](double weight) { return weight > 0.0; });
}

cut::Subpath segments_of(const Spline& spline) {
  const auto p = static_cast<std::size_t>(spline.degree);
  std::vector<double> knots = spline.knots;
  std::vector<Vector3d> points;
  Vector2d low = spline.points.front();
  Vector2d high = low;
  for (std::size_t i = 0; i < spline.points.size(); ++i) {
    const double w = spline.weights.empty() ? 1.0 : spline.weights[i];
    points.emplace_back(w * spline.points[i].x(), w * spline.points[i].y(), w);
    low = low.cwiseMin(spline.points[i]);
    high = high.cwiseMax(spline.points[i]);
  }
  const double first = knots[p];
  const double last = knots[points.size()];
  // Each knot of the curve's range gets the multiplicity of the degree.
  std::vector<double> distinct;
  for (const double t : knots) {
    if (t >= first && t <= last && (distinct.empty() || t > distinct.back())) distinct.push_back(t);
  }
  for (const double t : distinct) {
    auto multiplicity = static_cast<std::size_t>(std::count(knots.begin(), knots.end(), t));
    for (; multiplicity < p; ++multiplicity) {
      // At the end of the range the span before it counts, since no point follows.
      const auto next =
          t < last ? std::upper_bound(knots.begin(), knots.end(), t) : std::lower_bound(knots.begin(), knots.end(), t);
      insert_knot(t, static_cast<std::size_t>(next - knots.begin()) - 1, spline.degree, knots, points);
    }
  }
  cut::Subpath line;
  bool begun = false;
  for (std::size_t k = 0; k + 1 < distinct.size(); ++k) {
    // The piece between two knots has the control points up to the last occurrence of its first knot.
    const auto above = std::upper_bound(knots.begin(), knots.end(), distinct[k]);
    const auto span = static_cast<std::size_t>(above - knots.begin()) - 1;
    const std::vector<Vector3d> piece(points.begin() + static_cast<std::ptrdiff_t>(span - p),
                                      points.begin() + static_cast<std::ptrdiff_t>(span) + 1);
    if (!begun) line.start = flat(piece.front());
    begun = true;
    add_piece(piece, (high - low).maxCoeff(), line);
  }
  return line;
}

cut::Subpath through_points(const std::vector<Vector2d>& given) {
  std::vector<Vector2d> points;
  for (const Vector2d& point : given) {
    if (points.empty() || point != points.back()) points.push_back(point);
  }
  cut::Subpath line{points.front(), {}, false};
  const std::size_t n = points.size() - 1;
  if (n == 0) return line;
  std::vector<double> widths;
  for (std::size_t i = 0; i < n; ++i) widths.push_back((points[i + 1] - points[i]).norm());
  // Tangents m solve a system of three diagonals, with no curvature at both ends (Thomas's algorithm).
  std::vector<double> upper(n + 1);
  std::vector<Vector2d> tangents(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    const double before = i > 0 ? 1.0 / widths[i - 1] : 0.0;
    const double after = i < n ? 1.0 / widths[i] : 0.0;
    Vector2d right = Vector2d::Zero();
    if (i > 0) right += 3.0 * before * before * (points[i] - points[i - 1]);
    if (i < n) right += 3.0 * after * after * (points[i + 1] - points[i]);
    double pivot = 2.0 * (before + after);
    if (i > 0) {
      pivot -= before * upper[i - 1];
      right -= before * tangents[i - 1];
    }
    upper[i] = after / pivot;
    tangents[i] = right / pivot;
  }
  for (std::size_t i = n; i-- > 0;) tangents[i] -= upper[i] * tangents[i + 1];
  for (std::size_t i = 0; i < n; ++i) {
    const double third = widths[i] / 3.0;
    line.segments.emplace_back(
        cut::CubicTo{{points[i] + third * tangents[i], points[i + 1] - third * tangents[i + 1]}, points[i + 1]});
  }
  return line;
}

}  // namespace kerf::dxf
