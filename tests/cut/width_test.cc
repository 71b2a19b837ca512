// Cuts with a width: a strip is taken away.

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/cut/outline.h"
#include "tests/audit/curve_samples.h"
#include "tests/audit/path_audit.h"
#include "tests/audit/strip_audit.h"
#include "tests/cut/calls.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

CutRequest strip(Curve curve, double width) {
  CutRequest request{std::move(curve), {}, {}};
  request.options.width_m = width;
  return request;
}

struct Taken {
  CutOutcome outcome;
  mesh::TriangleMesh mesh;
};
Taken take(mesh::TriangleMesh mesh, const CutRequest& request, int samples = 400) {
  audit::AuditedCut done = audit::cut_and_audit(mesh, request, {true, true, true, samples});
  EXPECT_EQ(done.reason, "");
  EXPECT_EQ(done.flaw.value_or(""), "");
  return {std::move(done.outcome), std::move(mesh)};
}

TEST(CutWidth, AStraightSlitInsideIsAStadium) {
  const Taken taken = take(grid(21), strip(Polyline{{{0.2, 0.43}, {0.7, 0.61}}}, 0.04));
  const CutReport& report = taken.outcome.report;
  EXPECT_EQ(taken.outcome.status, CutStatus::kApplied);
  EXPECT_EQ(report.pieces, 1);
  EXPECT_EQ(count_boundary_loops(taken.mesh), 2);
  const double length = std::hypot(0.5, 0.18);
  const double exact = 0.04 * length + pi * 0.02 * 0.02;
  const double perimeter = 2.0 * length + pi * 0.04;
  EXPECT_NEAR(report.removed_area_m2, exact, perimeter * report.deviation_m);
  EXPECT_LE(report.deviation_m, 0.02 * 0.05);
  EXPECT_EQ(report.quality.triangles_below_contract, 0);
}

TEST(CutWidth, ACurveFromBorderToBorderTakesAStripAndLeavesTwoPieces) {
  for (const mesh::TriangleMesh& mesh : {grid(21), jittered(21)}) {
    const Taken taken = take(mesh, strip(CubicBezier{{{-0.1, 0.2}, {0.9, 0.1}, {0.1, 0.95}, {1.1, 0.8}}}, 0.03));
    EXPECT_EQ(taken.outcome.report.pieces, 2);
    EXPECT_EQ(count_boundary_loops(taken.mesh), 2);
  }
}

TEST(CutWidth, ManyWidthsFromFarBelowAnEdgeToManyEdges) {
  for (const double width : {1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 0.35}) {
    SCOPED_TRACE(width);
    const Taken taken = take(jittered(21), strip(s_curve(), width));
    EXPECT_EQ(taken.outcome.status, CutStatus::kApplied);
    // Two strips of half the width along the curve and two half discs, as long as it bends less than that.
    if (width > 0.05) continue;
    double length = 0.0;
    const auto line = audit::sample_curve(s_curve(), 10'000).front();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
    const double area = width * length + 0.25 * pi * width * width;
    EXPECT_NEAR(taken.outcome.report.removed_area_m2 / area, 1.0, 0.125);
  }
}

TEST(CutWidth, TheSameStripTwiceIsAMiss) {
  Taken first = take(jittered(21), strip(s_curve(), 0.05));
  const std::uint64_t hash = first.mesh.state_hash();
  const CutOutcome again = cut(first.mesh, strip(s_curve(), 0.05));
  EXPECT_EQ(again.status, CutStatus::kNoIntersection);
  EXPECT_EQ(first.mesh.state_hash(), hash);
}

TEST(CutWidth, AStripAcrossAnOlderStripAndLipsJoinsThem) {
  Taken taken = take(jittered(21), strip(Polyline{{{0.1, 0.5}, {0.9, 0.52}}}, 0.06));
  cut(taken.mesh, {Polyline{{{0.3, 0.1}, {0.31, 0.4}}}, {}, {}});
  cut(taken.mesh, {Circle{{0.62, 0.69}, 0.1}, {}, {}});
  taken = take(taken.mesh, strip(Polyline{{{0.2, 0.2}, {0.8, 0.9}}}, 0.04));
  EXPECT_EQ(taken.outcome.report.pieces, 3) << "two halves of the disc and the rest";
}

TEST(CutWidth, ARingLeavesItsDiscInTheVoid) {
  Taken taken = take(grid(31), strip(Circle{{0.5, 0.5}, 0.2}, 0.1));
  EXPECT_EQ(taken.outcome.report.pieces, 2);
  EXPECT_NEAR(taken.outcome.report.removed_area_m2, 2.0 * pi * 0.2 * 0.1, 2e-3);
  // Nowhere does the outline of this one meet material, and yet the disc lies inside it.
  taken = take(taken.mesh, strip(Polyline{{{0.47, 0.5}, {0.53, 0.5}}}, 0.36));
  EXPECT_EQ(taken.outcome.status, CutStatus::kApplied);
  EXPECT_EQ(taken.outcome.report.removed_pieces, 1);
  EXPECT_EQ(taken.outcome.report.pieces, 1);
}

TEST(CutWidth, PiecesKeepTheirNumbersButForTheHighest) {
  mesh::TriangleMesh mesh = grid(31);
  for (const double x : {0.2, 0.5, 0.8}) cut(mesh, {Circle{{x, 0.5}, 0.05}, {}, {}});
  ASSERT_EQ(mesh.num_pieces(), 4);
  const auto piece_at = [&](double x) { return mesh.piece(mesh.locate(mesh.lattice().nearest({x, 0.501})).triangle); };
  const std::array<std::int32_t, 3> before{piece_at(0.2), piece_at(0.5), piece_at(0.8)};
  const Taken taken = take(mesh, strip(Polyline{{{0.2, 0.5}, {0.5, 0.5}}}, 0.2));
  EXPECT_EQ(taken.outcome.report.removed_pieces, 2);
  EXPECT_EQ(taken.outcome.report.pieces, 2);
  mesh = taken.mesh;
  EXPECT_EQ(taken.outcome.edit.removed_pieces, (std::vector<std::int32_t>{before[1], before[0]}));
  EXPECT_LT(piece_at(0.8), 2);
}

TEST(CutWidth, DashesAreStadiums) {
  CutRequest request = strip(Polyline{{{0.1, 0.5}, {0.9, 0.5}}}, 0.02);
  request.options.dash = {{0.1, 0.1}, 0.0};
  const Taken taken = take(grid(41), request, 0);
  EXPECT_EQ(count_boundary_loops(taken.mesh), 5);
  const double exact = 4.0 * (0.1 * 0.02 + pi * 1e-4);
  EXPECT_NEAR(taken.outcome.report.removed_area_m2, exact, 0.05 * exact);
}

TEST(CutWidth, FineQualityHoldsBesideTheStrip) {
  CutRequest request = strip(s_curve(), 0.03);
  request.options.min_angle_deg = kFineMinAngle;
  const Taken taken = take(jittered(31), request);
  EXPECT_FALSE(taken.outcome.report.refinement_stopped);
  EXPECT_EQ(taken.outcome.report.quality.triangles_below_contract, 0);
}

TEST(CutWidth, RefusalsLeaveTheSheetAlone) {
  mesh::TriangleMesh mesh = grid(11);
  const std::uint64_t hash = mesh.state_hash();
  const auto reason = [&](const CutRequest& request) {
    const Result<CutPlan> planned = plan(mesh, request);
    if (!planned.ok()) return planned.error().reason;
    const Result<CutOutcome> applied = apply(mesh, *planned);
    return applied.ok() ? std::string("applied") : applied.error().reason;
  };
  const Curve line = Polyline{{{0.2, 0.5}, {0.8, 0.5}}};
  for (const double width : {0.0, -0.1, kMinWidth / 2.0, kMaxWidth * 1.01, std::nan("")}) {
    EXPECT_EQ(reason(strip(line, width)), "OPTION_OUT_OF_RANGE") << width;
  }
  CutRequest by_element = strip(line, 0.1);
  by_element.options.method = Method::kElement;
  EXPECT_EQ(reason(by_element), "OPTIONS_CONFLICT");
  EXPECT_EQ(reason(strip(line, kMaxWidth)), "STRIP_COVERS_SHEET");
  // Chords that are all within the width of each other: 800 along a bow, and 520 with an arc of 19 points between each
  // two.
  Polyline row, zigzag;
  for (int i = 0; i <= 800; ++i) row.points.emplace_back(0.4 + 1e-4 * i, 0.5 + 1e-7 * i * i);
  for (int i = 0; i <= 520; ++i) zigzag.points.emplace_back(0.4 + 0.2 * (i % 2), 0.5 + 1e-5 * i);
  EXPECT_EQ(reason(strip(row, 0.1)), "WIDTH_WORK_BUDGET");
  EXPECT_EQ(reason(strip(zigzag, 0.1)), "WIDTH_WORK_BUDGET");
  EXPECT_EQ(mesh.state_hash(), hash);
  row.points.resize(700);
  EXPECT_EQ(reason(strip(row, 0.1)), "applied");
  mesh = grid(11);
  zigzag.points.resize(450);
  CutRequest finer = strip(zigzag, 0.1);
  finer.options.tolerance = 0.002;
  EXPECT_EQ(reason(finer), "WIDTH_WORK_BUDGET");
  EXPECT_EQ(reason(strip(zigzag, 0.1)), "applied");
  // 3,072 units of the lattice of a sheet of a million metres.
  mesh = *mesh::make_grid({11, 11, 9.0e3, 9.0e3});
  const double least = 3072.0 * mesh.lattice().spacing;
  EXPECT_EQ(reason(strip(line, 0.99 * least)), "WIDTH_TOO_SMALL");
  EXPECT_NE(reason(strip(line, 1.01 * least)), "WIDTH_TOO_SMALL");
}

TEST(CutWidth, OutlinesOfRandomCurvesSweepADisc) {
  SeededRandom random(7);
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(trial);
    CubicBezier curve;
    for (int i = 0; i < 4; ++i) curve.points.emplace_back(random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2));
    take(jittered(15), strip(curve, std::pow(10.0, random.uniform(-4.0, -0.7))), 200);
  }
}

}  // namespace
}  // namespace kerf::cut
