// Tests the quality of the triangles of a cut.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/cut/calls.h"
#include "tests/support/cut_patterns.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

struct Sum {
  double crossed = 0.0, added = 0.0;
  std::vector<double> heights;  // smallest / edge length, of each pattern
};

// Cuts a 50 x 50 sheet along the pattern and checks that every cut keeps the contract.
void cut_pattern(mesh::TriangleMesh mesh, const test::CutPattern& pattern, const CutOptions& options, Sum& sum) {
  SCOPED_TRACE(pattern.name);
  double height = std::numeric_limits<double>::infinity();
  for (const Curve& curve : pattern.curves) {
    const CutReport report = cut(mesh, {curve, options, {}}).report;
    EXPECT_EQ(report.quality.triangles_below_contract, 0);
    EXPECT_FALSE(report.refinement_stopped);
    const CutQuality& quality = report.quality;
    if (quality.triangles_below_angle == 0) {
      EXPECT_GE(quality.min_angle_deg, options.min_angle_deg - 1e-6);
      EXPECT_LE(quality.max_aspect, 2.0 / std::tan(options.min_angle_deg * std::numbers::pi / 180.0));
    } else if (quality.num_corners == 0) {
      EXPECT_GE(quality.elsewhere_min_angle_deg, options.min_angle_deg - 1e-6);
      EXPECT_GE(quality.strands.min_angle_deg, kStrandAngle * options.min_angle_deg - 1e-6);
    }
    height = std::min(height, report.quality.min_height_m / mesh.base_edge_length());
    sum.crossed += report.crossed_triangles;
    sum.added += std::max(0, report.new_triangles - (report.crossed_triangles < 10 ? 90 : 0));
  }
  sum.heights.push_back(height);
}

// The design's contract: outside the corners named 20 degrees, or 25, hence l_max / h_min <= 2 cot 20 = 5.5 or 4.3, and
// near strands half of it; on average at most 6 new triangles a crossed one (90 more for a tiny loop); smallest height
// at least 0.05 edge lengths in the median cut.
TEST(CutQuality, ContractHoldsOverThePatterns) {
  const mesh::TriangleMesh sheets[] = {grid(50), jittered(50)};
  for (const double angle : {20.0, kFineMinAngle}) {
    Sum sum;
    for (const mesh::TriangleMesh& sheet : sheets) {
      CutOptions options;
      options.min_angle_deg = angle;
      for (const test::CutPattern& pattern : test::cut_patterns(1.0 / 49.0)) cut_pattern(sheet, pattern, options, sum);
    }
    EXPECT_LE(sum.added, (angle == 20.0 ? 4.0 : 5.0) * sum.crossed);
    std::sort(sum.heights.begin(), sum.heights.end());
    EXPECT_GE(sum.heights[sum.heights.size() / 2], 0.05);
  }
}

TEST(CutQuality, ContractHoldsWithoutRelaxing) {
  CutOptions options;
  options.relax = false;
  Sum sum;
  for (const test::CutPattern& pattern : test::cut_patterns(1.0 / 49.0)) cut_pattern(grid(50), pattern, options, sum);
  EXPECT_LE(sum.added, 6.5 * sum.crossed);
}

TEST(CutQuality, NamesTheCornersThatForceSmallAngles) {
  mesh::TriangleMesh mesh = grid(30);
  const Vector2d tip(0.7031, 0.5017);
  const Polyline wedge{{{0.2, 0.45}, tip, {0.2, 0.55}}};
  const CutQuality quality = cut(mesh, {wedge, {}, {}}).report.quality;
  ASSERT_EQ(quality.num_corners, 1);
  ASSERT_EQ(quality.corners.size(), 1U);
  EXPECT_LT((quality.corners[0].position - tip).norm(), 1e-4);
  const double expected = (std::atan2(0.0483, 0.5031) + std::atan2(0.0517, 0.5031)) * 180.0 / std::numbers::pi;
  EXPECT_NEAR(quality.corners[0].angle_deg, expected, 0.1);
  EXPECT_EQ(quality.corners[0].triangles_below, quality.triangles_below_angle);
  EXPECT_GT(quality.triangles_below_angle, 0);
  EXPECT_EQ(quality.triangles_below_contract, 0);
  // 90 corners of 10 degrees: all are counted, the sharpest are listed.
  mesh::TriangleMesh comb = grid(60);
  const CutQuality many = cut(comb, {test::zigzag(90, 10.0), {}, {}}).report.quality;
  EXPECT_EQ(many.num_corners, 90);
  ASSERT_EQ(many.corners.size(), kMaxListedCorners);
  EXPECT_TRUE(std::is_sorted(many.corners.begin(), many.corners.end(),
                             [](const SharpCorner& a, const SharpCorner& b) { return a.angle_deg < b.angle_deg; }));
  EXPECT_EQ(many.triangles_below_contract, 0);
}

// Along edges, lips come from old triangles only: they stay what they were, and nothing is new.
TEST(CutQuality, OldTrianglesAreNotMeasured) {
  mesh::TriangleMesh mesh = grid(9);
  const CutOutcome outcome = cut(mesh, {Polyline{{{0.25, 0.5}, {0.75, 0.5}}}, {}, {}});
  EXPECT_FALSE(outcome.edit.rewritten_triangles.empty());
  EXPECT_EQ(outcome.report.quality.triangles, 0);
  EXPECT_EQ(outcome.report.quality.min_angle_deg, 180.0);
}

// Longest edge of the solid triangles within `reach` of `at`, in their middles; 0 if there are none.
double longest_edge_near(const mesh::TriangleMesh& mesh, const Vector2d& at, double reach, double least = 0.0) {
  double longest = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    std::array<Vector2d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.point_position(mesh.points(t)[k]);
    const double distance = ((p[0] + p[1] + p[2]) / 3.0 - at).norm();
    if (distance > reach || distance < least) continue;
    longest = std::max({longest, (p[0] - p[1]).norm(), (p[1] - p[2]).norm(), (p[2] - p[0]).norm()});
  }
  return longest;
}

TEST(CutQuality, EdgesGrowFromTheTipsAsAskedFor) {
  const Vector2d tip(0.63, 0.52);
  const Polyline line{{{-0.1, 0.47}, tip}};
  const mesh::TriangleMesh sheet = grid(30);
  mesh::TriangleMesh plain = sheet;
  const CutReport without = cut(plain, {line, {}, {}}).report;
  for (const double grading : {1.2, 1.5, 2.5}) {
    CutOptions options;
    options.tip_edge_length_m = 0.05 * sheet.base_edge_length();
    options.tip_grading = grading;
    mesh::TriangleMesh mesh = sheet;
    const CutReport report = cut(mesh, {line, options, {}}).report;
    EXPECT_FALSE(report.refinement_stopped);
    EXPECT_EQ(report.quality.triangles_below_contract, 0);
    EXPECT_GE(report.quality.min_angle_deg, 20.0 - 1e-6);
    EXPECT_GT(report.new_triangles, without.new_triangles + 20);
    EXPECT_LT(report.new_triangles, without.new_triangles + 100.0 * std::log(20.0) / ((grading - 1) * (grading - 1)));
    for (const double distance : {0.0, 0.002, 0.005, 0.01, 0.02, 0.05}) {
      const double wanted = *options.tip_edge_length_m + (grading - 1.0) * distance;
      EXPECT_LE(longest_edge_near(mesh, tip, distance, 0.5 * distance), wanted) << grading << " at " << distance;
    }
    // The end at the border is no tip.
    EXPECT_GT(longest_edge_near(mesh, {0.0, 0.475}, 0.05), 0.5 * sheet.base_edge_length());
  }
}

TEST(CutQuality, BothTipsOfASlitAreGradedAndOnlyThoseLeft) {
  const mesh::TriangleMesh sheet = grid(30);
  CutOptions options;
  options.tip_edge_length_m = 0.1 * sheet.base_edge_length();
  mesh::TriangleMesh mesh = sheet;
  const Vector2d a(0.31, 0.42), b(0.66, 0.47), c(0.64, 0.81);
  cut(mesh, {Polyline{{a, b}}, options, {}});
  for (const Vector2d& tip : {a, b}) EXPECT_LE(longest_edge_near(mesh, tip, 0.002), 1.5 * *options.tip_edge_length_m);
  // Going on from one tip moves it; edges longer than those of the sheet change nothing.
  mesh::TriangleMesh longer = mesh;
  cut(longer, {Polyline{{b, c}}, options, {}});
  EXPECT_LE(longest_edge_near(longer, c, 0.002), 1.5 * *options.tip_edge_length_m);
  CutOptions coarse;
  coarse.tip_edge_length_m = 10.0;
  mesh::TriangleMesh one = sheet, other = sheet;
  cut(one, {Polyline{{a, b}}, coarse, {}});
  cut(other, {Polyline{{a, b}}, {}, {}});
  EXPECT_TRUE(one == other);
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
  EXPECT_NEAR(outcome.report.quality.min_angle_deg, smallest, 1e-6);
  EXPECT_LT(smallest, 10.0);  // the corner at (0.8, 0.21) forces it
  EXPECT_GT(outcome.report.quality.triangles_below_angle, 0);
}

}  // namespace
}  // namespace kerf::cut
