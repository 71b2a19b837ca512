// Opening: which vertices a cut makes, what they and moved ones inherit from, and which pieces there are afterwards.

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/mesh/mesh_editor.h"
#include "tests/mesh/edit_checks.h"
#include "tests/mesh/measures.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

// Cuts along existing edges, through the points listed.
void cut_along(MeshEditor& editor, const std::vector<PointId>& path) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Recovery made = editor.recover_edge(path[i], path[i + 1], kLockCut);
    ASSERT_EQ(made.status, Recovery::Status::kRecovered);
  }
}

std::size_t num_vertices_at(const TriangleMesh& mesh, PointId p) {
  std::size_t count = 0;
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) count += mesh.point(v) == p;
  return count;
}

TEST(Opening, CuttingOneEdgeInsideOpensNothing) {
  TriangleMesh mesh = test::grid(5);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  cut_along(editor, {6, 7});
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_vertices(), 25);
  EXPECT_EQ(mesh.num_boundary_loops(), 2);
  EXPECT_EQ(done.edit.rewritten_triangles.size(), 2u);
}

TEST(Opening, OpeningGivesOneVertexPerSector) {
  TriangleMesh mesh = test::grid(5);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  cut_along(editor, {10, 11, 12, 13, 14});  // across
  cut_along(editor, {2, 7, 12, 17, 22});    // and up
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_pieces(), 4);
  EXPECT_EQ(mesh.num_boundary_loops(), 4);
  EXPECT_EQ(num_vertices_at(mesh, 12), 4u);
  EXPECT_EQ(num_vertices_at(mesh, 7), 2u);
  EXPECT_EQ(num_vertices_at(mesh, 2), 2u);
  EXPECT_EQ(mesh.num_vertices(), 25 + 3 + 8);
  for (const VertexSource& added : done.edit.added_vertices) {
    EXPECT_EQ(added.sources[0], mesh.point(added.vertex));  // in a grid as built, vertex and point ids agree
    EXPECT_EQ(added.weights, Eigen::Vector3d(1, 0, 0));
  }
}

TEST(Opening, ALoopCutsOutAPieceAndATipStaysSingle) {
  TriangleMesh mesh = test::grid(6);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  cut_along(editor, {7, 8, 9, 15, 21, 20, 19, 13, 7});  // a square of two cells
  cut_along(editor, {9, 10});                           // a spur that ends inside
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_pieces(), 2);
  EXPECT_EQ(mesh.num_boundary_loops(), 3);
  EXPECT_EQ(num_vertices_at(mesh, 9), 3u);
  EXPECT_EQ(num_vertices_at(mesh, 10), 1u);
  EXPECT_EQ(mesh.piece(0), 0);  // the larger part keeps the number
}

// A point on a lip: each side interpolates between its own two vertices, wherever rounding has put the point.
TEST(Opening, APointOnALipTakesEachSidesOwnVertices) {
  for (const std::int64_t nudge : {-1, 0, 1}) {
    TriangleMesh mesh = test::grid(5);
    {
      MeshEditor cut(mesh);
      cut_along(cut, {10, 11, 12, 13});
      (void)cut.commit();
    }
    const TriangleMesh before = mesh;
    MeshEditor editor(mesh);
    int corner = 0;
    TriangleId t = mesh.find_edge(11, 12, corner);
    LatticePoint p = middle_of(mesh, 11, 12);
    p.y += nudge;
    const PointId first = editor.split_edge(t, corner, p);
    ASSERT_NE(first, kNone);
    t = mesh.find_edge(first, 12, corner);  // and again on one half
    p = middle_of(mesh, first, 12);
    p.y -= nudge;
    const PointId second = editor.split_edge(t, corner, p);
    ASSERT_NE(second, kNone);
    editor.legalise(second);
    const CommittedEdit done = editor.commit();
    test::expect_sound(before, mesh, done.edit);
    ASSERT_EQ(done.edit.added_vertices.size(), 4u);
    for (const VertexSource& added : done.edit.added_vertices) {
      std::vector<TriangleId> ring;
      mesh.triangles_around(added.vertex, ring);
      double side = 0.0;  // the y of the sector's triangles, relative to the lip
      for (const TriangleId s : ring) {
        for (const VertexId v : mesh.vertices(s)) side += mesh.rest_position(v).y() - 0.5;
      }
      double sum_along = 0.0;
      for (int k = 0; k < 3; ++k) {
        if (added.weights[k] == 0.0) continue;
        sum_along += added.weights[k];
        double source_side = 0.0;  // of the old vertex's own triangles
        before.triangles_around(added.sources[k], ring);
        for (const TriangleId s : ring) {
          for (const VertexId v : before.vertices(s)) source_side += before.rest_position(v).y() - 0.5;
        }
        const PointId source = before.point(added.sources[k]);
        EXPECT_TRUE(source == 12 || (source == 11 && side * source_side > 0.0));
      }
      EXPECT_NEAR(sum_along, 1.0, 1e-15);
    }
  }
}

TEST(Opening, MovedPointsInheritFromWhereTheyEndUp) {
  TriangleMesh mesh = test::grid(5);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  LatticePoint to = mesh.at(12);
  to.x += (mesh.at(13).x - mesh.at(12).x) / 4;
  to.y += (mesh.at(13).x - mesh.at(12).x) / 8;
  ASSERT_TRUE(editor.move_point(12, to));
  ASSERT_TRUE(editor.move_point(6, {mesh.at(6).x + 5, mesh.at(6).y}));
  ASSERT_TRUE(editor.move_point(6, before.at(6)));   // and back: not moved after all
  EXPECT_FALSE(editor.move_point(2, to));            // border
  EXPECT_FALSE(editor.move_point(12, mesh.at(24)));  // out of its star
  EXPECT_FALSE(editor.move_point(12, mesh.at(13)));  // flat
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  ASSERT_EQ(done.edit.moved_vertices.size(), 1u);
  EXPECT_EQ(done.edit.moved_vertices[0].vertex, 12);
  EXPECT_EQ(done.edit.rewritten_triangles.size(), 6u);
}

TEST(Opening, ACutThroughAMovedPointInterpolatesForBothVertices) {
  TriangleMesh mesh = test::grid(5);
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  LatticePoint to = mesh.at(12);
  to.x += (mesh.at(13).x - mesh.at(12).x) / 4;
  ASSERT_TRUE(editor.move_point(12, to));
  cut_along(editor, {11, 12, 13});
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  ASSERT_EQ(done.edit.moved_vertices.size(), 1u);
  ASSERT_EQ(done.edit.added_vertices.size(), 1u);
  EXPECT_EQ(done.edit.added_vertices[0].weights, done.edit.moved_vertices[0].weights);
  EXPECT_EQ(done.edit.added_vertices[0].sources, done.edit.moved_vertices[0].sources);
}

TEST(Opening, ACutInOneOfManyPiecesRenumbersOnlyThat) {
  TriangleMesh mesh = test::must(import_mesh(test::two_components()));
  const TriangleMesh before = mesh;
  MeshEditor editor(mesh);
  cut_along(editor, {4, 6});
  const CommittedEdit done = editor.commit();
  test::expect_sound(before, mesh, done.edit);
  EXPECT_EQ(mesh.num_pieces(), 3);
  EXPECT_EQ(mesh.piece(0), 0);
  EXPECT_NE(mesh.piece(2), mesh.piece(3));
}

}  // namespace
}  // namespace kerf::mesh
