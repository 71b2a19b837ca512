// The checker finds what it says it finds: one seeded fault at a time in a mesh that was sound.

#include <functional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "server/core/mesh/mesh_editor.h"
#include "server/core/mesh/refine/delaunay.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

// A 5 x 5 grid cut along x = 0.5 from below to the centre: vertices 2 and 7 are doubled, 12 is the tip.
TriangleMesh cut_grid() {
  TriangleMesh mesh = test::grid(5);
  MeshEditor editor(mesh);
  for (const auto& [p, q] : {std::pair{2, 7}, std::pair{7, 12}}) {
    int corner = 0;
    const TriangleId t = mesh.find_edge(p, q, corner);
    EXPECT_TRUE(editor.lock_edge(t, corner, kLockCut));
  }
  (void)editor.commit();
  return mesh;
}

struct Edge {
  TriangleId t, u;
  int k, m;
};

Edge edge_between(const TriangleMesh& mesh, PointId p, PointId q) {
  Edge edge{};
  edge.t = mesh.find_edge(p, q, edge.k);
  edge.u = mesh.welded_neighbour(edge.t, edge.k);
  edge.m = mesh.mirror_corner(edge.t, edge.k);
  return edge;
}

void set_locks(MeshData& r, const Edge& edge, LockBits bits) {
  r.triangles[edge.t].locks[edge.k] = bits;
  r.triangles[edge.u].locks[edge.m] = bits;
}

void expect_found(const std::string& invariant, const std::string& fault,
                  const std::function<void(MeshData&, const TriangleMesh&)>& seed) {
  SCOPED_TRACE(fault);
  const TriangleMesh sound = cut_grid();
  ASSERT_EQ(sound.find_violation(), std::nullopt);
  MeshData data = sound.data();
  seed(data, sound);
  const std::optional<std::string> found = TriangleMesh(std::move(data)).find_violation();
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->substr(0, found->find(':')), invariant) << *found;
}

using Records = MeshData;

TEST(FindViolation, SeesBrokenIndices) {
  expect_found("I1", "point id", [](Records& r, auto&) { r.triangles[3].points[1] = 999; });
  expect_found("I1", "repeated corner", [](Records& r, auto&) { r.triangles[3].points[1] = r.triangles[3].points[0]; });
  expect_found("I1", "neighbour id", [](Records& r, auto&) { r.triangles[3].neighbours[1] = 12345; });
  expect_found("I1", "vertex id", [](Records& r, auto&) { r.triangles[3].vertices[1] = -7; });
  expect_found("I1", "region", [](Records& r, auto&) { r.triangles[3].region = -2; });
  expect_found("I1", "solid count", [](Records& r, auto&) { ++r.num_solid_triangles; });
  expect_found("I1", "point's triangle", [](Records& r, auto&) { r.points[3].triangle = kNone; });
  expect_found("I1", "vertex's point", [](Records& r, auto&) { r.vertices[3].point = kNone; });
  expect_found("I1", "far point", [](Records& r, auto&) { r.points[3].at.x = 2 * kMaxCoordinate; });
}

TEST(FindViolation, SeesBrokenAdjacency) {
  expect_found("I2", "neighbour dropped on one side", [](Records& r, const TriangleMesh& mesh) {
    const Edge edge = edge_between(mesh, 6, 12);
    r.triangles[edge.t].neighbours[edge.k] = kNone;
  });
  expect_found("I2", "link to a stranger", [](Records& r, const TriangleMesh& mesh) {
    const Edge edge = edge_between(mesh, 6, 12);
    r.triangles[edge.t].neighbours[edge.k] = 31;
  });
  expect_found("I2", "one corner rewritten in one slot", [](Records& r, auto&) {
    r.triangles[10].points[0] = 24;
    r.triangles[10].vertices[0] = 24;
  });
}

TEST(FindViolation, SeesInvertedAndFlatTriangles) {
  expect_found("I3", "point beyond its star", [](Records& r, auto&) { r.points[6].at = r.points[24].at; });
  expect_found("I3", "point on an edge of its star", [](Records& r, auto&) { r.points[6].at = r.points[7].at; });
  expect_found("I3", "corners turned", [](Records& r, auto&) {
    for (TriangleRecord& t : r.triangles) {
      std::swap(t.points[0], t.points[1]);
      std::swap(t.vertices[0], t.vertices[1]);
      std::swap(t.neighbours[0], t.neighbours[1]);
      std::swap(t.locks[0], t.locks[1]);
    }
  });
}

TEST(FindViolation, SeesBrokenLocks) {
  expect_found("I4", "lock on one side", [](Records& r, const TriangleMesh& mesh) {
    const Edge edge = edge_between(mesh, 17, 18);
    r.triangles[edge.t].locks[edge.k] = kLockCut;
  });
  expect_found("I4", "lock of an edit left",
               [](Records& r, const TriangleMesh& mesh) { set_locks(r, edge_between(mesh, 17, 18), kLockRequest); });
  expect_found("I5", "border unlocked",
               [](Records& r, const TriangleMesh& mesh) { set_locks(r, edge_between(mesh, 0, 1), 0); });
  expect_found("I5", "border inside",
               [](Records& r, const TriangleMesh& mesh) { set_locks(r, edge_between(mesh, 17, 18), kLockBorder); });
  expect_found("I5", "cut along the border", [](Records& r, const TriangleMesh& mesh) {
    set_locks(r, edge_between(mesh, 0, 1), kLockBorder | kLockCut);
  });
  expect_found("I5", "solid turned void", [](Records& r, auto&) {
    r.triangles[20].region = r.triangles[20].piece = kNone;
    r.triangles[20].vertices = {kNone, kNone, kNone};
    --r.num_solid_triangles;
  });
}

TEST(FindViolation, SeesBrokenVertices) {
  expect_found("I6", "vertex in the void", [](Records& r, auto&) { r.triangles.back().vertices[0] = 0; });
  expect_found("I6", "no vertex", [](Records& r, auto&) { r.triangles[9].vertices[2] = kNone; });
  expect_found("I6", "vertex of another point", [](Records& r, auto&) { r.triangles[9].vertices[2] = 0; });
  expect_found("I7", "lip joined but vertices apart",
               [](Records& r, const TriangleMesh& mesh) { set_locks(r, edge_between(mesh, 2, 7), 0); });
  expect_found("I7", "vertices apart without a cut", [](Records& r, const TriangleMesh& mesh) {
    const TriangleId t = mesh.triangle_at(18);
    r.triangles[t].vertices[mesh.corner_of(t, 18)] = mesh.num_vertices();
    r.vertices.push_back({18, t});
  });
  expect_found("I8", "lips that share their vertices (bow-tie)", [](Records& r, const TriangleMesh& mesh) {
    set_locks(r, edge_between(mesh, 16, 17), kLockCut);
    set_locks(r, edge_between(mesh, 17, 18), kLockCut);
  });
  expect_found("I9", "point's triangle without it", [](Records& r, auto&) { r.points[24].triangle = 0; });
  expect_found("I9", "vertex's triangle without it", [](Records& r, auto&) { r.vertices[24].triangle = 0; });
  expect_found("I9", "vertex without triangles", [](Records& r, auto&) { r.vertices.push_back({18, 26}); });
  expect_found("I9", "point without triangles", [](Records& r, auto&) { r.points.push_back({{12345, 6789}, 0}); });
}

TEST(FindViolation, SeesWrongPieces) {
  expect_found("I11", "label out of range", [](Records& r, auto&) { r.triangles[5].piece = 1; });
  expect_found("I11", "no label", [](Records& r, auto&) { r.triangles[5].piece = kNone; });
  expect_found("I11", "label changes inside a piece", [](Records& r, auto&) {
    r.num_pieces = 2;
    r.triangles[5].piece = 1;
  });
  expect_found("I11", "number of pieces", [](Records& r, auto&) { r.num_pieces = 2; });
  const TriangleMesh two = test::must(import_mesh(test::two_components()));
  MeshData data = two.data();
  for (TriangleRecord& t : data.triangles) t.piece = t.piece == 1 ? 0 : t.piece;
  EXPECT_NE(TriangleMesh(data).find_violation(), std::nullopt);
}

// Two copies of a domain glued crosswise along an edge: positive and adjacent everywhere, yet it covers the domain
// twice.
TEST(FindViolation, SeesADoubleCover) {
  TriangleMesh domain = make_empty_domain(Lattice{});
  MeshEditor editor(domain);
  const std::vector<LatticePoint> points{{0, 0}, {1000, 7}, {-500, 800}, {700, -900}};
  const std::vector<PointId> inserted = insert_delaunay(editor, points);
  (void)editor.commit();
  ASSERT_EQ(domain.find_violation(), std::nullopt);
  MeshData data = domain.data();
  const PointId p = inserted[0], q = inserted[1];
  const Edge edge = edge_between(domain, p, q);
  ASSERT_NE(edge.t, kNone);
  const std::int32_t n = domain.num_triangle_slots();
  const std::int32_t num_points = domain.num_points();
  for (PointId i = 0; i < num_points; ++i) data.points.push_back({domain.at(i), data.points[i].triangle + n});
  for (TriangleId t = 0; t < n; ++t) {
    TriangleRecord copy = domain.record(t);
    for (int k = 0; k < 3; ++k) {
      if (copy.points[k] != p && copy.points[k] != q) copy.points[k] += num_points;
      if (copy.neighbours[k] != kNone) copy.neighbours[k] += n;
    }
    data.triangles.push_back(copy);
  }
  data.triangles[edge.t].neighbours[edge.k] = edge.u + n;
  data.triangles[edge.u + n].neighbours[edge.m] = edge.t;
  data.triangles[edge.u].neighbours[edge.m] = edge.t + n;
  data.triangles[edge.t + n].neighbours[edge.k] = edge.u;
  for (const PointId branch : {p, q}) {  // Their second records would be orphaned: give them a place of their own.
    data.points[branch + num_points] = data.points.back();
  }
  data.points.resize(static_cast<std::size_t>(2 * num_points));
  const std::optional<std::string> found = TriangleMesh(data).find_violation();
  ASSERT_TRUE(found.has_value());
  EXPECT_TRUE(found->starts_with("I10") || found->starts_with("I9")) << *found;
}

}  // namespace
}  // namespace kerf::mesh
