#include "server/core/cut/curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/cut/calls.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

double distance_to_segment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double t = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - a - t * along).norm();
}

double distance_to_stroke(const Vector2d& point, const Stroke& stroke) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
    best = std::min(best, distance_to_segment(point, stroke.points[i], stroke.points[i + 1]));
  }
  return best;
}

Vector2d bezier_point(const CubicBezier& curve, std::size_t piece, double t) {
  const auto& p = curve.points;
  const std::size_t i = 3 * piece;
  const double s = 1.0 - t;
  return s * s * s * p[i] + 3.0 * s * s * t * p[i + 1] + 3.0 * s * t * t * p[i + 2] + t * t * t * p[i + 3];
}

const Error& error_of(const Status& status) {
  return status.error();
}

TEST(CutCurve, FlattenedBezierStaysWithinItsStatedDeviation) {
  SeededRandom random(1);
  for (int trial = 0; trial < 200; ++trial) {
    CubicBezier curve;
    const int pieces = 1 + static_cast<int>(random.below(3));
    for (int i = 0; i < 3 * pieces + 1; ++i) curve.points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1));
    const double tolerance = std::pow(10.0, random.uniform(-4.0, -0.5));
    const FlatCurve flat = flatten(curve, tolerance);
    ASSERT_EQ(flat.strokes.size(), 1U);
    EXPECT_LE(flat.deviation_m, tolerance + 1e-12);
    for (int piece = 0; piece < pieces; ++piece) {
      for (int k = 0; k <= 200; ++k) {
        const Vector2d point = bezier_point(curve, static_cast<std::size_t>(piece), k / 200.0);
        ASSERT_LE(distance_to_stroke(point, flat.strokes[0]), flat.deviation_m + 1e-14) << "trial " << trial;
      }
      EXPECT_TRUE(contains(flat.strokes[0], curve.points[static_cast<std::size_t>(3 * piece)]));
      EXPECT_TRUE(contains(flat.strokes[0], curve.points[static_cast<std::size_t>(3 * piece + 3)]));
    }
  }
}

TEST(CutCurve, FlattenedBezierPointsLieOnTheCurve) {
  CubicBezier curve{{{0, 0}, {0.3, 1}, {0.7, -1}, {1, 0}}};
  const FlatCurve flat = flatten(curve, 1e-3);
  for (const Vector2d& point : flat.strokes[0].points) {
    double best = 1.0;
    for (int k = 0; k <= 20000; ++k) best = std::min(best, (bezier_point(curve, 0, k / 20000.0) - point).norm());
    EXPECT_LT(best, 2e-4);
  }
  EXPECT_GE(flat.strokes[0].points.size(), 20U);
}

TEST(CutCurve, KeepsTheCuspAsAPoint) {
  // Crossed handles of equal length: a cusp at t = 1/2, (0.5, 0.75).
  const CubicBezier curve{{{0, 0}, {1, 1}, {0, 1}, {1, 0}}};
  const FlatCurve flat = flatten(curve, 0.3);
  double best = 1.0;
  for (const Vector2d& point : flat.strokes[0].points) best = std::min(best, (point - Vector2d(0.5, 0.75)).norm());
  EXPECT_LT(best, 1e-12);
}

TEST(CutCurve, KeepsTheTurningPointOfAFoldedLine) {
  // x(t) = 6 t s^2 runs out to 8/9 at t = 1/3 and back again.
  const CubicBezier curve{{{0, 0}, {2, 2}, {0, 0}, {0, 0}}};
  const FlatCurve flat = flatten(curve, 0.5);
  double farthest = 0.0;
  for (const Vector2d& point : flat.strokes[0].points) farthest = std::max(farthest, point.x());
  EXPECT_NEAR(farthest, 8.0 / 9.0, 1e-12);
}

TEST(CutCurve, FlattenedCircleIsClosedAndWithinItsStatedDeviation) {
  for (const double radius : {1e-6, 0.01, 0.3, 50.0, 1e4}) {
    for (const double tolerance : {1e-5, 1e-3, 0.1}) {
      const Circle circle{{0.4, -0.2}, radius};
      const FlatCurve flat = flatten(circle, tolerance);
      const auto& points = flat.strokes.at(0).points;
      EXPECT_EQ(points.front(), points.back());
      EXPECT_GE(points.size(), 9U);
      double worst = 0.0;
      for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        EXPECT_NEAR((points[i] - circle.centre).norm(), radius, 1e-14 + 1e-15 * radius);
        worst = std::max(worst, radius - (0.5 * (points[i] + points[i + 1]) - circle.centre).norm());
      }
      EXPECT_LE(worst, flat.deviation_m);
      EXPECT_LE(flat.deviation_m, std::max(tolerance, 0.09 * radius) + 1e-10);
    }
  }
}

TEST(CutCurve, PolylineKeepsItsPointsAndDropsCoincidentNeighbours) {
  const Polyline line{{{0, 0}, {0, 0}, {1, 0}, {1, 1}, {1, 1}, {1, 1}, {0, 0}}};
  const FlatCurve flat = flatten(line, 1e-3);
  ASSERT_EQ(flat.strokes.size(), 1U);
  const std::vector<Vector2d> expected{{0, 0}, {1, 0}, {1, 1}, {0, 0}};
  EXPECT_EQ(flat.strokes[0].points, expected);
  EXPECT_EQ(flat.deviation_m, 0.0);
}

TEST(CutCurve, RefusesWithReasonAndField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  struct Case {
    Curve curve;
    const char* reason;
    const char* field;
  };
  const std::vector<Case> cases{
      {CubicBezier{{{0, 0}, {1, 0}, {nan, 1}, {1, 1}}}, "CURVE_NOT_FINITE", "cut.curve.bezier.points[2].x"},
      {CubicBezier{{{0, 0}, {1, infinity}, {0, 1}, {1, 1}}}, "CURVE_NOT_FINITE", "cut.curve.bezier.points[1].y"},
      {CubicBezier{{{0, 0}, {1, 0}, {0, 1}}}, "CURVE_TOO_SHORT", "cut.curve.bezier.points"},
      {CubicBezier{{{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 2}}}, "CURVE_TOO_SHORT", "cut.curve.bezier.points"},
      {CubicBezier{std::vector<Vector2d>(196, Vector2d(0, 0))}, "CURVE_TOO_LONG", "cut.curve.bezier.points"},
      {CubicBezier{std::vector<Vector2d>(4, Vector2d(2, 3))}, "CURVE_DEGENERATE", "cut.curve.bezier.points"},
      {Polyline{{{0, 0}}}, "CURVE_TOO_SHORT", "cut.curve.polyline.points"},
      {Polyline{{}}, "CURVE_TOO_SHORT", "cut.curve.polyline.points"},
      {Polyline{{{0, 0}, {10000.001, 0}}}, "CURVE_OUT_OF_RANGE", "cut.curve.polyline.points[1].x"},
      {Polyline{{{0, 0}, {0, 0}}}, "CURVE_DEGENERATE", "cut.curve.polyline.points"},
      {Polyline{std::vector<Vector2d>(4097, Vector2d(0, 0))}, "CURVE_TOO_LONG", "cut.curve.polyline.points"},
      {Circle{{0, 0}, 0.0}, "RADIUS_NOT_POSITIVE", "cut.curve.circle.radius_m"},
      {Circle{{0, 0}, -1.0}, "RADIUS_NOT_POSITIVE", "cut.curve.circle.radius_m"},
      {Circle{{0, 0}, nan}, "CURVE_NOT_FINITE", "cut.curve.circle.radius_m"},
      {Circle{{0, -infinity}, 1.0}, "CURVE_NOT_FINITE", "cut.curve.circle.center.y"},
      {Circle{{1e5, 0}, 1.0}, "CURVE_OUT_OF_RANGE", "cut.curve.circle.center.x"},
  };
  for (const Case& item : cases) {
    const Status status = validate(item.curve);
    ASSERT_FALSE(status.ok()) << item.reason << " " << item.field;
    EXPECT_EQ(error_of(status).code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(error_of(status).reason, item.reason);
    EXPECT_EQ(error_of(status).field, item.field);
  }
}

TEST(CutCurve, AcceptsTheLimitsThemselves) {
  std::vector<Vector2d> points(4096, Vector2d(0, 0));
  points.back() = Vector2d(1e4, -1e4);
  EXPECT_TRUE(validate(Polyline{points}).ok());
  points.resize(193);
  points.back() = Vector2d(1, 1);
  EXPECT_TRUE(validate(CubicBezier{points}).ok());
  EXPECT_TRUE(validate(Circle{{1e4, 1e4}, 1e4}).ok());
}

}  // namespace
}  // namespace kerf::cut
