#include "tests/evaluation/thesis_patterns.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <utility>

#include "server/base/check.h"
#include "server/core/cut/cut.h"

namespace kerf::evaluation {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2.0 * std::numbers::pi;
const Vector2d kCentre(0.5037, 0.4971);

// A shape about the origin. The largest distance from there is about 1.
struct Shape {
  std::vector<Vector2d> points;
  bool is_bezier = false;  // control points of cubic pieces; else corners
};

// Cubic pieces through a closed curve, which has the same directions at their ends.
std::vector<Vector2d> closed_pieces(int count, const std::function<Vector2d(double)>& at) {
  constexpr double kSmall = 1e-6;
  const auto slope = [&at](double s) -> Vector2d { return (at(s + kSmall) - at(s - kSmall)) / (2.0 * kSmall); };
  std::vector<Vector2d> points{at(0.0)};
  for (int i = 0; i < count; ++i) {
    const double from = static_cast<double>(i) / count, to = static_cast<double>(i + 1) / count;
    points.push_back(at(from) + slope(from) / (3.0 * count));
    points.push_back(at(to) - slope(to) / (3.0 * count));
    points.push_back(i + 1 < count ? at(to) : points.front());
  }
  return points;
}

Shape shape_of(Kind kind) {
  switch (kind) {
    case Kind::kStraight:
      return {{{-0.75, 0.66}, {0.75, -0.66}}};
    case Kind::kCurve:
      return {{{-1.0, 0.0}, {-0.2, 1.7}, {0.2, -1.7}, {1.0, 0.0}}, true};
    case Kind::kZigzag: {
      Shape zigzag;
      for (int i = 0; i <= 12; ++i) zigzag.points.emplace_back(i / 6.0 - 1.0, i % 2 == 0 ? -0.16 : 0.16);
      return zigzag;
    }
    case Kind::kFlower:
      return {closed_pieces(36,
                            [](double s) -> Vector2d {
                              const double radius = 0.8 + 0.2 * std::sin(6.0 * kTurn * s);
                              return radius * Vector2d(std::cos(kTurn * s), std::sin(kTurn * s));
                            }),
              true};
  }
  return {};
}

cut::Curve placed(const Shape& shape, double scale, double angle, const Vector2d& at) {
  std::vector<Vector2d> points;
  const Eigen::Rotation2Dd turn(angle);
  for (const Vector2d& point : shape.points) points.push_back(at + scale * (turn * point));
  if (shape.is_bezier) return cut::CubicBezier{std::move(points)};
  return cut::Polyline{std::move(points)};
}

// Finds the scale with which a shape crosses about as many triangles as wanted.
double fitting_scale(const mesh::TriangleMesh& sheet, const Shape& shape, double wanted) {
  double extent = 0.0;
  // Control points between the ends of pieces lie outside of the curve.
  for (std::size_t i = 0; i < shape.points.size(); i += shape.is_bezier ? 3 : 1) {
    extent = std::max(extent, shape.points[i].cwiseAbs().maxCoeff());
  }
  double low = 0.01, high = 0.46 / extent;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    (count_crossed(sheet, placed(shape, middle, 0.0, kCentre)) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

int count_crossed(const mesh::TriangleMesh& sheet, const cut::Curve& curve) {
  cut::CutOptions options;
  options.method = cut::Method::kElement;
  const Result<cut::CutPlan> plan = cut::plan(sheet, {curve, options, {}});
  KERF_CHECK(plan.ok(), "a curve of the evaluation is refused");
  mesh::TriangleMesh copy = sheet;
  const Result<cut::CutOutcome> outcome = cut::apply(copy, *plan);
  KERF_CHECK(outcome.ok(), "a curve of the evaluation is refused");
  return outcome->report.crossed_triangles;
}

cut::Curve random_curve(Kind kind, const mesh::TriangleMesh& sheet, CrossedRange range, std::uint32_t seed) {
  const Shape shape = shape_of(kind);
  const double scale = fitting_scale(sheet, shape, 0.5 * (range.least + range.most));
  // Engines are the same everywhere, distributions of the standard library are not.
  std::mt19937 engine(1000U * static_cast<std::uint32_t>(kind) + seed);
  const auto within_one = [&engine] { return 2.0 * (static_cast<double>(engine()) / 4294967296.0) - 1.0; };
  for (int draw = 0; draw < 1000; ++draw) {
    const double angle = within_one() * 5.0 * kTurn / 360.0, size = scale * (1.0 + 0.03 * within_one());
    const Vector2d at = kCentre + 0.02 * Vector2d(within_one(), within_one());
    cut::Curve curve = placed(shape, size, angle, at);
    const int crossed = count_crossed(sheet, curve);
    if (crossed >= range.least && crossed <= range.most) return curve;
  }
  KERF_CHECK(false, "no curve of the evaluation crosses so many triangles");
}

std::vector<cut::Curve> single_cut(double size) {
  return {placed(shape_of(Kind::kCurve), 0.05 + 0.4 * size, 0.11, kCentre)};
}

std::vector<cut::Curve> intersecting_cuts(double size) {
  std::vector<cut::Curve> cuts;
  for (int i = 0; i < 4; ++i) {
    cuts.emplace_back(placed(shape_of(Kind::kCurve), 0.05 + 0.4 * size, 0.11 + 0.125 * kTurn * i, kCentre));
  }
  return cuts;
}

std::vector<cut::Curve> multiple_cuts(double size) {
  std::vector<cut::Curve> cuts;
  const int rows = 2 + static_cast<int>(std::lround(6.0 * size));
  for (int row = 0; row < rows; ++row) {
    const double y = 0.1 + 0.8 * (row + 0.513) / rows;
    cuts.emplace_back(placed(shape_of(Kind::kCurve), 0.1 + 0.3 * size, 0.0, {0.5037, y}));
  }
  return cuts;
}

}  // namespace kerf::evaluation
