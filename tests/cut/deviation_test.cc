// Measures the distance between a cut and its curve by dense samples, apart from the code that bounds it.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "server/base/random.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/cut/calls.h"
#include "tests/support/cut_patterns.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr int kSamples = 4000;  // of a curve
constexpr int kSamplesOfALip = 8;

// A curve and points of it, computed here from its definition.
struct Sampled {
  std::string name;
  Curve curve;
  std::vector<Vector2d> points;
};

Sampled sampled(std::string name, const Curve& curve, const std::function<Vector2d(double)>& at) {
  Sampled result{std::move(name), curve, {}};
  for (int i = 0; i <= kSamples; ++i) result.points.push_back(at(static_cast<double>(i) / kSamples));
  return result;
}

Sampled bezier(std::string name, const CubicBezier& curve) {
  return sampled(std::move(name), curve, [&curve](double s) {
    const double pieces = static_cast<double>((curve.points.size() - 1) / 3);
    const double piece = std::min(std::floor(s * pieces), pieces - 1.0);
    const double t = s * pieces - piece, r = 1.0 - t;
    const Vector2d* p = &curve.points[3 * static_cast<std::size_t>(piece)];
    return Vector2d(r * r * r * p[0] + 3 * r * r * t * p[1] + 3 * r * t * t * p[2] + t * t * t * p[3]);
  });
}

Sampled circle(std::string name, const Circle& curve) {
  return sampled(std::move(name), curve,
                 [&curve](double s) { return test::polar(curve.centre, curve.radius, 2.0 * std::numbers::pi * s); });
}

Sampled polyline(std::string name, const Polyline& line) {
  return sampled(std::move(name), line, [&line](double s) {
    const double place = s * static_cast<double>(line.points.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(place), line.points.size() - 2);
    return Vector2d(line.points[i] + (place - static_cast<double>(i)) * (line.points[i + 1] - line.points[i]));
  });
}

std::vector<Sampled> curves() {
  return {bezier("S", std::get<CubicBezier>(s_curve())),
          bezier("chain", {{{0.1, 0.5}, {0.2, 0.9}, {0.4, 0.9}, {0.5, 0.5}, {0.6, 0.1}, {0.7, 0.3}, {0.9, 0.4}}}),
          bezier("loop", {{{0.2, 0.2}, {1.3, 0.9}, {-0.3, 0.9}, {0.8, 0.2}}}),
          bezier("cusp", {{{0.2, 0.2}, {0.8, 0.8}, {0.2, 0.8}, {0.8, 0.2}}}),
          bezier("over the border", {{{-0.2, 0.4}, {0.5, 1.6}, {0.6, -0.7}, {1.2, 0.6}}}),
          circle("large", {{0.5, 0.5}, 0.31}),
          circle("small", {{0.52, 0.47}, 0.011}),
          circle("over a corner", {{0.05, 0.04}, 0.3}),
          polyline("zigzag", test::zigzag(9, 40.0)),
          polyline("dense", test::sampled(300, false, [](double s) {
                     return Vector2d(0.1 + 0.8 * s, 0.5 + 0.2 * std::sin(9.0 * s));
                   }))};
}

// Edges that grow from 1 to about 20 from a corner of the unit square to the opposite one.
mesh::TriangleMesh graded(int cells) {
  mesh::IndexedMesh input;
  const auto place = [cells](int i) { return std::pow(static_cast<double>(i) / cells, 2.2); };
  input.rest.resize(2, static_cast<Eigen::Index>((cells + 1) * (cells + 1)));
  input.triangles.resize(3, static_cast<Eigen::Index>(2 * cells * cells));
  Eigen::Index count = 0;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) {
      const int at = j * (cells + 1) + i;
      input.rest.col(at) = Vector2d(place(i), place(j));
      if (i == cells || j == cells) continue;
      input.triangles.col(count++) = Eigen::Vector3i(at, at + 1, at + cells + 2);
      input.triangles.col(count++) = Eigen::Vector3i(at, at + cells + 2, at + cells + 1);
    }
  }
  return mesh::import_mesh(input).value();
}

using Chord = std::pair<Vector2d, Vector2d>;

std::vector<Chord> edges_with(const mesh::TriangleMesh& mesh, mesh::LockBits locks) {
  std::vector<Chord> edges;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.is_solid(t) || (mesh.locks(t, k) & locks) == 0) continue;
      edges.emplace_back(mesh.point_position(mesh.points(t)[mesh::next_corner(k)]),
                         mesh.point_position(mesh.points(t)[mesh::previous_corner(k)]));
    }
  }
  return edges;
}

// Uses numbers, not vectors: without optimisation each operation on a vector is a call, and there are a billion of
// them.
double distance_to(const Vector2d& point, const std::vector<Chord>& segments) {
  const double x = point.x(), y = point.y();
  double nearest = std::numeric_limits<double>::infinity();  // squared
  const Chord* const end = segments.data() + segments.size();
  for (const Chord* chord = segments.data(); chord != end; ++chord) {
    const double *a = chord->first.data(), *b = chord->second.data();
    const double along_x = b[0] - a[0], along_y = b[1] - a[1];
    const double from_x = x - a[0], from_y = y - a[1];
    const double t = (from_x * along_x + from_y * along_y) / (along_x * along_x + along_y * along_y);
    const double part = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    const double off_x = from_x - part * along_x, off_y = from_y - part * along_y;
    const double squared = off_x * off_x + off_y * off_y;
    if (squared < nearest) nearest = squared;
  }
  return std::sqrt(nearest);
}

double tolerance_at(const mesh::TriangleMesh& mesh, const CutOptions& options, const Vector2d& at) {
  return options.tolerance_m.value_or(options.tolerance * mesh.edge_lengths().at(at));
}

// Cuts a copy of the sheet and compares curve with lips both ways: in metres with the bound reported, and place by
// place with the tolerance asked for there.
void check_both_ways(const mesh::TriangleMesh& sheet, const Sampled& sampled, const CutOptions& options,
                     double snap = CutRequest{}.snap) {
  SCOPED_TRACE(sampled.name);
  mesh::TriangleMesh mesh = sheet;
  CutRequest request{sampled.curve, options, {}};
  request.snap = snap;
  const CutReport report = cut(mesh, request).report;
  EXPECT_LE(report.deviation_of_tolerance, 1.0);
  EXPECT_GT(report.deviation_m, 0.0);
  const std::vector<Chord> lips = edges_with(mesh, mesh::kLockCut);
  const std::vector<Chord> open = edges_with(mesh, mesh::kLocksThatOpen);
  ASSERT_FALSE(lips.empty());
  const auto expect_near = [&](const Vector2d& at, double distance, double slack) {
    EXPECT_LE(distance, report.deviation_m + slack);
    // A place next to a cell of smaller edges may be in one of larger ones.
    EXPECT_LE(distance, 2.0 * report.deviation_of_tolerance * tolerance_at(sheet, options, at) + slack);
    if (sheet.edge_lengths().is_uniform()) {
      EXPECT_LE(distance, tolerance_at(sheet, options, at) + slack);
    }
  };
  for (const Vector2d& point : sampled.points) {
    if (!sheet.bounding_box().contains(point)) continue;
    expect_near(point, distance_to(point, open), 0.0);
  }
  // The samples' chords are off a curve by no more than an eighth of their length squared times its curvature. That is
  // at most 1 / 0.011 except near the cusp, where chords are short.
  const auto* line = std::get_if<Polyline>(&sampled.curve);
  const std::vector<Vector2d>& ends = line != nullptr ? line->points : sampled.points;
  std::vector<Chord> exact;
  double longest = 0.0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    exact.emplace_back(ends[i], ends[i + 1]);
    longest = std::max(longest, (ends[i + 1] - ends[i]).norm());
  }
  const double slack = line != nullptr ? 0.0 : 12.0 * longest * longest;
  for (const auto& [a, b] : lips) {
    for (int i = 0; i <= kSamplesOfALip; ++i) {
      const Vector2d at = a + (static_cast<double>(i) / kSamplesOfALip) * (b - a);
      expect_near(at, distance_to(at, exact), slack);
    }
  }
}

TEST(CutDeviation, BoundHoldsBothWaysForEveryKindOfCurve) {
  for (const double tolerance : {0.2, 0.02, 0.002}) {
    CutOptions options;
    options.tolerance = tolerance;
    for (const mesh::TriangleMesh& sheet : {grid(20), jittered(20)}) {
      for (const Sampled& sampled : curves()) check_both_ways(sheet, sampled, options);
    }
  }
}

TEST(CutDeviation, BoundHoldsWithASnapOfTheWholeTenthAllowed) {
  for (const Sampled& sampled : curves()) check_both_ways(jittered(20), sampled, {}, 0.1);
}

TEST(CutDeviation, BoundHoldsElementByElement) {
  for (const double tolerance : {0.2, 0.02, 0.002}) {
    CutOptions options;
    options.method = Method::kElement;
    options.tolerance = tolerance;
    for (const mesh::TriangleMesh& sheet : {grid(20), jittered(20), graded(24)}) {
      for (const Sampled& sampled : curves()) check_both_ways(sheet, sampled, options);
    }
  }
}

TEST(CutDeviation, ToleranceIsThatOfTheEdgesThere) {
  const mesh::TriangleMesh sheet = graded(24);
  ASSERT_FALSE(sheet.edge_lengths().is_uniform());
  EXPECT_LT(sheet.edge_lengths().at({0.01, 0.01}), 0.2 * sheet.edge_lengths().at({0.95, 0.95}));
  for (const Sampled& sampled : curves()) check_both_ways(sheet, sampled, {});
  // As many points as the edges there ask for, not as the smallest ones do: a circle among large edges becomes few
  // lips.
  mesh::TriangleMesh mesh = sheet;
  const CutOutcome outcome = cut(mesh, {Circle{{0.75, 0.75}, 0.2}, {}, {}});
  mesh::TriangleMesh again = sheet;
  CutOptions tight;
  tight.tolerance_m = 0.02 * sheet.edge_lengths().least();
  const CutOutcome tightly = cut(again, {Circle{{0.75, 0.75}, 0.2}, tight, {}});
  EXPECT_GT(tightly.report.new_lip_edges, 2 * outcome.report.new_lip_edges);
}

TEST(CutDeviation, SameCutTwiceOnAGradedSheetMeetsItsLips) {
  for (const Sampled& sampled : curves()) {
    SCOPED_TRACE(sampled.name);
    mesh::TriangleMesh mesh = graded(24);
    EXPECT_EQ(cut(mesh, {sampled.curve, {}, {}}).status, CutStatus::kApplied);
    EXPECT_EQ(cut(mesh, {sampled.curve, {}, {}}).status, CutStatus::kNoIntersection);
  }
}

TEST(CutDeviation, AnyToleranceInMetres) {
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-7}) {
    CutOptions options;
    options.tolerance_m = tolerance;
    options.min_angle_deg = 0.0;
    mesh::TriangleMesh mesh = grid(10);
    const CutReport report = cut(mesh, {s_curve(), options, {}}).report;
    EXPECT_LE(report.deviation_m, tolerance);
    EXPECT_GT(report.deviation_m, 0.2 * tolerance);
    EXPECT_LE(report.deviation_of_tolerance, 1.0);
  }
}

// Refuses a tolerance that cannot be kept: by the number of chords, and by the lattice.
TEST(CutDeviation, RefusesATolerancePastTheLimits) {
  const auto planned = [](const mesh::TriangleMesh& mesh, const Curve& curve, double tolerance_m) {
    CutRequest request{curve, {}, {}};
    request.options.tolerance_m = tolerance_m;
    return plan(mesh, request);
  };
  const mesh::TriangleMesh sheet = grid(10);
  const Result<CutPlan> too_many = planned(sheet, s_curve(), 1e-9);
  ASSERT_FALSE(too_many.ok());
  EXPECT_EQ(too_many.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(too_many.error().reason, "TOLERANCE_TOO_SMALL");
  EXPECT_EQ(too_many.error().field, "cut.curve");
  EXPECT_TRUE(planned(sheet, Polyline{{{0.2, 0.3}, {0.8, 0.7}}}, 1e-9).ok());
  // Lattice units of a sheet of 10 km are 7.3e-12 m: 384 of them are the limit.
  const mesh::TriangleMesh large = *mesh::make_grid({10, 10, 9000.0, 9000.0});
  const double least = 384.0 * large.lattice().spacing;
  EXPECT_GT(least, kMinLength);
  const Polyline line{{{1000.0, 1200.0}, {7000.0, 3000.0}}};
  const Result<CutPlan> too_fine = planned(large, line, 0.99 * least);
  ASSERT_FALSE(too_fine.ok());
  EXPECT_EQ(too_fine.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(too_fine.error().reason, "TOLERANCE_TOO_SMALL");
  EXPECT_EQ(too_fine.error().field, "cut.tolerance_m");
  const Result<CutPlan> kept = planned(large, line, 1.01 * least);
  ASSERT_TRUE(kept.ok());
  mesh::TriangleMesh mesh = large;
  const Result<CutOutcome> outcome = apply(mesh, *kept);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_LE(outcome->report.deviation_of_tolerance, 1.0);
}

}  // namespace
}  // namespace kerf::cut
