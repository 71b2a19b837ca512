// Ellipses and elliptical arcs as rational pieces, against sine and cosine in long double.

#include "server/core/cut/arc.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/curve.h"
#include "tests/cut/exact_distance.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

TEST(CutArc, EllipsesAreClosedAndExact) {
  for (const double rotation : {0.0, 0.3, -2.0, std::numbers::pi / 2, 6.2}) {
    for (const Vector2d& semi_axes : {Vector2d(1, 1), Vector2d(0.3, 0.01), Vector2d(1e-3, 5e3)}) {
      const Ellipse ellipse{{0.4, -0.2}, semi_axes, rotation};
      for (const double tolerance : {1e-5, 1e-2}) {
        const FlatCurve flat = flatten(ellipse, tolerance * semi_axes.maxCoeff());
        const auto& points = flat.strokes.at(0).points;
        EXPECT_EQ(points.front(), points.back());
        // (x, y) of the frame of the axes satisfies (x / rx)^2 + (y / ry)^2 = 1.
        const Real c = std::cos(static_cast<Real>(rotation));
        const Real s = std::sin(static_cast<Real>(rotation));
        for (const Vector2d& point : points) {
          const Point d = (point - ellipse.centre).cast<Real>();
          const Real x = (c * d.x() + s * d.y()) / semi_axes.x();
          const Real y = (c * d.y() - s * d.x()) / semi_axes.y();
          const Real slack = 1e-14L * semi_axes.maxCoeff() / semi_axes.minCoeff();
          ASSERT_NEAR(static_cast<double>(x * x + y * y), 1.0, static_cast<double>(slack) + 1e-14);
        }
        for (int k = 0; k < 1000; ++k) {
          const Real angle = 2.0L * std::numbers::pi_v<Real> * k / 1000.0L;
          const Real x = semi_axes.x() * std::cos(angle);
          const Real y = semi_axes.y() * std::sin(angle);
          const Point point = ellipse.centre.cast<Real>() + Point(c * x - s * y, s * x + c * y);
          ASSERT_LE(distance_to_stroke(point, flat.strokes[0]), flat.deviation_m);
        }
      }
    }
  }
}

TEST(CutArc, UnitVectorsAreAccurateAndExactAtQuarters) {
  SeededRandom random(3);
  for (int trial = 0; trial < 10000; ++trial) {
    const double angle = random.uniform(-7, 7);
    const Vector2d v = unit_vector(angle);
    ASSERT_NEAR(v.x(), std::cos(angle), 1e-15);
    ASSERT_NEAR(v.y(), std::sin(angle), 1e-15);
  }
  EXPECT_EQ(unit_vector_of_degrees(90), Vector2d(0, 1));
  EXPECT_EQ(unit_vector_of_degrees(-450), Vector2d(0, -1));
  EXPECT_EQ(unit_vector_of_degrees(540), Vector2d(-1, 0));
  EXPECT_EQ(unit_vector(std::numbers::pi / 2), Vector2d(0, 1));
}

// The arc by SVG's own recipe (1.1, appendix F.6.5), in long double, with angles.
std::vector<Point> arc_samples(const Vector2d& start, const ArcTo& arc) {
  const Real c = std::cos(static_cast<Real>(arc.rotation));
  const Real s = std::sin(static_cast<Real>(arc.rotation));
  const Point half = 0.5L * (start - arc.end).cast<Real>();
  const Point p(c * half.x() + s * half.y(), c * half.y() - s * half.x());
  Real rx = arc.semi_axes.x();
  Real ry = arc.semi_axes.y();
  const Real lambda = p.x() * p.x() / (rx * rx) + p.y() * p.y() / (ry * ry);
  if (lambda > 1) {
    rx *= std::sqrt(lambda);
    ry *= std::sqrt(lambda);
  }
  const Real below = rx * rx * p.y() * p.y() + ry * ry * p.x() * p.x();
  const Real above = std::max(0.0L, rx * rx * ry * ry - below);
  const Real factor = (arc.large != arc.counter_clockwise ? 1 : -1) * std::sqrt(above / below);
  const Point centre(factor * rx * p.y() / ry, -factor * ry * p.x() / rx);
  const Real from = std::atan2((p.y() - centre.y()) / ry, (p.x() - centre.x()) / rx);
  Real sweep = std::atan2((-p.y() - centre.y()) / ry, (-p.x() - centre.x()) / rx) - from;
  if (arc.counter_clockwise && sweep < 0) sweep += 2 * std::numbers::pi_v<Real>;
  if (!arc.counter_clockwise && sweep > 0) sweep -= 2 * std::numbers::pi_v<Real>;
  const Point middle = 0.5L * (start + arc.end).cast<Real>();
  std::vector<Point> samples;
  for (int k = 0; k <= 300; ++k) {
    const Real angle = from + sweep * k / 300.0L;
    const Point at(centre.x() + rx * std::cos(angle), centre.y() + ry * std::sin(angle));
    samples.push_back(middle + Point(c * at.x() - s * at.y(), s * at.x() + c * at.y()));
  }
  return samples;
}

TEST(CutArc, ArcsAreThoseOfSvg) {
  SeededRandom random(5);
  for (int trial = 0; trial < 3000; ++trial) {
    const Vector2d start(random.uniform(-1, 1), random.uniform(-1, 1));
    ArcTo arc;
    arc.end = Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
    arc.semi_axes = {std::pow(10.0, random.uniform(-2, 1)), std::pow(10.0, random.uniform(-2, 1))};
    arc.rotation = random.uniform(-6, 6);
    arc.large = random.below(2) == 1;
    arc.counter_clockwise = random.below(2) == 1;
    const FlatCurve flat = flatten(path_of(start, {arc}), 1e-3);
    EXPECT_EQ(flat.strokes.at(0).points.front(), start);
    EXPECT_EQ(flat.strokes[0].points.back(), arc.end);
    EXPECT_LE(flat.deviation_m, 1.01e-3);
    const std::vector<Point> samples = arc_samples(start, arc);
    for (const Point& sample : samples) {
      ASSERT_LE(distance_to_stroke(sample, flat.strokes[0]), flat.deviation_m) << trial;
    }
    // Nor does the polyline do anything else, such as going round once more.
    Real length = 0.0L;
    Real expected = 0.0L;
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) expected += (samples[i + 1] - samples[i]).norm();
    for (std::size_t i = 0; i + 1 < flat.strokes[0].points.size(); ++i) {
      length += (flat.strokes[0].points[i + 1] - flat.strokes[0].points[i]).norm();
    }
    ASSERT_NEAR(static_cast<double>(length / expected), 1.0, 0.1) << trial;
  }
}

TEST(CutArc, ArcsAtTheEdgesOfTheirCases) {
  // Half a circle, exactly: through (0, 1) counter-clockwise from (1, 0).
  const FlatCurve half = flatten(path_of({1, 0}, {ArcTo{{1, 1}, 0, false, true, {-1, 0}}}), 1e-2);
  EXPECT_LE(distance_to_stroke(Point(0, 1), half.strokes.at(0)), half.deviation_m);
  EXPECT_EQ(half.strokes[0].points.size(),
            flatten(path_of({1, 0}, {ArcTo{{1, 1}, 0, true, true, {-1, 0}}}), 1e-2).strokes.at(0).points.size());
  // Semi-axes that do not reach are lengthened: the same.
  const FlatCurve lengthened = flatten(path_of({1, 0}, {ArcTo{{0.1, 0.1}, 0, false, true, {-1, 0}}}), 1e-2);
  EXPECT_LE(distance_to_stroke(Point(0, 1), lengthened.strokes.at(0)), lengthened.deviation_m);
  // Nearly the whole circle, and nearly nothing.
  const Vector2d near(1, 1e-9);
  const FlatCurve whole = flatten(path_of({1, 0}, {ArcTo{{1, 1}, 0, true, false, near}}), 1e-2);
  EXPECT_LE(distance_to_stroke(Point(-1, 0), whole.strokes.at(0)), whole.deviation_m + 1e-8);
  const FlatCurve little = flatten(path_of({1, 0}, {ArcTo{{1, 1}, 0, false, true, near}}), 1e-2);
  EXPECT_EQ(little.strokes.at(0).points.size(), 2U);
  // So thin that it counts as a line.
  for (const double thin : {1e-12, 1e-300, 5e-324}) {
    const FlatCurve line = flatten(path_of({0, 0}, {ArcTo{{1, thin}, 0, false, true, {0.3, 1}}}), 1e-2);
    EXPECT_EQ(line.strokes.at(0).points, (std::vector<Vector2d>{{0, 0}, {0.3, 1}})) << thin;
  }
  // Draws nothing between equal points, and the path continues.
  const FlatCurve none = flatten(path_of({1, 0}, {ArcTo{{1, 1}, 0, true, true, {1, 0}}, LineTo{{2, 0}}}), 1e-2);
  EXPECT_EQ(none.strokes.at(0).points, (std::vector<Vector2d>{{1, 0}, {2, 0}}));
}

}  // namespace
}  // namespace kerf::cut
