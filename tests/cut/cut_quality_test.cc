// How close a cut comes to its curve, and how good its triangles are.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/cut/cut_calls.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// Samples of the exact curve against the lips: none farther than reported, and the report within what was asked for.
void check_deviation(const Curve& curve, const std::vector<Vector2d>& samples, double tolerance, double snap) {
  mesh::TriangleMesh mesh = jittered(20);
  CutRequest request{curve, {}, {}};
  request.options.tolerance = tolerance;
  request.options.snap = snap;
  const CutOutcome outcome = cut(mesh, request);
  std::vector<std::pair<Vector2d, Vector2d>> lips;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.is_solid(t) || (mesh.locks(t, k) & mesh::kLockCut) == 0) continue;
      lips.emplace_back(mesh.point_position(mesh.points(t)[mesh::next_corner(k)]),
                        mesh.point_position(mesh.points(t)[mesh::previous_corner(k)]));
    }
  }
  double worst = 0.0;
  for (const Vector2d& sample : samples) {
    double nearest = 1.0;
    for (const auto& [a, b] : lips) nearest = std::min(nearest, distance_to_segment_m(sample, a, b));
    worst = std::max(worst, nearest);
  }
  EXPECT_LE(worst, outcome.report.deviation_m);
  EXPECT_LE(outcome.report.deviation_m, tolerance * mesh.base_edge_length() * 1.05);
}

TEST(CutQuality, DeviationReportedBoundsTheTrueDistance) {
  const auto bezier = std::get<CubicBezier>(s_curve());
  std::vector<Vector2d> on_bezier, on_circle;
  for (int i = 0; i <= 500; ++i) {
    const double t = i / 500.0, s = 1.0 - t;
    const auto& p = bezier.points;
    on_bezier.emplace_back(s * s * s * p[0] + 3 * s * s * t * p[1] + 3 * s * t * t * p[2] + t * t * t * p[3]);
    const double angle = 2.0 * std::numbers::pi * t;
    on_circle.emplace_back(0.5 + 0.31 * std::cos(angle), 0.5 + 0.31 * std::sin(angle));
  }
  for (const double tolerance : {0.2, 0.02, 0.003}) {
    for (const double snap : {0.1, 1e-3}) {
      check_deviation(bezier, on_bezier, tolerance, snap);
      check_deviation(Circle{{0.5, 0.5}, 0.31}, on_circle, tolerance, snap);
    }
  }
}

// The design's contract: 20 degrees and l_max / h_min <= 5.5 where no two lips meet below 60 degrees; at most 6 new
// triangles a crossed one, and 90 for a small loop.
TEST(CutQuality, QualityHolds) {
  std::vector<Curve> curves{s_curve(), Polyline{{{-0.1, 0.31}, {0.83, 0.7}}}};
  for (const double radius : {0.24, 0.1, 0.03, 0.012, 0.005}) curves.emplace_back(Circle{{0.513, 0.487}, radius});
  Polyline flower;
  for (int i = 0; i <= 300; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i % 300) / 300.0;
    const double radius = 0.3 + 0.08 * std::sin(8.0 * angle);
    flower.points.emplace_back(0.5 + radius * std::cos(angle), 0.5 + radius * std::sin(angle));
  }
  curves.emplace_back(flower);
  for (const bool relax : {true, false}) {
    for (const Curve& curve : curves) {
      mesh::TriangleMesh mesh = grid(50);
      CutRequest request{curve, {}, {}};
      request.options.relax = relax;
      const CutReport report = cut(mesh, request).report;
      EXPECT_GE(report.min_angle_deg, 20.0);
      EXPECT_LE(report.max_aspect, 5.5);
      EXPECT_EQ(report.triangles_below_angle, 0);
      EXPECT_FALSE(report.refinement_stopped);
      EXPECT_LE(report.new_triangles, (relax ? 4 : 6.5) * report.crossed_triangles + 90);
      if (relax) {
        EXPECT_GE(report.min_height_m, 0.05 * mesh.base_edge_length());
      }
    }
  }
}

TEST(CutQuality, AngleReportedIsThatOfTheMesh) {
  mesh::TriangleMesh mesh = grid(12);
  const CutOutcome outcome = cut(mesh, {Polyline{{{0.2, 0.2}, {0.8, 0.21}, {0.2, 0.28}}}, {}, {}});
  double smallest = 180.0;
  for (const mesh::TriangleId t : outcome.edit.rewritten_triangles) {
    if (!mesh.is_solid(t)) continue;
    for (int k = 0; k < 3; ++k) {
      const Vector2d at = mesh.point_position(mesh.points(t)[k]);
      const Vector2d u = mesh.point_position(mesh.points(t)[mesh::next_corner(k)]) - at;
      const Vector2d v = mesh.point_position(mesh.points(t)[mesh::previous_corner(k)]) - at;
      const double angle = std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v)) * 180.0 / std::numbers::pi;
      smallest = std::min(smallest, angle);
    }
  }
  EXPECT_NEAR(outcome.report.min_angle_deg, smallest, 1e-6);
  EXPECT_LT(smallest, 10.0);  // the corner at (0.8, 0.21) forces it
  EXPECT_GT(outcome.report.triangles_below_angle, 0);
}

}  // namespace
}  // namespace kerf::cut
