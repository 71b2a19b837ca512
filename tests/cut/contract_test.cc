// Tests the promises of cut.h besides topology: exact counts, refusals, transactions, determinism.
#include <cmath>
#include <limits>
#include <numbers>

#include "server/base/random.h"
#include "tests/cut/calls.h"
#include "tests/support/meshes.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

// Along edges nothing but vertices is added, one edge by itself excepted, so every number is known.
TEST(CutContract, CountsVerticesExactlyAlongEdges) {
  struct Case {
    std::vector<Vector2d> points;  // in cells of an 8 x 8 sheet
    int new_vertices;
    int pieces;
    int lip_edges;
    int new_triangles = 0;
  };
  const std::vector<Case> cases{
      {{{2, 3}, {6, 3}}, 3, 1, 4},                            // tips stay single
      {{{2, 3}, {3, 3}}, 2, 1, 2, 2},                         // one edge inside: opens at its middle
      {{{0, 3}, {4, 3}}, 4, 1, 4},                            // from the border
      {{{0, 3}, {8, 3}}, 9, 2, 8},                            // from border to border
      {{{1, 1}, {6, 6}}, 4, 1, 5},                            // along diagonals
      {{{3, 3}, {4, 3}, {4, 4}, {3, 3}}, 3, 2, 3},            // one triangle
      {{{2, 2}, {5, 2}, {5, 5}, {2, 5}, {2, 2}}, 12, 2, 12},  // a square
      {{{2, 2}, {5, 2}, {5, 5}}, 5, 1, 6},                    // a corner
  };
  for (const Case& item : cases) {
    Polyline line;
    for (const Vector2d& p : item.points) line.points.push_back(p / 8.0);
    mesh::TriangleMesh mesh = grid(9);
    const CutOutcome outcome = cut(mesh, {line, plain(), {}});
    EXPECT_EQ(outcome.status, CutStatus::kApplied);
    EXPECT_EQ(outcome.report.new_vertices, item.new_vertices);
    EXPECT_EQ(outcome.report.new_triangles, item.new_triangles);
    EXPECT_EQ(outcome.report.pieces, item.pieces);
    EXPECT_EQ(outcome.report.new_lip_edges, item.lip_edges);
  }
}

TEST(CutContract, CountsVerticesExactlyInsideOneTriangle) {
  // The slit's two points split the triangle (+2, +2); both are tips, so each stays one vertex. The middle (+2) is two.
  mesh::TriangleMesh mesh = grid(9);
  const CutOutcome slit = cut(mesh, {Polyline{{{0.42, 0.39}, {0.46, 0.40}}}, plain(), {}});
  EXPECT_EQ(slit.report.new_vertices, 4);
  EXPECT_EQ(slit.report.new_triangles, 6);
  EXPECT_EQ(slit.report.crossed_triangles, 1);
  EXPECT_EQ(slit.report.new_lip_edges, 2);
  // A closed triangle inside one: three points, each doubled; the island is one triangle.
  mesh::TriangleMesh other = grid(9);
  const Polyline loop{{{0.42, 0.39}, {0.46, 0.40}, {0.46, 0.42}, {0.42, 0.39}}};
  const CutOutcome island = cut(other, {loop, plain(), {}});
  EXPECT_EQ(island.report.new_vertices, 6);
  EXPECT_EQ(island.report.new_triangles, 6);
  EXPECT_EQ(island.report.pieces, 2);
}

TEST(CutContract, RefusesBadRequestsWithReasonAndField) {
  const mesh::TriangleMesh mesh = grid(5);
  const Curve good = Polyline{{{0.2, 0.2}, {0.8, 0.7}}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    CutRequest request;
    const char* reason;
    const char* field;
  };
  const auto with = [&](const auto& change) {
    CutRequest request{good, {}, {}};
    change(request);
    return request;
  };
  const std::vector<Case> cases{
      {with([&](CutRequest& r) {
         r.curve = Polyline{{{0, 0}, {nan, 0}}};
       }),
       "CURVE_NOT_FINITE", "cut.curve.polyline.points[1].x"},
      {with([&](CutRequest& r) { r.options.tolerance = nan; }), "OPTION_OUT_OF_RANGE", "cut.tolerance"},
      {with([&](CutRequest& r) { r.options.tolerance = 0.51; }), "OPTION_OUT_OF_RANGE", "cut.tolerance"},
      {with([&](CutRequest& r) { r.options.tolerance_m = 0.0; }), "OPTION_OUT_OF_RANGE", "cut.tolerance_m"},
      {with([&](CutRequest& r) { r.snap = 0.2; }), "OPTION_OUT_OF_RANGE", "cut.snap"},
      {with([&](CutRequest& r) { r.options.min_angle_deg = 28.5; }), "OPTION_OUT_OF_RANGE", "cut.min_angle_deg"},
      {with([&](CutRequest& r) { r.options.max_new_triangles = 0; }), "OPTION_OUT_OF_RANGE", "cut.max_new_triangles"},
      {with([&](CutRequest& r) {
         r.fixed_vertices = {3, 25};
       }),
       "VERTEX_UNKNOWN", "cut.fixed_vertices[1]"},
      {with([&](CutRequest& r) { r.options.tip_edge_length_m = 0.9e-9; }), "OPTION_OUT_OF_RANGE",
       "cut.tip_edge_length_m"},
      {with([&](CutRequest& r) { r.options.tip_edge_length_m = nan; }), "OPTION_OUT_OF_RANGE", "cut.tip_edge_length_m"},
      {with([&](CutRequest& r) { r.options.tip_grading = 1.04; }), "OPTION_OUT_OF_RANGE", "cut.tip_grading"},
      {with([&](CutRequest& r) { r.options.tip_grading = 10.1; }), "OPTION_OUT_OF_RANGE", "cut.tip_grading"},
      {with([&](CutRequest& r) {
         r.options.method = Method::kElement;
         r.options.tip_edge_length_m = 0.01;
       }),
       "OPTIONS_CONFLICT", "cut.tip_edge_length_m"},
      {with([&](CutRequest& r) { r.max_vertices = 0; }), "OPTION_OUT_OF_RANGE", "cut.max_vertices"},
      {with([&](CutRequest& r) { r.fixed_vertices = {-1}; }), "VERTEX_UNKNOWN", "cut.fixed_vertices[0]"},
  };
  for (const Case& item : cases) {
    const Result<CutPlan> planned = plan(mesh, item.request);
    ASSERT_FALSE(planned.ok()) << item.field;
    EXPECT_EQ(planned.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(planned.error().reason, item.reason);
    EXPECT_EQ(planned.error().field, item.field);
  }
}

TEST(CutContract, RefusesAPathOfAbsurdLength) {
  Polyline line;
  for (int i = 0; i < 4096; ++i) line.points.emplace_back(i % 2 == 0 ? -0.01 : 1.01, i / 4096.0);
  const Result<CutPlan> planned = plan(*mesh::make_grid({255, 255, 1.0, 1.0}), {line, {}, {}});
  ASSERT_FALSE(planned.ok());
  EXPECT_EQ(planned.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(planned.error().reason, "CUT_ELEMENT_BUDGET");
}

// The budget runs out in insertion for small limits and in refinement for larger ones.
TEST(CutContract, LeavesTheMeshBitIdenticalWhenTheBudgetRunsOut) {
  mesh::TriangleMesh mesh = grid(20);
  cut(mesh, {Circle{{0.5, 0.5}, 0.2}, {}, {}});
  const mesh::TriangleMesh before = mesh;
  int refused = 0;
  for (std::int32_t budget = 1; budget < 400; budget += 10) {
    CutRequest request{s_curve(), {}, {}};
    request.options.max_new_triangles = budget;
    const Result<CutOutcome> outcome = apply(mesh, *plan(mesh, request));
    if (outcome.ok()) break;
    ++refused;
    EXPECT_EQ(outcome.error().code, ErrorCode::kResourceExhausted);
    EXPECT_EQ(outcome.error().reason, "CUT_ELEMENT_BUDGET");
    ASSERT_TRUE(mesh == before);
    ASSERT_EQ(mesh.state_hash(), before.state_hash());
  }
  EXPECT_GT(refused, 10);
}

TEST(CutContract, KeepsTheLimitOnVertices) {
  mesh::TriangleMesh mesh = grid(20);
  cut(mesh, {Circle{{0.5, 0.5}, 0.2}, {}, {}});
  const mesh::TriangleMesh before = mesh;
  mesh::TriangleMesh free = mesh;
  cut(free, {s_curve(), {}, {}});
  CutRequest request{s_curve(), {}, {}};
  request.max_vertices = free.num_vertices() - 1;
  const Result<CutOutcome> refused = apply(mesh, *plan(mesh, request));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "TOO_MANY_VERTICES");
  EXPECT_TRUE(mesh == before);
  EXPECT_EQ(mesh.state_hash(), before.state_hash());
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  request.max_vertices = free.num_vertices();
  ASSERT_TRUE(apply(mesh, *plan(mesh, request)).ok());
  EXPECT_TRUE(mesh == free);
}

// By one less than what the cut takes it is refused, whatever makes the triangles.
TEST(CutContract, BudgetsHoldAtTheirEdges) {
  CutOptions element, graded;
  element.method = Method::kElement;
  graded.tip_edge_length_m = 0.002;
  for (const CutOptions& options : {CutOptions{}, element, graded}) {
    mesh::TriangleMesh mesh = grid(20);
    cut(mesh, {Circle{{0.5, 0.5}, 0.2}, {}, {}});
    const mesh::TriangleMesh before = mesh;
    CutRequest request{s_curve(), options, {}};
    mesh::TriangleMesh free = mesh;
    cut(free, request);
    const auto refusal = [&](const CutRequest& limited) {
      const Result<CutOutcome> outcome = apply(mesh, *plan(mesh, limited));
      EXPECT_TRUE(mesh == (outcome.ok() ? free : before));
      if (outcome.ok()) mesh = before;
      return outcome.ok() ? std::string() : outcome.error().reason;
    };
    CutRequest limited = request;
    limited.options.max_new_triangles = free.num_triangle_slots() - before.num_triangle_slots();
    EXPECT_EQ(refusal(limited), "");
    --limited.options.max_new_triangles;
    EXPECT_EQ(refusal(limited), "CUT_ELEMENT_BUDGET");
    limited = request;
    limited.max_vertices = free.num_vertices();
    EXPECT_EQ(refusal(limited), "");
    --limited.max_vertices;
    EXPECT_EQ(refusal(limited), "TOO_MANY_VERTICES");
  }
}

TEST(CutContract, AMissLeavesTheMeshBitIdentical) {
  mesh::TriangleMesh mesh = jittered(9);
  const mesh::TriangleMesh before = mesh;
  const std::vector<Curve> misses{Circle{{3, 3}, 1}, Polyline{{{-0.2, 0}, {-0.1, 2}}}, Circle{{0.41, 0.52}, 1e-9}};
  for (const Curve& curve : misses) {
    const CutOutcome outcome = cut(mesh, {curve, {}, {}});
    EXPECT_EQ(outcome.status, CutStatus::kNoIntersection);
    EXPECT_TRUE(outcome.edit.empty());
    EXPECT_EQ(outcome.report.pieces, 1);
    EXPECT_TRUE(mesh == before);
  }
}

TEST(CutContract, ACurveNoLargerThanTheSnapDistanceIsAMissWhereverItIs) {
  const mesh::TriangleMesh sheet = jittered(9);
  const mesh::VertexId vertex = 40;
  const Eigen::Vector2d corner = sheet.rest_position(vertex);
  const std::vector<mesh::VertexId> ring = test::one_ring(sheet, vertex);
  const Eigen::Vector2d on_edge = 0.5 * (corner + sheet.rest_position(ring[0]));
  const Eigen::Vector2d inside = (corner + sheet.rest_position(ring[0]) + sheet.rest_position(ring[1])) / 3.0;
  const double snap = plan(sheet, {Circle{inside, 0.1}, {}, {}})->snap_m;
  for (const Eigen::Vector2d& at : {corner, on_edge, inside}) {
    for (const double size : {1e-6 * snap, 0.5 * snap, 0.99 * snap, 20.0 * snap}) {
      const Eigen::Vector2d half = 0.5 * size * Eigen::Vector2d(0.6, 0.8);
      for (const Curve& curve : {Curve(Circle{at, 0.5 * size}), Curve(Polyline{{at - half, at + half}})}) {
        mesh::TriangleMesh mesh = sheet;
        const CutOutcome outcome = cut(mesh, {curve, {}, {}});
        EXPECT_EQ(outcome.status, size < snap ? CutStatus::kNoIntersection : CutStatus::kApplied)
            << size / snap << " at " << at.transpose();
        EXPECT_EQ(mesh == sheet, size < snap);
      }
    }
  }
}

TEST(CutContract, UndoRestoresTheMeshBitForBit) {
  mesh::TriangleMesh mesh = jittered(15);
  std::vector<mesh::TriangleMesh> states{mesh};
  std::vector<mesh::UndoLog> logs;
  const std::vector<Curve> curves{s_curve(), Circle{{0.5, 0.5}, 0.3}, Polyline{{{-0.1, 0.4}, {1.1, 0.6}}}};
  for (const Curve& curve : curves) {
    logs.push_back(cut(mesh, {curve, {}, {}}).undo);
    states.push_back(mesh);
  }
  for (std::size_t i = logs.size(); i-- > 0;) {
    logs[i].undo(mesh);
    EXPECT_TRUE(mesh == states[i]);
    EXPECT_EQ(mesh.state_hash(), states[i].state_hash());
  }
}

TEST(CutContract, SameCutOnEqualMeshesGivesEqualBits) {
  mesh::TriangleMesh a = jittered(15);
  mesh::TriangleMesh b = a;
  const CutOutcome first = cut(a, {s_curve(), {}, {}});
  const CutOutcome second = cut(b, {s_curve(), {}, {}});
  EXPECT_TRUE(a == b);
  EXPECT_EQ(a.state_hash(), b.state_hash());
  EXPECT_EQ(first.edit.rewritten_triangles, second.edit.rewritten_triangles);
}

TEST(CutContract, RelaxationKeepsFixedVerticesAndCanBeTurnedOff) {
  mesh::TriangleMesh free_mesh = grid(20);
  const CutOutcome free = cut(free_mesh, {s_curve(), {}, {}});
  ASSERT_GT(free.edit.moved_vertices.size(), 4U);
  std::vector<mesh::VertexId> fixed;
  for (std::size_t i = 0; i < free.edit.moved_vertices.size(); i += 2) {
    fixed.push_back(free.edit.moved_vertices[i].vertex);
  }
  mesh::TriangleMesh pinned_mesh = grid(20);
  const mesh::TriangleMesh before = pinned_mesh;
  cut(pinned_mesh, {s_curve(), {}, {fixed.rbegin(), fixed.rend()}});
  for (const mesh::VertexId v : fixed) EXPECT_EQ(pinned_mesh.rest_position(v), before.rest_position(v));

  CutRequest request{s_curve(), {}, {}};
  request.options.relax = false;
  mesh::TriangleMesh still = grid(20);
  EXPECT_TRUE(cut(still, request).edit.moved_vertices.empty());
  for (mesh::VertexId v = 0; v < before.num_vertices(); ++v) {
    ASSERT_EQ(still.rest_position(v), before.rest_position(v));
  }
}

TEST(CutContract, TrianglesOutsideTheTouchedRingStayAsTheyAre) {
  mesh::TriangleMesh mesh = grid(40);
  const mesh::TriangleMesh before = mesh;
  const CutOutcome outcome = cut(mesh, {Circle{{0.5, 0.5}, 0.1}, {}, {}});
  for (mesh::TriangleId t = 0; t < before.num_triangle_slots(); ++t) {
    const auto& rewritten = outcome.edit.rewritten_triangles;
    if (std::binary_search(rewritten.begin(), rewritten.end(), t)) continue;
    mesh::TriangleRecord record = mesh.record(t);
    record.piece = before.piece(t);  // the number of its piece may change anywhere
    ASSERT_TRUE(before.record(t) == record);
  }
  EXPECT_LT(outcome.report.rewritten_triangles, 600);
}

TEST(CutContract, WarnsOfClosedGapsAndMergedDust) {
  mesh::TriangleMesh mesh = grid(11);
  const Curve slit = Polyline{{{0.22, 0.53}, {0.78, 0.53}}};
  const CutOutcome first = cut(mesh, {slit, {}, {}});
  EXPECT_EQ(first.report.closed_gaps, 0);
  EXPECT_EQ(first.report.merged_segments, 0);
  // Ends 1e-5 m short of the slit: the gap is below the snap distance of 1e-4 m and is closed.
  const CutOutcome second = cut(mesh, {Polyline{{{0.45, 0.81}, {0.47, 0.53001}}}, {}, {}});
  EXPECT_GE(second.report.closed_gaps, 1);
  EXPECT_EQ(count_boundary_loops(mesh), 2);
  const Polyline dust{{{0.25, 0.17}, {0.250001, 0.170001}, {0.65, 0.24}}};
  EXPECT_GE(cut(mesh, {dust, {}, {}}).report.merged_segments, 1);
}

// A point of the path is rounded onto the corner of an older lip, which the segment that it stands for passes by.
TEST(CutContract, WarnsOfAGapOfLessThanOneLatticeUnit) {
  mesh::TriangleMesh mesh = grid(11);
  const mesh::Lattice lattice = mesh.lattice();
  const mesh::LatticePoint corner = lattice.nearest({0.52, 0.53});
  const auto beside = [&](std::int64_t x, std::int64_t y) { return lattice.position({corner.x + x, corner.y + y}); };
  const auto a = static_cast<std::int64_t>(0.15 / lattice.spacing);
  cut(mesh, {Polyline{{beside(-a, a / 8), beside(0, 0), beside(a, a / 2)}}, {}, {}});
  const CutReport report = cut(mesh, {Polyline{{beside(-a, -a / 4 - 1), beside(a, a / 4)}}, {}, {}}).report;
  EXPECT_EQ(report.closed_gaps, 1);
  EXPECT_GT(report.widest_gap_m, 0.0);
  EXPECT_LT(report.widest_gap_m, lattice.spacing);
}

// Ends of the path are lattice points beside the slanted border, nearer to it than double precision can tell for some.
TEST(CutContract, WarnsOfAGapAtALongBorder) {
  const Vector2d from(0.1, 0.07);
  const Vector2d to(1.13, 1.31);
  mesh::IndexedMesh triangle;
  triangle.rest.resize(2, 3);
  triangle.rest << from, to, Vector2d(0.2, 1.2);
  triangle.triangles = Eigen::Vector3i(0, 1, 2);
  const mesh::TriangleMesh sheet = test::must(mesh::import_mesh(triangle));
  SeededRandom random(7);
  for (int i = 0; i < 4000; ++i) {
    mesh::TriangleMesh mesh = sheet;
    const Polyline along{
        {from + random.uniform(0.01, 0.4) * (to - from), from + random.uniform(0.6, 0.99) * (to - from)}};
    const CutOutcome outcome = cut(mesh, {along, plain(), {}});
    ASSERT_EQ(outcome.status, CutStatus::kNoIntersection);
    ASSERT_GE(outcome.report.closed_gaps, 1) << i;
    ASSERT_GT(outcome.report.widest_gap_m, 0.0) << i;
    ASSERT_LT(outcome.report.widest_gap_m, 2.0 * mesh.lattice().spacing) << i;
  }
}

TEST(CutContract, ACurveFarAwayDoesNotFillTheVoid) {
  mesh::TriangleMesh mesh = grid(10);
  const std::int32_t slots = mesh.num_triangle_slots();
  Polyline line{{{0.5, 0.5}, {5000.0, 4000.0}, {-8000.0, 7000.0}, {0.51, 0.9}}};
  const CutOutcome outcome = cut(mesh, {line, {}, {}});
  EXPECT_EQ(outcome.status, CutStatus::kApplied);
  EXPECT_EQ(outcome.report.pieces, 1);
  EXPECT_LT(mesh.num_triangle_slots() - slots, outcome.report.new_triangles + 40);
}

}  // namespace
}  // namespace kerf::cut
