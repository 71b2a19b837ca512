// Material coordinates made for surfaces in space, and the import of such surfaces.
#include "server/core/mesh/build/flattening.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "server/core/mesh/build/mesh_import.h"
#include "tests/mesh/measures.h"
#include "tests/support/shells.h"

namespace kerf::mesh {
namespace {

double surface_area(const IndexedMesh& sheet) {
  double area = 0.0;
  for (Eigen::Index t = 0; t < sheet.triangles.cols(); ++t) {
    const Eigen::Vector3d a = sheet.surface.col(sheet.triangles(0, t));
    const Eigen::Vector3d b = sheet.surface.col(sheet.triangles(1, t));
    const Eigen::Vector3d c = sheet.surface.col(sheet.triangles(2, t));
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

double chart_area(const IndexedMesh& sheet, const Eigen::Matrix2Xd& at) {
  double area = 0.0;
  for (Eigen::Index t = 0; t < sheet.triangles.cols(); ++t) {
    Eigen::Matrix2d edges;
    edges << at.col(sheet.triangles(1, t)) - at.col(sheet.triangles(0, t)),
        at.col(sheet.triangles(2, t)) - at.col(sheet.triangles(0, t));
    area += 0.5 * edges.determinant();
  }
  return area;
}

// Largest ratio of the singular values of a triangle's map from the chart.
double worst_distortion(const TriangleMesh& mesh) {
  double worst = 1.0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(mesh.facet(t)->stretch());
    worst = std::max(worst, svd.singularValues()[0] / svd.singularValues()[1]);
  }
  return worst;
}

// A tube about the z axis: num cells around, num cells high, radius 1 m, height 2 m; closed at the top or open.
IndexedMesh tube(int num, bool closed_on_top = false, bool closed_below = false) {
  IndexedMesh sheet;
  const int rings = num + 1;
  sheet.surface.resize(3, num * rings + 2);
  int top = num * rings;
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i < num; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / num;
      sheet.surface.col(j * num + i) = Eigen::Vector3d(std::cos(angle), std::sin(angle), 2.0 * j / num);
    }
  }
  std::vector<Eigen::Vector3i> triangles;
  for (int j = 0; j < num; ++j) {
    for (int i = 0; i < num; ++i) {
      const int next = (i + 1) % num;
      triangles.emplace_back(j * num + i, j * num + next, (j + 1) * num + next);
      triangles.emplace_back(j * num + i, (j + 1) * num + next, (j + 1) * num + i);
    }
  }
  if (closed_on_top) {
    sheet.surface.col(top) = Eigen::Vector3d(0.0, 0.0, 2.5);
    for (int i = 0; i < num; ++i) triangles.emplace_back(num * num + i, num * num + (i + 1) % num, top);
    ++top;
  }
  if (closed_below) {
    sheet.surface.col(top) = Eigen::Vector3d(0.0, 0.0, -0.5);
    for (int i = 0; i < num; ++i) triangles.emplace_back((i + 1) % num, i, top);
    ++top;
  }
  sheet.surface.conservativeResize(Eigen::NoChange, top);
  sheet.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t t = 0; t < triangles.size(); ++t) sheet.triangles.col(static_cast<Eigen::Index>(t)) = triangles[t];
  return sheet;
}

std::string refusal(const IndexedMesh& sheet) {
  const Result<TriangleMesh> made = import_mesh(sheet);
  return made.ok() ? "accepted" : made.error().reason + " " + made.error().field;
}

TEST(Flattening, UnrollsWhatIsRolledAndKeepsTheArea) {
  const IndexedMesh sheet = test::rolled_square(13, 0.4);
  const Eigen::Matrix2Xd made = flatten(sheet.surface, sheet.triangles, Flattening::kConformal).value();
  EXPECT_NEAR(chart_area(sheet, made), surface_area(sheet), 1e-12);
  // Distances are those along the chords, about half a per cent shorter than along the arcs.
  for (Eigen::Index v = 0; v < made.cols(); ++v) {
    for (const Eigen::Index w : {Eigen::Index{0}, Eigen::Index{12}, made.cols() - 1}) {
      EXPECT_NEAR((made.col(v) - made.col(w)).norm(), (sheet.rest.col(v) - sheet.rest.col(w)).norm(), 0.01);
    }
  }
}

TEST(Flattening, LiesAsItsProjectionDoes) {
  const IndexedMesh sheet = test::dome(11, 0.2);  // hardly curved
  for (const Flattening method : {Flattening::kConformal, Flattening::kConvex}) {
    const Eigen::Matrix2Xd made = flatten(sheet.surface, sheet.triangles, method).value();
    EXPECT_NEAR(chart_area(sheet, made), surface_area(sheet), 1e-12);
    if (method == Flattening::kConvex) continue;
    EXPECT_LT((made - sheet.surface.topRows<2>()).colwise().norm().maxCoeff(), 0.002);
  }
}

TEST(Flattening, KeepsAnglesOfADome) {
  IndexedMesh sheet = test::dome(21, 1.2);
  const TriangleMesh given = test::must(import_mesh(sheet));
  sheet.rest.resize(2, 0);
  const TriangleMesh made = test::must(import_mesh(sheet));
  EXPECT_TRUE(made.is_curved());
  EXPECT_EQ(made.find_violation(), std::nullopt);
  EXPECT_GT(worst_distortion(given), 1.7);
  EXPECT_LT(worst_distortion(made), 1.15);
  EXPECT_NEAR(total_area(made), surface_area(sheet), 1e-12);
  EXPECT_NEAR(total_area(given), surface_area(sheet), 1e-12);
}

// A tube has no conformal map that does not overlap with a free border: it goes into a ring.
TEST(Flattening, PutsATubeIntoARing) {
  for (const bool is_closed : {false, true}) {
    const IndexedMesh sheet = tube(12, is_closed);
    const TriangleMesh mesh = test::must(import_mesh(sheet));
    EXPECT_EQ(mesh.num_boundary_loops(), is_closed ? 1 : 2);
    EXPECT_EQ(mesh.num_pieces(), 1);
    EXPECT_EQ(mesh.find_violation(), std::nullopt);
    EXPECT_NEAR(total_area(mesh), surface_area(sheet), 1e-12 * surface_area(sheet));
  }
}

TEST(Flattening, ComponentsLieSideBySide) {
  const IndexedMesh one = test::dome(6, 1.0);
  const Eigen::Index n = one.surface.cols();
  IndexedMesh two;
  two.surface.resize(3, 2 * n);
  two.surface << one.surface, one.surface;
  two.triangles.resize(3, 2 * one.triangles.cols());
  two.triangles << one.triangles, (one.triangles.array() + static_cast<int>(n)).matrix();
  const TriangleMesh mesh = test::must(import_mesh(two));
  EXPECT_EQ(mesh.num_pieces(), 2);
  EXPECT_NEAR(total_area(mesh), 2.0 * surface_area(one), 1e-12);
}

TEST(Facets, FlatPartsAreOneFacetWhereverTheyLie) {
  const TriangleMesh mesh = test::must(import_mesh(test::creased_sheet(9)));
  ASSERT_TRUE(mesh.is_curved());
  EXPECT_EQ(mesh.data().surface->facets.size(), 2U);
  // Along the crease, and only there, flips are out of the question.
  int fixed = 0;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (mesh.is_solid(t) && mesh.neighbour(t, k) != kNone && mesh.is_fixed(t, k)) ++fixed;
    }
  }
  EXPECT_EQ(fixed, 2 * 8);
}

TEST(Facets, RegionsKeepTheirLabels) {
  IndexedMesh sheet = test::rolled_square(4, 0.4);
  for (Eigen::Index t = 0; t < sheet.triangles.cols(); ++t) sheet.regions.push_back(static_cast<int>(t % 3));
  const TriangleMesh mesh = test::must(import_mesh(sheet));
  for (TriangleId t = 0; t < mesh.num_solid_triangles(); ++t) EXPECT_EQ(mesh.region(t), t % 3);
}

TEST(Facets, TheSurfaceCountsForEqualityAndHash) {
  IndexedMesh sheet = test::dome(5, 1.0);
  const TriangleMesh mesh = test::must(import_mesh(sheet));
  EXPECT_EQ(mesh, test::must(import_mesh(sheet)));
  sheet.surface(2, 7) += 1e-6;
  const TriangleMesh other = test::must(import_mesh(sheet));
  EXPECT_FALSE(mesh == other);
  EXPECT_NE(mesh.state_hash(), other.state_hash());
}

TEST(Flattening, RefusesWhatHasNoBorderOrAHandleAndWhatIsNoSurface) {
  EXPECT_EQ(refusal(tube(8, true, true)), "MESH_NOT_FLATTENABLE surface");
  // A torus with a hole: handles, and a border.
  IndexedMesh torus;
  constexpr int kNum = 8;
  torus.surface.resize(3, kNum * kNum);
  for (int j = 0; j < kNum; ++j) {
    for (int i = 0; i < kNum; ++i) {
      const double a = 2.0 * std::numbers::pi * i / kNum, b = 2.0 * std::numbers::pi * j / kNum;
      torus.surface.col(j * kNum + i) =
          Eigen::Vector3d((2.0 + std::cos(b)) * std::cos(a), (2.0 + std::cos(b)) * std::sin(a), std::sin(b));
    }
  }
  torus.triangles.resize(3, 2 * kNum * kNum - 1);
  for (int t = 0; t < torus.triangles.cols(); ++t) {
    const int i = t / 2 % kNum, j = t / 2 / kNum, next = (i + 1) % kNum, above = (j + 1) % kNum;
    torus.triangles.col(t) = t % 2 == 0 ? Eigen::Vector3i(j * kNum + i, j * kNum + next, above * kNum + next)
                                        : Eigen::Vector3i(j * kNum + i, above * kNum + next, above * kNum + i);
  }
  EXPECT_EQ(refusal(torus), "MESH_NOT_FLATTENABLE surface");
  IndexedMesh folded = test::dome(4, 1.0);
  folded.rest.resize(2, 0);
  std::swap(folded.triangles(0, 3), folded.triangles(1, 3));
  EXPECT_EQ(refusal(folded), "MESH_INCONSISTENT_ORIENTATION surface");
  IndexedMesh line = test::dome(4, 1.0);
  line.rest.resize(2, 0);
  line.surface.col(line.triangles(0, 0)) = line.surface.col(line.triangles(1, 0));
  EXPECT_EQ(refusal(line), "MESH_DEGENERATE_TRIANGLE surface");
}

TEST(Facets, RefusesSurfacesThatDoNotFitTheirSheet) {
  IndexedMesh sheet = test::dome(4, 1.0);
  sheet.surface.conservativeResize(Eigen::NoChange, 15);
  EXPECT_EQ(refusal(sheet), "MESH_SURFACE surface");
  sheet = test::dome(4, 1.0);
  sheet.surface(1, 3) = std::nan("");
  EXPECT_EQ(refusal(sheet), "MESH_OUT_OF_RANGE surface");
  sheet.surface(1, 3) = std::nextafter(kMaxRestCoordinate, 2.0 * kMaxRestCoordinate);
  EXPECT_EQ(refusal(sheet), "MESH_OUT_OF_RANGE surface");
  sheet = test::dome(4, 1.0);
  sheet.surface.col(5) = sheet.surface.col(6);  // a triangle without area, though not in the chart
  EXPECT_EQ(refusal(sheet), "MESH_DEGENERATE_TRIANGLE surface");
}

}  // namespace
}  // namespace kerf::mesh
