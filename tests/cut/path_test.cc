// Paths and ellipses: what flattening promises of rational pieces, checked against points of the exact curves in long
// double, and what validate() refuses.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/rational_piece.h"
#include "tests/cut/calls.h"
#include "tests/cut/exact_distance.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;
// By the definition: sum of w_i B_i p_i over sum of w_i B_i.
Point bezier_point(const std::vector<Vector2d>& points, const std::vector<double>& weights, Real t) {
  const std::size_t degree = points.size() - 1;
  const Real binomials[] = {1, degree == 2 ? 2.0L : 3.0L, degree == 2 ? 1.0L : 3.0L, 1};
  Point sum(0.0L, 0.0L);
  Real weight = 0.0L;
  for (std::size_t i = 0; i <= degree; ++i) {
    const Real b = binomials[i] * std::pow(t, static_cast<Real>(i)) * std::pow(1 - t, static_cast<Real>(degree - i));
    sum += b * weights[i] * points[i].cast<Real>();
    weight += b * weights[i];
  }
  return sum / weight;
}

// A quadratic or cubic segment of three or four points and as many weights.
Path bezier(const std::vector<Vector2d>& p, const std::vector<double>& w) {
  if (p.size() == 3) return path_of(p[0], {QuadraticTo{p[1], p[2], {w[0], w[1], w[2]}}});
  return path_of(p[0], {CubicTo{{p[1], p[2]}, p[3], {w[0], w[1], w[2], w[3]}}});
}

// Parameters that see both ends of a curve on which weights have pushed nearly all parameters to one place.
std::vector<Real> parameters() {
  std::vector<Real> all;
  for (int k = 0; k <= 200; ++k) all.push_back(k / 200.0L);
  for (int k = 0; k < 100; ++k) {
    const Real small = std::pow(10.0L, -0.08L * k);
    all.push_back(small);
    all.push_back(1.0L - small);
  }
  return all;
}

// Draws a random segment; most draw on the corners of the space.
std::vector<Vector2d> random_points(SeededRandom& random, std::size_t count) {
  std::vector<Vector2d> points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1));
  switch (random.below(6)) {
    case 0:  // collinear, overshooting
      for (Vector2d& point : points) point = Vector2d(0.3, -0.2) + point.x() * Vector2d(1.0, 0.7);
      break;
    case 1:  // two control points coincide
      points[random.below(count)] = points[random.below(count)];
      break;
    case 2:  // closed
      points.back() = points.front();
      break;
    case 3:  // far from the origin, small
      for (Vector2d& point : points) point = Vector2d(8000, -9000) + 1e-3 * point;
      break;
    default:
      break;
  }
  return points;
}

std::vector<double> random_weights(SeededRandom& random, std::size_t count) {
  const std::array<double, 4> spreads{0.0, 0.5, 1.5, 3.0};
  const double spread = spreads[random.below(4)];
  std::vector<double> weights;
  for (std::size_t i = 0; i < count; ++i) weights.push_back(std::pow(10.0, random.uniform(-spread, spread)));
  return weights;
}

TEST(CutPath, RationalSegmentsStayWithinTheirStatedDeviation) {
  SeededRandom random(11);
  const std::vector<Real> ts = parameters();
  for (int trial = 0; trial < 4000; ++trial) {
    const std::size_t count = 3 + random.below(2);
    const std::vector<Vector2d> points = random_points(random, count);
    const std::vector<double> weights = random_weights(random, count);
    const Curve curve = bezier(points, weights);
    if (!validate(curve).ok()) continue;  // all points in one
    const double tolerance = std::pow(10.0, random.uniform(-4.0, -0.5));
    const FlatCurve flat = flatten(curve, tolerance);
    ASSERT_EQ(flat.strokes.size(), 1U) << trial;
    const Stroke& stroke = flat.strokes[0];
    EXPECT_LE(flat.deviation_m, tolerance + 1e-9);
    EXPECT_EQ(stroke.points.front(), points.front());
    EXPECT_EQ(stroke.points.back(), points.back());
    std::vector<Point> samples;
    for (const Real t : ts) {
      samples.push_back(bezier_point(points, weights, t));
      ASSERT_LE(distance_to_stroke(samples.back(), stroke), flat.deviation_m) << "trial " << trial << " at " << t;
    }
    // The other way, coarser: each point of the polyline is near some sample.
    const Real apart = std::max(0.05L, 3.0L * static_cast<Real>(tolerance)) * ((points[0].x() > 100) ? 1e-3L : 1.0L);
    if (weights == std::vector<double>(count, 1.0)) {
      for (const Vector2d& point : stroke.points) {
        Real nearest = std::numeric_limits<Real>::infinity();
        for (const Point& sample : samples) nearest = std::min(nearest, (sample - point.cast<Real>()).norm());
        ASSERT_LE(nearest, apart) << "trial " << trial;
      }
    }
  }
}

TEST(CutPath, ExtremeWeightsReachTheToleranceInFewChords) {
  for (const std::array<double, 3>& w : std::vector<std::array<double, 3>>{
           {1, 1e6, 1}, {1e6, 1, 1}, {1, 1, 1e6}, {1e-3, 1e3, 1e-3}, {1e6, 1e6, 1}, {1, 1e-6, 1}}) {
    const FlatCurve flat = flatten(path_of({0, 0}, {QuadraticTo{{1, 2}, {3, 0}, w}}), 1e-4);
    EXPECT_LE(flat.deviation_m, 1e-4 + 1e-12);
    EXPECT_LE(flat.strokes.at(0).points.size(), 300U) << w[0] << " " << w[1] << " " << w[2];
  }
  for (const std::array<double, 4>& w : std::vector<std::array<double, 4>>{
           {1, 1e6, 1e6, 1}, {1e6, 1, 1, 1}, {1, 1, 1, 1e6}, {1, 1e6, 1, 1}, {1e3, 1e-3, 1e3, 1e-3}}) {
    const FlatCurve flat = flatten(path_of({0, 0}, {CubicTo{{Vector2d(1, 2), Vector2d(2, -2)}, {3, 0}, w}}), 1e-4);
    EXPECT_LE(flat.deviation_m, 1e-4 + 1e-12);
    EXPECT_LE(flat.strokes.at(0).points.size(), 600U) << w[0] << " " << w[1] << " " << w[2] << " " << w[3];
  }
}

TEST(CutPath, FlatStretchesTakeFewChords) {
  // A tight bend at one end of a long straight run: uniform chords would be as short everywhere.
  const Curve curve = path_of({0, 0}, {CubicTo{{Vector2d(100, 0), Vector2d(100, 0)}, {100, 1}, {1, 1, 1, 1}}});
  const CubicBezier uniform{{{0, 0}, {100, 0}, {100, 0}, {100, 1}}};
  EXPECT_LT(4 * flatten(curve, 1e-3).strokes.at(0).points.size(), flatten(uniform, 1e-3).strokes.at(0).points.size());
}

TEST(CutPath, KeepsCornersSubpathsAndTheClosingLine) {
  Path path;
  path.subpaths.push_back({{0, 0}, {LineTo{{1, 0}}, QuadraticTo{{1.5, 0.5}, {1, 1}, {1, 1, 1}}, LineTo{{0, 1}}}, true});
  path.subpaths.push_back({{5, 5}, {LineTo{{5, 5}}}, true});  // a point: nothing to cut
  path.subpaths.push_back({{2, 2}, {LineTo{{3, 3}}, LineTo{{3, 3}}, LineTo{{2, 2}}}, true});
  ASSERT_TRUE(validate(path).ok());
  const FlatCurve flat = flatten(path, 1e-3);
  ASSERT_EQ(flat.strokes.size(), 2U);
  for (const Vector2d& corner : {Vector2d(0, 0), Vector2d(1, 0), Vector2d(1, 1), Vector2d(0, 1)}) {
    EXPECT_TRUE(contains(flat.strokes[0], corner));
  }
  EXPECT_EQ(flat.strokes[0].points.front(), flat.strokes[0].points.back());
  EXPECT_EQ(flat.strokes[1].points, (std::vector<Vector2d>{{2, 2}, {3, 3}, {2, 2}}));
}

TEST(CutPath, KeepsCuspsAndTurningPointsOfRationalPieces) {
  // A cusp at t = 1/2 by symmetry, and so for weights that are symmetric.
  const FlatCurve cusp =
      flatten(path_of({0, 0}, {CubicTo{{Vector2d(1, 1), Vector2d(0, 1)}, {1, 0}, {1, 1, 1, 1}}}), 0.3);
  EXPECT_TRUE(std::any_of(cusp.strokes.at(0).points.begin(), cusp.strokes[0].points.end(),
                          [](const Vector2d& p) { return (p - Vector2d(0.5, 0.75)).norm() < 1e-12; }));
  // Folded onto a line: x(t) = 2 s t w / (s^2 + 2 s t w + t^2 / 2 ...) has its largest value where the derivative is 0;
  // with end weights 1 and control weight 2 between 0 and 0 that is t = 1/2: x = 4/6.
  const FlatCurve fold = flatten(path_of({0, 0}, {QuadraticTo{{1, 1}, {0, 0}, {1, 2, 1}}}), 0.5);
  ASSERT_EQ(fold.strokes.at(0).points.size(), 3U);
  EXPECT_NEAR(fold.strokes[0].points[1].x(), 2.0 / 3.0, 1e-12);
}

TEST(CutPath, LoopsSmallerThanTheToleranceStay) {
  const FlatCurve loop =
      flatten(path_of({0, 0}, {CubicTo{{Vector2d(0.1, 0), Vector2d(0, 0.1)}, {0, 0}, {1, 1, 1, 1}}}), 1.0);
  ASSERT_EQ(loop.strokes.size(), 1U);
  EXPECT_EQ(loop.strokes[0].points.size(), 3U);
  // Back at its start half way: (3 c1 + 3 c2 + e) / 8 = 0.
  const FlatCurve eight =
      flatten(path_of({0, 0}, {CubicTo{{Vector2d(1, 1), Vector2d(-4, 0)}, {9, -3}, {1, 1, 1, 1}}}), 1e-3);
  EXPECT_LE(eight.deviation_m, 1e-3 + 1e-12);
}

TEST(CutPath, RefusesWithReasonAndField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::string first = "cut.curve.path.subpaths[0].segments[0]";
  struct Case {
    Curve curve;
    std::string reason;
    std::string field;
  };
  const auto quadratic = [](double a, double b, double c) {
    return path_of({0, 0}, {QuadraticTo{{1, 1}, {2, 0}, {a, b, c}}});
  };
  const auto arc = [](const Vector2d& axes, double rotation) {
    return path_of({0, 0}, {ArcTo{axes, rotation, false, true, {1, 0}}});
  };
  const std::vector<Case> cases{
      {Path{}, "CURVE_TOO_SHORT", "cut.curve.path.subpaths"},
      {path_of({0, 0}, {}, true), "CURVE_TOO_SHORT", "cut.curve.path.subpaths[0].segments"},
      {path_of({nan, 0}, {LineTo{{1, 0}}}), "CURVE_NOT_FINITE", "cut.curve.path.subpaths[0].start.x"},
      {path_of({0, 0}, {LineTo{{1, infinity}}}), "CURVE_NOT_FINITE", first + ".line.y"},
      {path_of({0, 0}, {LineTo{{0, 0}}}), "CURVE_DEGENERATE", "cut.curve.path.subpaths"},
      {path_of({0, 0}, {LineTo{{1e4 + 1e-3, 0}}}), "CURVE_OUT_OF_RANGE", first + ".line.x"},
      {path_of({0, 0}, std::vector<Segment>(10'001, LineTo{{1, 1}})), "CURVE_TOO_LONG", "cut.curve.path.subpaths"},
      {quadratic(1, 0, 1), "CURVE_WEIGHT", first + ".quadratic.weights[1]"},
      {quadratic(1, 1, -1), "CURVE_WEIGHT", first + ".quadratic.weights[2]"},
      {quadratic(nan, 1, 1), "CURVE_NOT_FINITE", first + ".quadratic.weights[0]"},
      {quadratic(infinity, 1, 1), "CURVE_NOT_FINITE", first + ".quadratic.weights[0]"},
      {quadratic(1.1e6, 1, 1), "CURVE_WEIGHT", first + ".quadratic.weights[0]"},
      {quadratic(1e4, 1, 0.9e-2), "CURVE_WEIGHT", first + ".quadratic.weights"},
      {path_of({0, 0}, {CubicTo{{Vector2d(0, 1), Vector2d(nan, 1)}, {1, 0}, {1, 1, 1, 1}}}), "CURVE_NOT_FINITE",
       first + ".cubic.control_2.x"},
      {path_of({0, 0}, {CubicTo{{Vector2d(0, 1), Vector2d(1, 1)}, {1, 0}, {1, 1, 0, 1}}}), "CURVE_WEIGHT",
       first + ".cubic.weights[2]"},
      {arc({0, 1}, 0), "RADIUS_NOT_POSITIVE", first + ".arc.semi_axis_x_m"},
      {arc({1, nan}, 0), "CURVE_NOT_FINITE", first + ".arc.semi_axis_y_m"},
      {arc({1, 1}, 6.3), "CURVE_OUT_OF_RANGE", first + ".arc.rotation_rad"},
      {Ellipse{{0, nan}, {1, 1}, 0}, "CURVE_NOT_FINITE", "cut.curve.ellipse.center.y"},
      {Ellipse{{0, 0}, {1, -1}, 0}, "RADIUS_NOT_POSITIVE", "cut.curve.ellipse.semi_axis_y_m"},
      {Ellipse{{0, 0}, {1.1e4, 1}, 0}, "CURVE_OUT_OF_RANGE", "cut.curve.ellipse.semi_axis_x_m"},
      {Ellipse{{0, 0}, {1, 1}, nan}, "CURVE_NOT_FINITE", "cut.curve.ellipse.rotation_rad"},
  };
  for (const Case& item : cases) {
    const Status status = validate(item.curve);
    ASSERT_FALSE(status.ok()) << item.reason << " " << item.field;
    EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(status.error().reason, item.reason) << item.field;
    EXPECT_EQ(status.error().field, item.field);
  }
}

TEST(CutPath, AcceptsTheLimitsThemselves) {
  std::vector<Segment> segments(10'000, LineTo{{1e4, -1e4}});
  EXPECT_TRUE(validate(path_of({0, 0}, segments)).ok());
  EXPECT_TRUE(validate(path_of({0, 0}, {QuadraticTo{{1, 1}, {2, 0}, {1e6, 1, 1}}})).ok());
  EXPECT_TRUE(validate(path_of({0, 0}, {QuadraticTo{{1, 1}, {2, 0}, {1e-6, 1, 1}}})).ok());
  EXPECT_TRUE(validate(Ellipse{{1e4, 1e4}, {1e4, 1e-300}, -2 * std::numbers::pi}).ok());
}

TEST(CutPath, ManyHardSegmentsKeepToTheLimitOnChords) {
  // 10,000 wide loops at a tolerance that none could meet alone: the bound says what was reached instead.
  std::vector<Segment> segments;
  for (int i = 0; i < 10'000; ++i) {
    segments.emplace_back(CubicTo{{Vector2d(1e4, 1e4), Vector2d(-1e4, 1e4)}, {0.001 * i, 0}, {1, 1, 1, 1}});
  }
  const FlatCurve flat = flatten(path_of({0, 0}, segments), 1e-9);
  ASSERT_EQ(flat.strokes.size(), 1U);
  EXPECT_LE(flat.strokes[0].points.size(), kMaxPathChords + 1);
  EXPECT_GT(flat.deviation_m, 1e-9);
  EXPECT_LT(flat.deviation_m, 1e3);
}

TEST(CutPath, CutsPunchAndOpen) {
  mesh::TriangleMesh mesh = grid(21);
  EXPECT_EQ(cut(mesh, {Ellipse{{0.3, 0.4}, {0.2, 0.1}, 0.5}, {}, {}}).report.pieces, 2);
  Path path;  // a closed rational leaf and an open line through it
  path.subpaths.push_back(
      {{0.55, 0.6},
       {QuadraticTo{{0.75, 0.9}, {0.95, 0.6}, {1, 3, 1}}, ArcTo{{0.3, 0.2}, 0.1, false, false, {0.55, 0.6}}},
       true});
  path.subpaths.push_back(
      {{0.75, 0.3}, {CubicTo{{Vector2d(0.7, 0.5), Vector2d(0.8, 0.7)}, {0.75, 0.95}, {1, 2, 1, 1}}}, false});
  const CutOutcome outcome = cut(mesh, {path, {}, {}});
  EXPECT_EQ(outcome.report.pieces, 4);
  EXPECT_LE(outcome.report.deviation_m, 0.02 * mesh.base_edge_length());
}

TEST(CutPath, TwoIdenticalCutsAreOne) {
  mesh::TriangleMesh mesh = jittered(17);
  const Ellipse ellipse{{0.5, 0.5}, {0.3, 0.2}, 0.7};
  EXPECT_EQ(cut(mesh, {ellipse, {}, {}}).report.pieces, 2);
  EXPECT_EQ(cut(mesh, {ellipse, {}, {}}).status, CutStatus::kNoIntersection);
}

}  // namespace
}  // namespace kerf::cut
