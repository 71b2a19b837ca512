// Fitting a curve into a box, and perforation.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/dash.h"
#include "server/core/cut/fit.h"
#include "server/core/cut/stroke.h"
#include "tests/cut/calls.h"
#include "tests/support/meshes.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

void expect_box(const Box& box, const Vector2d& low, const Vector2d& high) {
  EXPECT_LT((box.low - low).norm(), 1e-12) << box.low.transpose();
  EXPECT_LT((box.high - high).norm(), 1e-12) << box.high.transpose();
}

double length_of(const Stroke& stroke) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) length += (stroke.points[i + 1] - stroke.points[i]).norm();
  return length;
}

FlatCurve flat_line(std::vector<Vector2d> points) {
  return {{Stroke{std::move(points)}}, 1e-9};
}

TEST(CutFit, TwoPointsFirstAreTheFrame) {
  const auto mark = [](const Vector2d& at) { return Subpath{at, {QuadraticTo{at, at}}, false}; };
  Curve curve = Path{{mark({0, 0}), mark({4, 2}), {{1, 1}, {LineTo{{2, 1}}}, false}}};
  expect_box(frame(curve), {0, 0}, {4, 2});
  ASSERT_TRUE(fit_into({{0, 0}, {2, 2}}, curve).ok());
  const Subpath& line = std::get<Path>(curve).subpaths[2];
  EXPECT_LT((line.start - Vector2d(0.5, 1.0)).norm(), 1e-12);
  // The points themselves cut nothing.
  EXPECT_EQ(flatten(curve, 1e-3).strokes.size(), 1U);
  // A drawing of two points and no more is fitted as it is.
  expect_box(frame(Path{{mark({0, 0}), mark({4, 2})}}), {0, 0}, {4, 2});
}

TEST(CutFit, ExtentIsThatOfTheCurveNotOfItsControlPoints) {
  expect_box(extent(Circle{{1, 2}, 3}), {-2, -1}, {4, 5});
  expect_box(extent(Polyline{{{0, 1}, {2, -3}}}), {0, -3}, {2, 1});
  // y(t) = 3 t s^2 + 3 t^2 s = 3 t s, largest at 1/2: 3/4.
  expect_box(extent(CubicBezier{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}}), {0, 0}, {1, 0.75});
  // Turned by 45 degrees the half extents of an ellipse with semi-axes 3 and 1 are sqrt((9 + 1) / 2).
  const double half = std::sqrt(5.0);
  expect_box(extent(Ellipse{{0, 0}, {3, 1}, std::atan(1.0)}), {-half, -half}, {half, half});
  const Path arc{{{{1, 0}, {ArcTo{{1, 1}, 0, false, true, {-1, 0}}}, true}}};
  expect_box(extent(arc), {-1, 0}, {1, 1});
}

TEST(CutFit, FillsTheBoxAndIsCentred) {
  Curve curve = Polyline{{{10, 10}, {14, 12}}};  // 4 x 2 into 1 x 1: half of a quarter
  ASSERT_TRUE(fit_into({{0, 0}, {1, 1}}, curve).ok());
  EXPECT_EQ(std::get<Polyline>(curve).points, (std::vector<Vector2d>{{0, 0.25}, {1, 0.75}}));
  SeededRandom random(1);
  for (int trial = 0; trial < 200; ++trial) {
    Path path{{{{random.uniform(-9, 9), 1e3}, {}, true}}};
    auto& segments = path.subpaths[0].segments;
    const auto point = [&] { return Vector2d(random.uniform(-9, 9), 1e3 + random.uniform(-5, 5)); };
    segments.emplace_back(QuadraticTo{point(), point(), {1, random.uniform(0.1, 9), 1}});
    segments.emplace_back(CubicTo{{point(), point()}, point(), {1, 2, 1, random.uniform(0.1, 9)}});
    segments.emplace_back(ArcTo{{2, 1}, random.uniform(-3, 3), true, false, point()});
    Curve fitted = path;
    const Box box{{-0.2, 0.1}, {0.5, 0.9}};
    ASSERT_TRUE(fit_into(box, fitted).ok());
    const Box now = extent(fitted);
    const Vector2d size = now.high - now.low;
    EXPECT_NEAR((0.5 * (now.low + now.high) - Vector2d(0.15, 0.5)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(std::max(size.x() / 0.7, size.y() / 0.8), 1.0, 1e-9);
  }
}

TEST(CutFit, EveryKindOfCurveIsShifted) {
  const Vector2d by(0.1, -2.5);
  const Subpath lines{{1, 2},
                      {LineTo{{3, 4}}, QuadraticTo{{5, 6}, {7, 8}}, CubicTo{{{{1, 1}, {2, 2}}}, {3, 3}},
                       ArcTo{{2, 1}, 0.3, false, true, {9, 9}}}};
  for (const Curve& curve :
       {Curve(Circle{{1, 2}, 3}), Curve(Ellipse{{1, 2}, {3, 1}, 0.4}), Curve(Polyline{{{0, 1}, {2, -3}}}),
        Curve(CubicBezier{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}}), Curve(Path{{lines}})}) {
    Curve shifted = curve;
    shift(by, shifted);
    expect_box(extent(shifted), extent(curve).low + by, extent(curve).high + by);
  }
  Curve line = Polyline{{{0.3, 1.0}, {2.0, -3.0}}};
  shift(by, line);
  EXPECT_EQ(std::get<Polyline>(line).points[0], Vector2d(0.3 + 0.1, 1.0 - 2.5)) << "rounded once";
}

// Two squares of 1 m, half a metre apart.
mesh::TriangleMesh two_squares() {
  return test::must(
      mesh::import_mesh(test::indexed({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {1.5, 0}, {2.5, 0}, {2.5, 1}, {1.5, 1}},
                                      {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}})));
}

TEST(CutRoom, IsNotLeftByACut) {
  CutRequest request;
  request.curve = Polyline{{{-9.0, 0.4}, {9.0, 0.4}}};
  mesh::TriangleMesh mesh = two_squares();
  request.room = Box{{1.3, -0.2}, {2.7, 1.2}};
  EXPECT_EQ(apply(mesh, plan(mesh, request).value())->report.pieces, 3);
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  request.room = Box{{-0.2, -0.2}, {1.2, 1.2}};
  EXPECT_EQ(apply(mesh, plan(mesh, request).value())->report.pieces, 4);
  request.room = Box{{5.0, 5.0}, {6.0, 6.0}};
  EXPECT_EQ(apply(mesh, plan(mesh, request).value())->status, CutStatus::kNoIntersection);
}

TEST(CutRoom, IsNotLeftByAStripHoweverWide) {
  for (const double width : {0.1, 0.7, 3.0, 40.0}) {
    CutRequest request;
    request.curve = Polyline{{{-9.0, 0.4}, {9.0, 0.4}}};
    request.options.width_m = width;
    request.room = Box{{-0.2, -0.2}, {1.2, 1.2}};
    mesh::TriangleMesh mesh = two_squares();
    const CutOutcome done = apply(mesh, plan(mesh, request).value()).value();
    EXPECT_EQ(done.status, CutStatus::kApplied);
    const double below = std::min(0.4, 0.5 * width), above = std::min(0.6, 0.5 * width);
    EXPECT_NEAR(done.report.removed_area_m2, below + above, 1e-3) << width;
    EXPECT_EQ(mesh.find_violation(), std::nullopt);
    double right = 0.0;
    for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (mesh.is_solid(t) && mesh.rest_position(mesh.vertices(t)[0]).x() > 1.2) right += mesh.area(t);
    }
    EXPECT_NEAR(right, 1.0, 1e-12) << width;
  }
}

TEST(CutFit, StraightLinesAlongAnAxisFitToo) {
  Curve line = Polyline{{{3, 5}, {3, 7}}};
  ASSERT_TRUE(fit_into({{0, 0}, {2, 1}}, line).ok());
  EXPECT_EQ(std::get<Polyline>(line).points, (std::vector<Vector2d>{{1, 0}, {1, 1}}));
  Curve dot = Circle{{3, 5}, 4e-10};
  EXPECT_EQ(fit_into({{0, 0}, {2, 1}}, dot).error().reason, "CURVE_DEGENERATE");
}

TEST(CutFit, PlansInTheSheetWhereNoBoxIsGiven) {
  const mesh::TriangleMesh mesh = grid(11);
  CutRequest request{Circle{{700, -50}, 20}, {}, {}};
  request.options.fit = Fit{};
  const Result<CutPlan> whole = plan(mesh, request);
  ASSERT_TRUE(whole.ok());
  for (const Vector2d& point : whole->strokes.at(0).points) {
    EXPECT_NEAR((point - Vector2d(0.5, 0.5)).norm(), 0.45, 1e-9);
  }
  request.options.fit = Fit{Box{{0.1, 0.1}, {0.3, 0.9}}};
  const Result<CutPlan> boxed = plan(mesh, request);
  ASSERT_TRUE(boxed.ok());
  for (const Vector2d& point : boxed->strokes.at(0).points) {
    EXPECT_NEAR((point - Vector2d(0.2, 0.5)).norm(), 0.1, 1e-9);
  }
}

TEST(CutFit, RefusesBoxesThatHoldNothing) {
  const mesh::TriangleMesh mesh = grid(3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [&](const Box& box) {
    CutRequest request{Circle{{0.5, 0.5}, 0.2}, {}, {}};
    request.options.fit = Fit{box};
    return plan(mesh, request).error();
  };
  EXPECT_EQ(error({{0, 0}, {0, 1}}).reason, "FIT_EMPTY");
  EXPECT_EQ(error({{0, 0}, {1, -1}}).field, "cut.fit.max.y");
  EXPECT_EQ(error({{nan, 0}, {1, 1}}).field, "cut.fit.min.x");
  EXPECT_EQ(error({{0, 0}, {1, 1.1e4}}).reason, "FIT_OUT_OF_RANGE");
}

TEST(CutDash, CutsAndLeavesInTurnThroughCorners) {
  // 1 m long with a corner at 0.6: dashes 0..0.25, 0.4..0.65 (round the corner), 0.8..1.
  const FlatCurve flat = *dashed(flat_line({{0, 0}, {0.6, 0}, {0.6, 0.4}}), {{0.25, 0.15}, 0.0});
  ASSERT_EQ(flat.strokes.size(), 3U);
  EXPECT_NEAR(length_of(flat.strokes[0]), 0.25, 1e-12);
  EXPECT_NEAR(length_of(flat.strokes[1]), 0.25, 1e-12);
  EXPECT_NEAR(length_of(flat.strokes[2]), 0.2, 1e-12);
  ASSERT_EQ(flat.strokes[1].points.size(), 3U);
  EXPECT_EQ(flat.strokes[1].points[1], Vector2d(0.6, 0));
  EXPECT_NEAR(flat.strokes[1].points[0].x(), 0.4, 1e-15);
  EXPECT_GE(flat.deviation_m, 1e-9);
  EXPECT_LT(flat.deviation_m, 1.1e-9);
}

TEST(CutDash, OffsetsAndOddCountsAreThoseOfSvg) {
  const auto starts = [](const std::vector<double>& lengths, double offset) {
    std::vector<double> found;
    const FlatCurve flat = *dashed(flat_line({{0, 0}, {1, 0}}), {lengths, offset});
    for (const Stroke& stroke : flat.strokes) {
      found.push_back(std::round(100 * stroke.points.front().x()));
      found.push_back(std::round(100 * stroke.points.back().x()));
    }
    return found;
  };
  EXPECT_EQ(starts({0.3}, 0), (std::vector<double>{0, 30, 60, 90}));
  EXPECT_EQ(starts({0.2, 0.1, 0.3}, 0), (std::vector<double>{0, 20, 30, 60, 80, 90}));  // 2 1 3 2 1 3
  EXPECT_EQ(starts({0.3}, 0.2), (std::vector<double>{0, 10, 40, 70}));
  EXPECT_EQ(starts({0.3}, 0.2 + 6.0), (std::vector<double>{0, 10, 40, 70}));
  EXPECT_EQ(starts({0.3}, -0.4), (std::vector<double>{0, 10, 40, 70}));
  EXPECT_EQ(starts({0.3}, 0.3), (std::vector<double>{30, 60, 90, 100}));
}

TEST(CutDash, EachStrokeBeginsAnewAndSeamsMeet) {
  FlatCurve flat = flat_line({{0, 0}, {1, 0}});
  flat.strokes.push_back(Stroke{{{0, 5}, {1, 5}}});
  const FlatCurve two = *dashed(flat, {{0.3, 0.4}, 0.0});
  ASSERT_EQ(two.strokes.size(), 4U);
  EXPECT_EQ(two.strokes[2].points.front(), Vector2d(0, 5));
  // A square of circumference 4, dashes of 1 and gaps of 0.5: the last ends where the first begins.
  const FlatCurve closed = *dashed(flat_line({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}), {{1.0, 0.5}, 0.0});
  ASSERT_EQ(closed.strokes.size(), 3U);
  EXPECT_EQ(closed.strokes.front().points.front(), closed.strokes.back().points.back());
}

TEST(CutDash, SharesOfRandomStrokesAddUp) {
  SeededRandom random(7);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Vector2d> points;
    for (int i = 0; i < 20; ++i) points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1));
    const FlatCurve whole = flat_line(points);
    const DashPattern pattern{{random.uniform(0.01, 0.5), random.uniform(0.01, 0.5)}, random.uniform(-1, 1)};
    DashPattern gaps = pattern;
    std::swap(gaps.lengths[0], gaps.lengths[1]);
    gaps.offset = pattern.offset - pattern.lengths[0];
    double total = 0.0;
    for (const DashPattern& each : {pattern, gaps}) {
      const FlatCurve part = *dashed(whole, each);
      for (const Stroke& stroke : part.strokes) {
        total += length_of(stroke);
        EXPECT_LE(length_of(stroke), each.lengths[0] + 1e-12);
      }
    }
    EXPECT_NEAR(total, length_of(whole.strokes[0]), 1e-10);
  }
}

TEST(CutDash, RefusesWithReasonAndField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(validate(DashPattern{{0.1, 0.0}, 0}).error().field, "cut.dash[1]");
  EXPECT_EQ(validate(DashPattern{{nan}, 0}).error().reason, "DASH_OUT_OF_RANGE");
  EXPECT_EQ(validate(DashPattern{{0.9e-6}, 0}).error().reason, "DASH_OUT_OF_RANGE");
  EXPECT_EQ(validate(DashPattern{{0.1}, nan}).error().field, "cut.dash_offset");
  EXPECT_EQ(validate(DashPattern{std::vector<double>(65, 0.1), 0}).error().reason, "DASH_TOO_LONG");
  EXPECT_TRUE(validate(DashPattern{std::vector<double>(64, 1e-6), -1e4}).ok());
  const Error many = dashed(flat_line({{0, 0}, {1, 0}}), {{5e-5, 4e-5}, 0.0}).error();
  EXPECT_EQ(many.code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(many.reason, "TOO_MANY_DASHES");
  EXPECT_EQ(many.field, "cut.dash");
  EXPECT_TRUE(dashed(flat_line({{0, 0}, {1, 0}}), {{5e-5, 5.1e-5}, 0.0}).ok());
}

TEST(CutDash, PerforationLeavesOnePieceWithSlits) {
  mesh::TriangleMesh mesh = grid(41);
  CutRequest request{Circle{{0.5, 0.5}, 0.3}, {}, {}};
  request.options.dash = {{0.1, 0.05}, 0.0};
  const std::int32_t chi = mesh.num_vertices();
  const CutOutcome outcome = cut(mesh, request);
  // Circumference 1.885: 12 periods of 0.15 and 0.085 of the next dash, which meets the first one at the seam.
  EXPECT_EQ(outcome.report.pieces, 1);
  EXPECT_GT(mesh.num_vertices(), chi);
  const Result<CutPlan> planned = plan(grid(41), request);
  ASSERT_EQ(planned->strokes.size(), 13U);
  double length = 0.0;
  for (const Stroke& stroke : planned->strokes) length += length_of(stroke);
  EXPECT_NEAR(length, 1.2 + (2 * std::acos(-1.0) * 0.3 - 1.8), 1e-3);
  EXPECT_LE(outcome.report.deviation_m, 0.02 * mesh.base_edge_length());
}

TEST(CutDash, AcrossTheSheetItStaysTogether) {
  mesh::TriangleMesh mesh = grid(21);
  CutRequest request{Polyline{{{-0.1, 0.52}, {1.1, 0.48}}}, {}, {}};
  EXPECT_EQ(cut(mesh, request).report.pieces, 2);
  mesh = grid(21);
  request.options.dash = {{0.08, 0.04}, 0.0};
  EXPECT_EQ(cut(mesh, request).report.pieces, 1);
}

}  // namespace
}  // namespace kerf::cut
