// Grids, import from arrays, and what is refused.

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/mesh/measures.h"
#include "tests/support/meshes.h"

namespace kerf::mesh {
namespace {

bool has_lock(const TriangleMesh& mesh, VertexId v, LockBits lock) {
  return (mesh.locks_at_point(mesh.point(v)) & lock) != 0;
}

void expect_refused(const IndexedMesh& sheet, const std::string& reason, const std::string& mentions) {
  const Result<TriangleMesh> result = import_mesh(sheet);
  ASSERT_FALSE(result.ok()) << reason;
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(result.error().reason, reason) << result.error().message;
  EXPECT_NE(result.error().message.find(mentions), std::string::npos) << result.error().message;
  EXPECT_FALSE(result.error().field.empty());
}

TEST(Grid, HasRowMajorVerticesAndSolidSlotsFirst) {
  const TriangleMesh mesh = test::must(make_grid({5, 4, 2.0, 0.6}));
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  ASSERT_EQ(mesh.num_vertices(), 20);
  ASSERT_EQ(mesh.num_solid_triangles(), 24);
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) EXPECT_EQ(mesh.is_solid(t), t < 24);
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 5; ++i) {
      EXPECT_LT((mesh.rest_position(j * 5 + i) - Eigen::Vector2d(i * 0.5, j * 0.2)).norm(), 1e-15);
      EXPECT_EQ(has_lock(mesh, j * 5 + i, kLockBorder), i == 0 || j == 0 || i == 4 || j == 3);
      EXPECT_FALSE(has_lock(mesh, j * 5 + i, kLockCut));
    }
  }
  EXPECT_EQ(mesh.vertices(0), (std::array<VertexId, 3>{0, 1, 6}));
  EXPECT_EQ(mesh.vertices(1), (std::array<VertexId, 3>{0, 6, 5}));
  EXPECT_EQ(mesh.neighbour(0, 1), 1);  // across the diagonal
  EXPECT_EQ(mesh.neighbour(0, 2), kNone);
  EXPECT_EQ(mesh.num_pieces(), 1);
  EXPECT_EQ(mesh.num_boundary_loops(), 1);
  EXPECT_NEAR(total_area(mesh), 1.2, 1e-14);
  EXPECT_NEAR(mesh.base_edge_length(), std::sqrt(0.1), 1e-14);
  EXPECT_LT((mesh.bounding_box().max() - Eigen::Vector2d(2.0, 0.6)).norm(), 1e-14);
}

TEST(Grid, RingsGoRoundCounterClockwise) {
  const TriangleMesh mesh = test::grid(5);
  std::vector<TriangleId> ring;
  mesh.triangles_around(12, ring);
  EXPECT_EQ(ring.size(), 6u);
  std::vector<VertexId> vertices = test::one_ring(mesh, 12);
  const std::vector<VertexId> around{13, 18, 17, 11, 6, 7};
  ASSERT_EQ(vertices.size(), 6u);
  const auto first = std::find(vertices.begin(), vertices.end(), 13);
  ASSERT_NE(first, vertices.end());
  std::rotate(vertices.begin(), first, vertices.end());
  EXPECT_EQ(vertices, around);
  mesh.triangles_around(2, ring);  // on the lower border: from the clockwise end
  EXPECT_EQ(ring, (std::vector<TriangleId>{4, 5, 2}));
  EXPECT_EQ(test::one_ring(mesh, 2), (std::vector<VertexId>{3, 8, 7, 1}));
}

TEST(Grid, JitteredIsDelaunayAndKeepsTheBorder) {
  const TriangleMesh mesh = test::jittered_grid(20, 11);
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  EXPECT_EQ(mesh.num_vertices(), 400);
  EXPECT_EQ(mesh.num_solid_triangles(), 2 * 19 * 19);
  EXPECT_NEAR(total_area(mesh), 1.0, 1e-14);
  int num_displaced = 0;
  for (VertexId v = 0; v < 400; ++v) {
    const Eigen::Vector2d regular((v % 20) / 19.0, (v / 20) / 19.0);
    const double distance = (mesh.rest_position(v) - regular).cwiseAbs().maxCoeff();
    EXPECT_LE(distance, has_lock(mesh, v, kLockBorder) ? 1e-15 : 0.3 / 19.0);
    num_displaced += distance > 1e-6;
  }
  EXPECT_EQ(num_displaced, 18 * 18);
  for (TriangleId t = 0; t < mesh.num_solid_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const TriangleId n = mesh.neighbour(t, k);
      if (n == kNone) continue;
      const std::array<PointId, 3>& p = mesh.points(t);
      const PointId across = mesh.points(n)[mesh.mirror_corner(t, k)];
      ASSERT_LE(in_circle(mesh.at(p[0]), mesh.at(p[1]), mesh.at(p[2]), mesh.at(across)), 0);
    }
  }
  EXPECT_EQ(test::jittered_grid(20, 11).state_hash(), mesh.state_hash());
  EXPECT_NE(test::jittered_grid(20, 12).state_hash(), mesh.state_hash());
}

TEST(Grid, HandlesNarrowCellsAndManyVertices) {
  EXPECT_EQ(test::must(make_jittered_grid({3, 60, 5.0, 0.1}, 3)).find_violation(), std::nullopt);
  EXPECT_EQ(test::must(make_grid({2, 2, 0.02, 1e4})).find_violation(), std::nullopt);
  const TriangleMesh large = test::grid(200);
  EXPECT_EQ(large.num_vertices(), 40000);
  EXPECT_EQ(large.find_violation(), std::nullopt);
}

TEST(Grid, RefusesAbsurdSizes) {
  const double nan = std::nan("");
  EXPECT_EQ(make_grid({1, 5, 1.0, 1.0}).error().reason, "GRID_SIZE");
  EXPECT_EQ(make_grid({5, -5, 1.0, 1.0}).error().reason, "GRID_SIZE");
  EXPECT_EQ(make_grid({1000, 501, 1.0, 1.0}).error().reason, "GRID_SIZE");
  EXPECT_EQ(make_jittered_grid({2147483647, 2147483647, 1.0, 1.0}, 1).error().reason, "GRID_SIZE");
  EXPECT_EQ(make_grid({5, 5, 0.0, 1.0}).error().reason, "GRID_EXTENT");
  EXPECT_EQ(make_grid({5, 5, 1.0, nan}).error().reason, "GRID_EXTENT");
  EXPECT_EQ(make_jittered_grid({5, 5, 1.0, 2e4}, 1).error().reason, "GRID_EXTENT");
  EXPECT_EQ(make_grid({2, 2, 1e-6, 1e4}).error().reason, "MESH_DEGENERATE_TRIANGLE");
}

TEST(Import, TheZooHoldsEveryInvariant) {
  for (const test::ZooMesh& animal : test::zoo()) {
    SCOPED_TRACE(animal.name);
    const Result<TriangleMesh> built = import_mesh(animal.sheet);
    ASSERT_TRUE(built.ok()) << built.error().message;
    EXPECT_EQ(built->find_violation(), std::nullopt);
    EXPECT_EQ(built->num_pieces(), animal.pieces);
    EXPECT_EQ(built->num_boundary_loops(), animal.loops);
    EXPECT_EQ(built->num_vertices(), animal.sheet.rest.cols());
    for (TriangleId t = 0; t < built->num_solid_triangles(); ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_EQ(built->vertices(t)[k], animal.sheet.triangles(k, t));
    }
  }
}

TEST(Import, KeepsEarlierCutsAsLips) {
  const TriangleMesh mesh = test::must(import_mesh(test::slit_square()));
  EXPECT_EQ(mesh.point(1), mesh.point(2));
  EXPECT_TRUE(has_lock(mesh, 0, kLockCut));
  EXPECT_FALSE(has_lock(mesh, 0, kLockBorder));
  EXPECT_TRUE(has_lock(mesh, 1, kLockCut));
  EXPECT_TRUE(has_lock(mesh, 1, kLockBorder));
  EXPECT_FALSE(has_lock(mesh, 4, kLockCut));
  EXPECT_EQ(mesh.neighbour(0, 2), kNone);  // the lip
  EXPECT_EQ(mesh.welded_neighbour(0, 2), 4);
}

TEST(Import, KeepsRegions) {
  const TriangleMesh mesh = test::must(import_mesh(test::two_regions()));
  EXPECT_EQ(mesh.region(0), 0);
  EXPECT_EQ(mesh.region(2), 7);
  EXPECT_TRUE(mesh.is_fixed(1, 0));   // between the regions
  EXPECT_FALSE(mesh.is_fixed(0, 0));  // within one
}

TEST(Import, TurnsOverClockwiseComponents) {
  IndexedMesh sheet = test::two_components();
  for (const int t : {2, 3}) std::swap(sheet.triangles(0, t), sheet.triangles(1, t));
  const TriangleMesh mesh = test::must(import_mesh(sheet));
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  EXPECT_EQ(mesh.vertices(2), (std::array<VertexId, 3>{5, 6, 4}));
  sheet = test::two_components();
  std::swap(sheet.triangles(0, 3), sheet.triangles(1, 3));
  expect_refused(sheet, "MESH_INCONSISTENT_ORIENTATION", "triangles 2 and 3");
}

TEST(Import, RefusesBadArrays) {
  expect_refused(IndexedMesh{}, "MESH_EMPTY", "");
  IndexedMesh sheet = test::fan();
  sheet.rest(1, 3) = std::nan("");
  expect_refused(sheet, "MESH_NOT_FINITE", "vertex 3");
  sheet.rest(1, 3) = -INFINITY;
  expect_refused(sheet, "MESH_NOT_FINITE", "vertex 3");
  sheet.rest(1, 3) = 1.1e4;
  expect_refused(sheet, "MESH_OUT_OF_RANGE", "vertex 3");
  sheet = test::fan();
  sheet.triangles(1, 4) = 7;
  expect_refused(sheet, "MESH_INDEX", "triangle 4 names vertex 7");
  sheet.triangles(1, 4) = -1;
  expect_refused(sheet, "MESH_INDEX", "vertex -1");
  sheet = test::two_components();
  sheet.triangles.conservativeResize(Eigen::NoChange, 3);
  expect_refused(sheet, "MESH_UNUSED_VERTEX", "vertex 7");
  sheet = test::fan();
  sheet.regions = {0, 1};
  expect_refused(sheet, "MESH_REGIONS", "2 regions for 6");
  sheet.regions = {0, 1, 2, -3, 4, 5};
  expect_refused(sheet, "MESH_REGIONS", "-3");
  sheet = test::one_triangle();
  sheet.rest.conservativeResize(Eigen::NoChange, kMaxVertices + 1);
  expect_refused(sheet, "MESH_TOO_LARGE", "500000");
}

TEST(Import, RefusesDegenerateTriangles) {
  expect_refused(test::indexed({{0, 0}, {1, 1}, {2, 2}, {1, 0}}, {{0, 3, 1}, {0, 1, 2}}), "MESH_DEGENERATE_TRIANGLE",
                 "triangle 1");
  expect_refused(test::indexed({{0, 0}, {1, 0}, {0, 1}}, {{0, 1, 1}, {0, 1, 2}}), "MESH_DEGENERATE_TRIANGLE",
                 "triangle 0");
  expect_refused(test::indexed({{5, 5}, {5, 5}, {5, 5}}, {{0, 1, 2}}), "MESH_DEGENERATE_TRIANGLE", "");
}

TEST(Import, RefusesTrianglesTooFlatForTheirLength) {
  const auto flat = [](double ratio, double length) {
    return test::indexed({{0, 0}, {length, 0}, {0.3 * length, ratio * length}}, {{0, 1, 2}});
  };
  for (const double length : {1e-3, 1.0, 700.0}) {
    SCOPED_TRACE(length);
    expect_refused(flat(0.999 * kMinFlatness, length), "MESH_DEGENERATE_TRIANGLE", "merge");
    EXPECT_TRUE(import_mesh(flat(1.001 * kMinFlatness, length)).ok());
  }
  // Positive area on the lattice, but none in floating-point numbers.
  expect_refused(
      test::indexed({{0, 0}, {0.9132020097620708, 0.8346492473105291}, {0.8983662352101822, 0.8210896318797345}},
                    {{0, 1, 2}}),
      "MESH_DEGENERATE_TRIANGLE", "triangle 0");
  // Clockwise, and beside a good one.
  expect_refused(test::indexed({{0, 0}, {1, 0}, {0, 1}, {0.5, -1e-8}}, {{0, 2, 1}, {0, 1, 3}}),
                 "MESH_DEGENERATE_TRIANGLE", "triangle 1");
}

TEST(Import, RefusesNonManifoldSheets) {
  expect_refused(test::indexed({{0, 0}, {1, 0}, {0.5, 1}, {0.5, -1}, {0.5, 2}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
                 "MESH_NON_MANIFOLD_EDGE", "0, 1, 2");
  expect_refused(test::indexed({{0, 0}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}}, {{0, 1, 2}, {0, 3, 4}}),
                 "MESH_NON_MANIFOLD_VERTEX", "vertex 0");
}

TEST(Import, RefusesOverlapHoweverItComesAbout) {
  // Two components that cross.
  expect_refused(test::indexed({{0, 0}, {2, 0}, {0, 2}, {1, -1}, {1, 1.5}, {-1, 1}}, {{0, 1, 2}, {3, 4, 5}}),
                 "MESH_OVERLAP", "cross");
  // One inside the other.
  expect_refused(test::indexed({{0, 0}, {9, 0}, {0, 9}, {1, 1}, {2, 1}, {1, 2}}, {{0, 1, 2}, {3, 4, 5}}),
                 "MESH_OVERLAP", "triangles 0 and 1 overlap");
  // The same triangle twice, with vertices of its own.
  expect_refused(test::indexed({{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {0, 1}}, {{0, 1, 2}, {3, 4, 5}}),
                 "MESH_OVERLAP", "triangles 0 and 1");
  // A vertex inside a border edge of another triangle.
  expect_refused(test::indexed({{0, 0}, {2, 0}, {0, 2}, {1, 1}, {3, 1}, {3, 2}}, {{0, 1, 2}, {3, 4, 5}}),
                 "MESH_OVERLAP", "lies inside");
  // A spiral staircase: every triangle is counter-clockwise and every edge fine, but the last cover the first.
  IndexedMesh spiral;
  spiral.rest.resize(2, 18);
  spiral.triangles.resize(3, 16);
  for (int i = 0; i < 9; ++i) {
    const double angle = 0.9 * i;
    spiral.rest.col(2 * i) = (1.0 + 0.01 * i) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    spiral.rest.col(2 * i + 1) = (2.0 + 0.01 * i) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  for (int i = 0; i < 8; ++i) {
    spiral.triangles.col(2 * i) = Eigen::Vector3i(2 * i, 2 * i + 1, 2 * i + 3);
    spiral.triangles.col(2 * i + 1) = Eigen::Vector3i(2 * i, 2 * i + 3, 2 * i + 2);
  }
  expect_refused(spiral, "MESH_OVERLAP", "cross");
}

TEST(Import, WeldsWhatAnOpenedMeshExported) {
  TriangleMesh mesh = test::must(import_mesh(test::slit_square()));
  IndexedMesh again;
  again.rest.resize(2, mesh.num_vertices());
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) again.rest.col(v) = mesh.rest_position(v);
  again.triangles.resize(3, mesh.num_solid_triangles());
  for (TriangleId t = 0; t < mesh.num_solid_triangles(); ++t) {
    for (int k = 0; k < 3; ++k) again.triangles(k, t) = mesh.vertices(t)[k];
  }
  EXPECT_TRUE(test::must(import_mesh(again)) == mesh);
}

// Random triangles on a 4 x 4 lattice: refused for a reason, or sound and nowhere twice over the same place.
TEST(Import, RandomSoupIsRefusedOrCoversNoPlaceTwice) {
  SeededRandom random(6);
  int num_accepted = 0, num_overlaps = 0;
  for (int i = 0; i < 20000; ++i) {
    IndexedMesh soup;
    const auto num_triangles = static_cast<Eigen::Index>(1 + random.below(4));
    soup.rest.resize(2, 3 * num_triangles);
    soup.triangles.resize(3, num_triangles);
    for (Eigen::Index v = 0; v < soup.rest.cols(); ++v) {
      soup.rest.col(v) = Eigen::Vector2d(static_cast<double>(random.below(4)), static_cast<double>(random.below(4)));
      soup.triangles(v % 3, v / 3) = static_cast<std::int32_t>(v);
    }
    const Result<TriangleMesh> built = import_mesh(soup);
    if (!built.ok()) {
      ASSERT_FALSE(built.error().reason.empty());
      num_overlaps += built.error().reason == "MESH_OVERLAP";
      continue;
    }
    ++num_accepted;
    ASSERT_EQ(built->find_violation(), std::nullopt);
    for (int sample = 0; sample < 40; ++sample) {
      const Eigen::Vector2d share(random.uniform(), random.uniform());
      const Eigen::AlignedBox2d& box = built->bounding_box();
      const LatticePoint p = built->lattice().nearest(box.min() + share.cwiseProduct(box.sizes()));
      int num_over = 0;
      for (TriangleId t = 0; t < built->num_solid_triangles(); ++t) {
        const std::array<PointId, 3>& c = built->points(t);
        num_over += orient2d(built->at(c[0]), built->at(c[1]), p) > 0 &&
                    orient2d(built->at(c[1]), built->at(c[2]), p) > 0 &&
                    orient2d(built->at(c[2]), built->at(c[0]), p) > 0;
      }
      ASSERT_LE(num_over, 1);
    }
  }
  EXPECT_GT(num_accepted, 2000);
  EXPECT_GT(num_overlaps, 2000);
}

}  // namespace
}  // namespace kerf::mesh
