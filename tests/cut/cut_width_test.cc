// Cuts with a width: a strip is taken away.

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/cut/cut.h"
#include "server/cut/outline.h"
#include "tests/audit/path_audit.h"
#include "tests/audit/strip_audit.h"
#include "tests/cut/cut_calls.h"

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
  for (const double width : {1e-4, 1e-3, 0.01, 0.1, 0.35}) {
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

}  // namespace
}  // namespace kerf::cut
