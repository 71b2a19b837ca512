// Strands: stretches between cuts that lie much closer than an edge length. They are refined less than the rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/core/mesh/triangle_shape.h"
#include "tests/cut/calls.h"
#include "tests/support/random_cuts.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr std::int32_t kSide = 50;

double smallest_angle_deg(const mesh::TriangleMesh& mesh, mesh::TriangleId t) {
  return std::acos(rest_shape_of(mesh, t).cos_smallest) * 180.0 / std::numbers::pi;
}

struct Line {
  Vector2d start, end;
};

double distance(const Line& line, const Vector2d& at) {
  const Vector2d along = line.end - line.start;
  const double share = std::clamp((at - line.start).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (at - line.start - share * along).norm();
}

// Distance to the second nearest of the lines.
double second_distance(const std::vector<Line>& lines, const Vector2d& at) {
  double nearest = std::numeric_limits<double>::infinity();
  double second = nearest;
  for (const Line& line : lines) {
    second = std::min(second, std::max(nearest, distance(line, at)));
    nearest = std::min(nearest, distance(line, at));
  }
  return second;
}

// Bundles of slits, at several distances in edge lengths, and slits that cross them: no corner is below 60 degrees.
std::vector<Line> bundles(double h) {
  std::vector<Line> lines;
  for (const double gap : {0.011, 0.02, 0.05, 0.11, 0.2, 0.3, 0.45}) {
    const double y = 0.1 + 1.7 * gap;
    for (int i = 0; i < 3; ++i) lines.push_back({{0.113, y + i * gap * h}, {0.887, y + 0.0131 + i * gap * h}});
  }
  for (int i = 0; i < 6; ++i) lines.push_back({{0.171 + 0.1127 * i, 0.071}, {0.203 + 0.1127 * i, 0.931}});
  return lines;
}

// The geometry of the lines decides by itself what is near a strand, without the mesh.
TEST(CutStrands, AnglesAreAsAskedForNearStrandsAndElsewhere) {
  for (const double angle : {20.0, kFineMinAngle}) {
    mesh::TriangleMesh mesh = grid(kSide);
    const double h = mesh.base_edge_length();
    const std::vector<Line> lines = bundles(h);
    CutOptions options;
    options.min_angle_deg = angle;
    StrandQuality sum;
    for (const Line& line : lines) {
      const CutReport report = cut(mesh, {Polyline{{line.start, line.end}}, options, {}}).report;
      const CutQuality& quality = report.quality;
      EXPECT_FALSE(report.refinement_stopped);
      EXPECT_EQ(quality.triangles_below_contract, 0);
      EXPECT_EQ(quality.strands.asked_angle_deg, kStrandAngle * angle);
      EXPECT_GE(quality.strands.min_angle_deg, kStrandAngle * angle - 1e-6);
      EXPECT_GE(quality.elsewhere_min_angle_deg, angle - 1e-6);
      EXPECT_EQ(quality.min_angle_deg, std::min({quality.elsewhere_min_angle_deg, quality.strands.min_angle_deg,
                                                 quality.strands.narrow_min_angle_deg}));
      sum.triangles_below += quality.strands.triangles_below;
      sum.narrow_below += quality.strands.narrow_below;
    }
    EXPECT_GT(sum.narrow_below, 20);
    EXPECT_GT(sum.triangles_below - sum.narrow_below, 1000);
    for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
      if (!mesh.is_solid(t) || smallest_angle_deg(mesh, t) >= angle - 1e-6) continue;
      const mesh::TriangleShape shape = rest_shape_of(mesh, t);
      const auto& p = mesh.points(t);
      const Vector2d a = mesh.point_position(p[mesh::next_corner(shape.sharpest_corner)]);
      const Vector2d b = mesh.point_position(p[mesh::previous_corner(shape.sharpest_corner)]);
      EXPECT_LT(second_distance(lines, 0.5 * (a + b)), 1.001 * kNearStrands * h);
      if ((a - b).norm() >= kNarrowGap * h) {
        EXPECT_GE(smallest_angle_deg(mesh, t), kStrandAngle * angle - 1e-6);
      }
    }
  }
}

TEST(CutStrands, OrdinaryCutsHaveNone) {
  const std::vector<Curve> curves{s_curve(), Polyline{{{-0.1, 0.313}, {1.1, 0.687}}}, Circle{{0.5037, 0.4971}, 0.3},
                                  Polyline{{{0.31, 0.42}, {0.66, 0.47}}}};
  for (const Curve& curve : curves) {
    mesh::TriangleMesh mesh = grid(kSide);
    const CutQuality quality = cut(mesh, {curve, {}, {}}).report.quality;
    EXPECT_EQ(quality.strands.triangles_below, 0);
    EXPECT_EQ(quality.strands.min_angle_deg, 180.0);
    EXPECT_EQ(quality.elsewhere_min_angle_deg, quality.min_angle_deg);
    EXPECT_GE(quality.min_angle_deg, 20.0 - 1e-6);
  }
}

// A cut that ends at the border at a right angle has no strand there; one that runs beside it has.
TEST(CutStrands, TheBorderIsAStrandOfACutBesideIt) {
  mesh::TriangleMesh mesh = grid(kSide);
  const double h = mesh.base_edge_length();
  EXPECT_EQ(cut(mesh, {Polyline{{{0.513, -0.1}, {0.517, 0.3}}}, {}, {}}).report.quality.strands.triangles_below, 0);
  EXPECT_EQ(cut(mesh, {Polyline{{{0.05, 0.4}, {0.053, 0.6}}}, {}, {}}).report.quality.strands.triangles_below, 0);
  EXPECT_GT(cut(mesh, {Polyline{{{0.1 * h, 0.4}, {0.1 * h, 0.6}}}, {}, {}}).report.quality.strands.triangles_below, 0);
}

TEST(CutStrands, ElementsByThemselvesHaveNone) {
  mesh::TriangleMesh mesh = grid(kSide);
  CutOptions options;
  options.method = Method::kElement;
  cut(mesh, {Polyline{{{0.2, 0.5}, {0.8, 0.51}}}, options, {}});
  const CutQuality quality = cut(mesh, {Polyline{{{0.2, 0.501}, {0.8, 0.511}}}, options, {}}).report.quality;
  EXPECT_EQ(quality.strands.triangles_below, 0);
  EXPECT_EQ(quality.elsewhere_min_angle_deg, quality.min_angle_deg);
}

struct RandomlyCut {
  mesh::TriangleMesh mesh = grid(kSide);
  std::vector<CutOutcome> cuts;

  RandomlyCut(std::uint64_t seed, std::size_t count) {
    SeededRandom random(seed);
    while (cuts.size() < count) {
      const Result<CutPlan> planned = plan(mesh, {test::random_cubic(random), {}, {}});
      if (!planned.ok()) continue;
      Result<CutOutcome> done = apply(mesh, *planned);
      if (done.ok() && done->status == CutStatus::kApplied) cuts.push_back(std::move(*done));
    }
  }
};

// Sheets refined to 20 degrees everywhere had 7,700, 7,466 and 7,470 vertices after 50 cuts, and 16,637, 16,278 and
// 16,357 after 100.
TEST(CutStrands, RandomCutsTakeFewVerticesAndKeepTheTolerance) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const auto& [count, most] : {std::pair{50, 6300}, std::pair{100, 11'600}}) {
      const RandomlyCut sheet(seed, static_cast<std::size_t>(count));
      EXPECT_LE(sheet.mesh.num_vertices(), most) << seed << ", " << count << " cuts";
      EXPECT_EQ(sheet.mesh.find_violation().value_or(""), "");
      for (const CutOutcome& done : sheet.cuts) {
        const CutReport& report = done.report;
        EXPECT_LE(report.deviation_of_tolerance, 1.0);
        EXPECT_FALSE(report.refinement_stopped);
        EXPECT_EQ(report.quality.triangles_below_contract, 0);
        if (report.quality.num_corners == 0) {
          EXPECT_GE(report.quality.elsewhere_min_angle_deg, 20.0 - 1e-6);
          EXPECT_GE(report.quality.strands.min_angle_deg, 10.0 - 1e-6);
        }
      }
    }
  }
}

TEST(CutStrands, UndoAndRepetitionGiveTheSameMesh) {
  RandomlyCut sheet(1, 60);
  EXPECT_TRUE(sheet.mesh == RandomlyCut(1, 60).mesh);
  while (sheet.cuts.size() > 40) {
    sheet.cuts.back().undo.undo(sheet.mesh);
    sheet.cuts.pop_back();
  }
  const RandomlyCut shorter(1, 40);
  EXPECT_TRUE(sheet.mesh == shorter.mesh);
  EXPECT_EQ(sheet.mesh.state_hash(), shorter.mesh.state_hash());
}

// Points that only space the path are left out beside older lips, whose crossings space it.
TEST(CutStrands, CrossingsSpaceThePath) {
  const Polyline across{{{0.213, 0.507}, {0.787, 0.493}}};
  mesh::TriangleMesh alone = grid(kSide);
  const std::int32_t edges = cut(alone, {across, plain(), {}}).report.new_lip_edges;
  mesh::TriangleMesh crossed = grid(kSide);
  for (int i = 0; i < 8; ++i) {
    const double x = 0.25 + 0.067 * i;
    cut(crossed, {Polyline{{{x, 0.4}, {x + 0.01, 0.6}}}, plain(), {}});
  }
  // Each of the eight lips adds an edge where it is crossed.
  EXPECT_LT(cut(crossed, {across, plain(), {}}).report.new_lip_edges, edges + 8 - 3);
}

// A second cut along the lips of a first finds all of them, with the crossings that were made since.
TEST(CutStrands, ACutMadeTwiceMissesTheSecondTime) {
  RandomlyCut sheet(2, 40);
  SeededRandom random(2);
  for (int i = 0; i < 40; ++i) {
    const mesh::TriangleMesh before = sheet.mesh;
    const Result<CutPlan> planned = plan(sheet.mesh, {test::random_cubic(random), {}, {}});
    ASSERT_TRUE(planned.ok());
    const Result<CutOutcome> again = apply(sheet.mesh, *planned);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->status, CutStatus::kNoIntersection) << i;
    EXPECT_TRUE(sheet.mesh == before);
  }
}

}  // namespace
}  // namespace kerf::cut
