// Splines as Bezier segments: exact up to degree 3, followed closely beyond.

#include "server/service/dxf/spline.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/service/drawing/arc_length.h"

namespace kerf::dxf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Returns a point of the spline by de Boor's algorithm, which the reader does not use.
Vector2d de_boor(const Spline& spline, double t) {
  const auto p = static_cast<std::size_t>(spline.degree);
  std::size_t k = p;
  while (k + 1 < spline.points.size() && t >= spline.knots[k + 1]) ++k;
  std::vector<Vector3d> d;
  for (std::size_t j = 0; j <= p; ++j) {
    const std::size_t i = j + k - p;
    const double w = spline.weights.empty() ? 1.0 : spline.weights[i];
    d.emplace_back(w * spline.points[i].x(), w * spline.points[i].y(), w);
  }
  for (std::size_t r = 1; r <= p; ++r) {
    for (std::size_t j = p; j >= r; --j) {
      const double low = spline.knots[j + k - p];
      const double high = spline.knots[j + 1 + k - r];
      const double share = high > low ? (t - low) / (high - low) : 0.0;
      d[j] = (1.0 - share) * d[j - 1] + share * d[j];
    }
  }
  return d[p].head<2>() / d[p].z();
}

// Returns the least distance of a point from many points of the line.
double distance_to(const cut::Subpath& line, const Vector2d& point) {
  double least = 1e9;
  Vector2d start = line.start;
  for (const cut::Segment& segment : line.segments) {
    Vector2d before = start;
    for (int i = 1; i <= 64; ++i) {
      const Vector2d at = drawing::point_at(start, segment, i / 64.0);
      const Vector2d along = at - before;
      const double share = along.squaredNorm() > 0.0 ? (point - before).dot(along) / along.squaredNorm() : 0.0;
      least = std::min(least, (point - before - std::min(std::max(share, 0.0), 1.0) * along).norm());
      before = at;
    }
    start = drawing::end_of(segment);
  }
  return least;
}

void expect_followed(const Spline& spline, double accuracy) {
  ASSERT_TRUE(is_valid(spline));
  const cut::Subpath line = segments_of(spline);
  const double first = spline.knots[static_cast<std::size_t>(spline.degree)];
  const double last = spline.knots[spline.points.size()];
  EXPECT_LT((line.start - de_boor(spline, first)).norm(), 1e-9);
  EXPECT_LT((drawing::end_of(line.segments.back()) - de_boor(spline, last)).norm(), 1e-9);
  for (int i = 0; i <= 100; ++i) {
    EXPECT_LT(distance_to(line, de_boor(spline, first + (last - first) * i / 100.0)), accuracy) << i;
  }
}

Spline random_spline(SeededRandom& random, int degree, bool clamped, bool rational) {
  const auto number = [&random] { return static_cast<double>(random.below(1000)) / 1000.0; };
  Spline spline;
  spline.degree = degree;
  const std::size_t count = static_cast<std::size_t>(degree) + 1 + random.below(8);
  for (std::size_t i = 0; i < count; ++i) {
    spline.points.emplace_back(number(), number());
    if (rational) spline.weights.push_back(0.3 + number());
  }
  const std::size_t num_knots = count + static_cast<std::size_t>(degree) + 1;
  double at = 0.0;
  for (std::size_t i = 0; i < num_knots; ++i) {
    const bool is_inner = i > static_cast<std::size_t>(degree) && i < count;
    // A knot repeated more often than the degree would break the curve.
    const bool repeats = is_inner && degree > 1 && random.below(6) == 0 &&
                         std::count(spline.knots.begin(), spline.knots.end(), at) < degree;
    if (i > 0 && (!clamped || is_inner || i == count) && !repeats) at += 0.2 + number();
    spline.knots.push_back(at);
  }
  return spline;
}

TEST(DxfSpline, SegmentsFollowTheSpline) {
  SeededRandom random(3);
  for (int trial = 0; trial < 60; ++trial) {
    for (const int degree : {1, 2, 3, 4, 5}) {
      SCOPED_TRACE(degree);
      // Chords of the comparison are off by some 1e-4 of the size.
      expect_followed(random_spline(random, degree, trial % 2 == 0, trial % 3 == 0), 2e-3);
    }
  }
}

TEST(DxfSpline, ACubicPieceIsTakenAsItIs) {
  const Spline spline{3, {0, 0, 0, 0, 1, 1, 1, 1}, {{0, 0}, {1, 2}, {3, 2}, {4, 0}}, {}};
  const cut::Subpath line = segments_of(spline);
  ASSERT_EQ(line.segments.size(), 1U);
  EXPECT_EQ(std::get<cut::CubicTo>(line.segments[0]).controls[1], Vector2d(3, 2));
}

TEST(DxfSpline, ARationalQuadraticIsACircle) {
  const double w = std::sqrt(0.5);
  const Spline circle{2,
                      {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4},
                      {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}},
                      {1, w, 1, w, 1, w, 1, w, 1}};
  const cut::Subpath line = segments_of(circle);
  ASSERT_EQ(line.segments.size(), 4U);
  EXPECT_NEAR(drawing::length_of(line), 2.0 * 3.14159265358979, 1e-6);
}

TEST(DxfSpline, HigherDegreesAreFollowedToAMillionth) {
  // A quintic that is a raised parabola: y = x^2, whatever the degree.
  Spline raised{5, {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1}, {}, {}};
  for (int i = 0; i <= 5; ++i) raised.points.emplace_back(i / 5.0, i * (i - 1) / 20.0);
  const cut::Subpath line = segments_of(raised);
  Vector2d start = line.start;
  for (const cut::Segment& segment : line.segments) {
    for (const double t : {0.3, 0.7, 1.0}) {
      const Vector2d at = drawing::point_at(start, segment, t);
      EXPECT_NEAR(at.y(), at.x() * at.x(), 1e-6);
    }
    start = drawing::end_of(segment);
  }
}

TEST(DxfSpline, FaultyOnesAreNoSplines) {
  const Spline good{2, {0, 0, 0, 1, 1, 1}, {{0, 0}, {1, 1}, {2, 0}}, {}};
  EXPECT_TRUE(is_valid(good));
  Spline bad = good;
  bad.degree = 0;
  EXPECT_FALSE(is_valid(bad));
  bad = good;
  bad.knots = {0, 0, 1, 0, 1, 1};
  EXPECT_FALSE(is_valid(bad));
  bad = good;
  bad.weights = {1, 0, 1};
  EXPECT_FALSE(is_valid(bad));
  bad = good;
  bad.points.pop_back();
  EXPECT_FALSE(is_valid(bad));
}

TEST(DxfSpline, FitPointsAreMet) {
  const cut::Subpath line = through_points({{0, 0}, {1, 1}, {1, 1}, {2, 0}, {3, 1}});
  ASSERT_EQ(line.segments.size(), 3U);
  EXPECT_EQ(drawing::end_of(line.segments[0]), Vector2d(1, 1));
  const auto& first = std::get<cut::CubicTo>(line.segments[0]);
  const auto& second = std::get<cut::CubicTo>(line.segments[1]);
  const Vector2d in = first.end - first.controls[1];
  const Vector2d out = second.controls[0] - first.end;
  EXPECT_LT(std::abs(in.x() * out.y() - in.y() * out.x()), 1e-12);  // No corner.
}

}  // namespace
}  // namespace kerf::dxf
