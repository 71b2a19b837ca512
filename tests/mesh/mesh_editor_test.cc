// Every operation of MeshEditor on its own: what it does, what survives, what it refuses.

#include "server/core/mesh/mesh_editor.h"

#include <algorithm>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/mesh/edit_checks.h"
#include "tests/mesh/measures.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

LatticePoint centroid(const TriangleMesh& mesh, TriangleId t) {
  LatticePoint sum;
  for (const PointId p : mesh.points(t)) {
    sum.x += mesh.at(p).x / 3;
    sum.y += mesh.at(p).y / 3;
  }
  return sum;
}

TEST(MeshEditor, SplitTriangleKeepsTheOldSlotAndAddsTwo) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  const PointId p = editor.split_triangle(5, centroid(mesh, 5));
  ASSERT_NE(p, kNone);
  EXPECT_TRUE(editor.is_new(p));
  EXPECT_EQ(mesh.num_triangle_slots(), before.num_triangle_slots() + 2);
  EXPECT_EQ(mesh.num_solid_triangles(), before.num_solid_triangles() + 2);
  EXPECT_EQ(mesh.welded_neighbour(5, 0), before.welded_neighbour(5, 0));
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  ASSERT_EQ(done.edit.added_vertices.size(), 1u);
  EXPECT_LT((done.edit.added_vertices[0].weights - Eigen::Vector3d::Constant(1.0 / 3.0)).norm(), 1e-14);
  EXPECT_EQ(done.edit.rewritten_triangles.size(), 5u);  // it, two new ones, and two neighbours whose links changed
}

TEST(MeshEditor, SplitTriangleRefusesWhatIsNotStrictlyInside) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  const std::array<PointId, 3> p = mesh.points(5);
  EXPECT_EQ(editor.split_triangle(5, mesh.at(p[0])), kNone);
  EXPECT_EQ(editor.split_triangle(5, middle_of(mesh, p[0], p[1])), kNone);
  EXPECT_EQ(editor.split_triangle(5, centroid(mesh, 7)), kNone);
  EXPECT_TRUE(mesh == before);
}

TEST(MeshEditor, SplitTriangleKeepsClearOfLocks) {
  TriangleMesh mesh = test::grid(4);
  MeshEditor editor(mesh);
  LatticePoint p = middle_of(mesh, 0, 1);  // on the lower border, edge of slot 0
  p.y += MeshEditor::kLockClearance - 1;
  EXPECT_EQ(editor.split_triangle(0, p), kNone);
  p.y += 1;
  EXPECT_NE(editor.split_triangle(0, p), kNone);
}

TEST(MeshEditor, SplitEdgeInsideAddsOneVertex) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  ASSERT_NE(editor.split_edge(0, 1, middle_of(mesh, 0, 5)), kNone);
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_solid_triangles(), before.num_solid_triangles() + 2);
  ASSERT_EQ(done.edit.added_vertices.size(), 1u);
  std::set<VertexId> used;
  for (int k = 0; k < 3; ++k) {
    if (done.edit.added_vertices[0].weights[k] > 1e-12) used.insert(done.edit.added_vertices[0].sources[k]);
  }
  EXPECT_EQ(used, (std::set<VertexId>{0, 5}));
}

TEST(MeshEditor, SplitEdgeOnTheBorderSplitsTheVoidToo) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  const PointId p = editor.split_edge(0, 2, middle_of(mesh, 0, 1));
  ASSERT_NE(p, kNone);
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_solid_triangles(), before.num_solid_triangles() + 1);
  EXPECT_EQ(mesh.num_triangle_slots(), before.num_triangle_slots() + 2);
  EXPECT_TRUE((mesh.locks_at_point(p) & kLockBorder) != 0);
}

TEST(MeshEditor, SplitEdgeAcceptsARoundedPointAndRefusesAFarOne) {
  TriangleMesh mesh = test::grid(4);
  MeshEditor editor(mesh);
  LatticePoint p = middle_of(mesh, 0, 5);
  EXPECT_EQ(editor.split_edge(0, 1, mesh.at(0)), kNone);
  EXPECT_EQ(editor.split_edge(0, 1, centroid(mesh, 20)), kNone);
  p.x += 1;
  EXPECT_NE(editor.split_edge(0, 1, p), kNone);
  (void)editor.commit();
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
}

TEST(MeshEditor, FlipSwapsADiagonalInPlace) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  ASSERT_TRUE(editor.flip_edge(0, 1));
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_triangle_slots(), before.num_triangle_slots());
  int corner = 0;
  EXPECT_EQ(mesh.find_edge(0, 5, corner), kNone);
  EXPECT_NE(mesh.find_edge(1, 4, corner), kNone);
  EXPECT_TRUE(done.edit.added_vertices.empty());
}

TEST(MeshEditor, FlipRefusesFixedEdgesAndQuadsThatAreNotConvex) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  EXPECT_FALSE(editor.flip_edge(0, 2));  // border
  EXPECT_TRUE(mesh == before);
  const PointId p = editor.split_triangle(5, centroid(mesh, 5));
  int corner = 0;
  const TriangleId t = mesh.find_edge(p, before.points(5)[0], corner);
  EXPECT_FALSE(editor.flip_edge(t, corner));  // p has degree three
  ASSERT_TRUE(editor.lock_edge(0, 1, kLockOriginal));
  EXPECT_FALSE(editor.flip_edge(0, 1));
  TriangleMesh regions = test::must(import_mesh(test::two_regions()));
  MeshEditor region_editor(regions);
  EXPECT_FALSE(region_editor.flip_edge(1, 0));
}

TEST(MeshEditor, LockRefusesToCutTheBorderAndTheVoid) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  EXPECT_FALSE(editor.lock_edge(0, 2, kLockCut));
  EXPECT_FALSE(editor.lock_edge(mesh.num_triangle_slots() - 1, 0, kLockCut));
  EXPECT_TRUE(mesh == before);
}

TEST(MeshEditor, RecoversEdgesAcrossTheMesh) {
  TriangleMesh mesh = test::jittered_grid(12, 5);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  const Recovery made = editor.recover_edge(13, 130, kLockCut);
  ASSERT_EQ(made.status, Recovery::Status::kRecovered);
  int corner = 0;
  EXPECT_EQ(mesh.find_edge(13, 130, corner), made.triangle);
  EXPECT_EQ(corner, made.corner);
  EXPECT_NE(mesh.locks(made.triangle, made.corner) & kLockCut, 0);
  const Recovery again = editor.recover_edge(13, 130, 0);
  EXPECT_EQ(again.status, Recovery::Status::kRecovered);
  const Recovery crossing = editor.recover_edge(22, 121, kLockCut);
  ASSERT_EQ(crossing.status, Recovery::Status::kFixedEdge);
  const std::array<PointId, 3>& p = mesh.points(crossing.triangle);
  const std::pair ends = std::minmax(p[next_corner(crossing.corner)], p[previous_corner(crossing.corner)]);
  EXPECT_EQ(ends, (std::pair<const PointId&, const PointId&>(13, 130)));
  test::expect_sound(before, mesh, editor.commit().edit);
}

TEST(MeshEditor, RecoveryStopsAtPointsAndRegions) {
  TriangleMesh mesh = test::grid(6);
  MeshEditor editor(mesh);
  const Recovery through = editor.recover_edge(0, 28, kLockCut);  // the diagonal passes through 7, 14, 21
  EXPECT_EQ(through.status, Recovery::Status::kPoint);
  EXPECT_EQ(through.point, 7);
  TriangleMesh regions = test::must(import_mesh(test::two_regions()));
  MeshEditor region_editor(regions);
  const PointId low = region_editor.split_triangle(1, {regions.at(4).x + (regions.at(2).x - regions.at(4).x) / 2,
                                                       regions.at(4).y + (regions.at(2).y - regions.at(4).y) / 4});
  const PointId high = region_editor.split_triangle(2, {regions.at(4).x + (regions.at(2).x - regions.at(4).x) / 8,
                                                        regions.at(4).y + (regions.at(2).y - regions.at(4).y) / 2});
  ASSERT_NE(low, kNone);
  ASSERT_NE(high, kNone);
  EXPECT_EQ(region_editor.recover_edge(low, high, kLockCut).status, Recovery::Status::kFixedEdge);
}

TEST(MeshEditor, LegaliseMakesNewPointsDelaunayAndLeavesTiesAlone) {
  TriangleMesh regular = test::grid(6);
  {
    MeshEditor editor(regular);
    for (PointId p = 0; p < 36; ++p) EXPECT_EQ(editor.legalise(p), 0);
  }
  TriangleMesh mesh = test::jittered_grid(8, 21);
  MeshEditor editor(mesh);
  SeededRandom random(9);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d at(random.uniform(0.001, 0.999), random.uniform(0.001, 0.999));
    const PointId p = editor.insert_point(mesh.lattice().nearest(at));
    ASSERT_NE(p, kNone);
    editor.legalise(p);
  }
  (void)editor.commit();
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const TriangleId n = mesh.neighbour(t, k);
      if (n == kNone) continue;
      const std::array<PointId, 3>& p = mesh.points(t);
      ASSERT_LE(
          in_circle(mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2]), mesh.at(mesh.points(n)[mesh.mirror_corner(t, k)])), 0);
    }
  }
}

TEST(MeshEditor, TheBudgetStopsGrowth) {
  TriangleMesh mesh = test::grid(4);
  const TriangleMesh before = mesh;
  {
    MeshEditor editor(mesh, mesh.num_triangle_slots() + 3);
    EXPECT_NE(editor.split_triangle(0, centroid(mesh, 0)), kNone);
    EXPECT_FALSE(editor.budget_exhausted());
    EXPECT_EQ(editor.split_triangle(4, centroid(mesh, 4)), kNone);
    EXPECT_TRUE(editor.budget_exhausted());
    EXPECT_EQ(editor.split_edge(8, 1, middle_of(mesh, mesh.points(8)[2], mesh.points(8)[0])), kNone);
  }
  EXPECT_TRUE(mesh == before);  // the editor went without commit
}

TEST(MeshEditor, LocateAgreesWithEverySlotAndNeedsNoLuckyHint) {
  TriangleMesh mesh = test::jittered_grid(9, 2);
  SeededRandom random(4);
  const auto hint = [&] {
    return static_cast<TriangleId>(random.below(static_cast<std::uint64_t>(mesh.num_triangle_slots())));
  };
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d position(random.uniform(-0.8, 1.8), random.uniform(-0.8, 1.8));
    LatticePoint p = mesh.lattice().nearest(position);
    const TriangleId t = hint();
    if (i % 4 == 1) p = mesh.at(mesh.points(t)[0]);
    if (i % 4 == 2) p = middle_of(mesh, mesh.points(t)[0], mesh.points(t)[1]);
    const Location found = mesh.locate(p);
    const Location other = mesh.locate(p, hint());
    if (found.kind == Location::Kind::kOutside) {
      EXPECT_GE(std::max(std::abs(p.x), std::abs(p.y)), Lattice::kHalfDomain);
      continue;
    }
    ASSERT_EQ(found.kind, other.kind);
    const std::array<PointId, 3>& c = mesh.points(found.triangle);
    int num_zero = 0;
    for (int k = 0; k < 3; ++k) {
      const int side = orient2d(mesh.at(c[k]), mesh.at(c[next_corner(k)]), p);
      ASSERT_GE(side, 0);
      num_zero += side == 0;
    }
    if (found.kind == Location::Kind::kPoint) {
      EXPECT_EQ(mesh.at(found.point), p);
      EXPECT_EQ(found.point, other.point);
    } else {
      EXPECT_EQ(num_zero, found.kind == Location::Kind::kEdge ? 1 : 0);
      EXPECT_EQ(found.triangle, other.triangle);
      EXPECT_EQ(found.corner, other.corner);
    }
  }
  EXPECT_EQ(mesh.locate({kMaxCoordinate, 0}).kind, Location::Kind::kOutside);
}

}  // namespace
}  // namespace kerf::mesh
