// Method::kElement: what it is by its definition, checked from outside.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/cut/calls.h"
#include "tests/support/cut_patterns.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

CutOptions by_element() {
  CutOptions options;
  options.method = Method::kElement;
  return options;
}

// The triangle of `sheet` that holds the middle of triangle t of `mesh`.
mesh::TriangleId element_of(const mesh::TriangleMesh& sheet, const mesh::TriangleMesh& mesh, mesh::TriangleId t) {
  const auto& p = mesh.points(t);
  const Vector2d middle = (mesh.point_position(p[0]) + mesh.point_position(p[1]) + mesh.point_position(p[2])) / 3.0;
  return sheet.locate(sheet.lattice().nearest(middle)).triangle;
}

TEST(CutElement, EdgesOfElementsStayAndNoVertexMoves) {
  for (const test::CutPattern& pattern : test::cut_patterns(1.0 / 49.0)) {
    SCOPED_TRACE(pattern.name);
    for (const mesh::TriangleMesh& sheet : {grid(50), jittered(50)}) {
      mesh::TriangleMesh mesh = sheet;
      const CutOutcome outcome = cut(mesh, {pattern.curves.front(), by_element(), {}});
      EXPECT_TRUE(outcome.edit.moved_vertices.empty());
      EXPECT_FALSE(outcome.report.refinement_stopped);
      // Every new triangle lies in one element: its corners are in that element too, up to rounding.
      for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
        if (!mesh.is_solid(t)) continue;
        const mesh::TriangleId element = element_of(sheet, mesh, t);
        for (const mesh::PointId p : mesh.points(t)) {
          for (int k = 0; k < 3; ++k) {
            const mesh::LatticePoint& a = sheet.at(sheet.points(element)[mesh::next_corner(k)]);
            const mesh::LatticePoint& b = sheet.at(sheet.points(element)[mesh::previous_corner(k)]);
            const auto height = static_cast<double>(mesh::doubled_area(a, b, mesh.at(p))) /
                                std::hypot(static_cast<double>(b.x - a.x), static_cast<double>(b.y - a.y));
            ASSERT_GT(height, -8.0) << "triangle " << t << " leaves its element";
          }
        }
      }
    }
  }
}

TEST(CutElement, NoTriangleIsIllShapedByBothRatios) {
  for (const test::CutPattern& pattern : test::cut_patterns(1.0 / 49.0)) {
    SCOPED_TRACE(pattern.name);
    mesh::TriangleMesh mesh = grid(50);
    const double element_area = 0.5 * mesh.base_edge_length() * mesh.base_edge_length();
    for (const Curve& curve : pattern.curves) {
      const CutOutcome outcome = cut(mesh, {curve, by_element(), {}});
      for (const mesh::TriangleId t : outcome.edit.rewritten_triangles) {
        if (!mesh.is_solid(t)) continue;
        std::array<double, 3> edges{};
        for (int k = 0; k < 3; ++k) {
          edges[static_cast<std::size_t>(k)] = (mesh.point_position(mesh.points(t)[mesh::next_corner(k)]) -
                                                mesh.point_position(mesh.points(t)[mesh::previous_corner(k)]))
                                                   .norm();
        }
        const auto [least, largest] = std::minmax_element(edges.begin(), edges.end());
        EXPECT_TRUE(*largest / *least <= 3.0 + 1e-9 || mesh.area(t) <= 0.03 * element_area * (1 + 1e-9));
      }
    }
  }
}

TEST(CutElement, LeavesWhatItsLimitsAllow) {
  const Curve flower = test::cut_patterns(1.0 / 49.0)[4].curves.front();
  std::vector<double> ratios;
  std::vector<int> triangles;
  for (const double limit : {std::numeric_limits<double>::infinity(), 6.0, 3.0, 2.0}) {
    CutOptions options = by_element();
    options.element_limits.edge_ratio = limit;
    mesh::TriangleMesh mesh = grid(50);
    const CutReport report = cut(mesh, {flower, options, {}}).report;
    ratios.push_back(report.quality.mean_edge_ratio);
    triangles.push_back(report.new_triangles);
  }
  EXPECT_TRUE(std::is_sorted(ratios.rbegin(), ratios.rend()));
  EXPECT_TRUE(std::is_sorted(triangles.begin(), triangles.end()));
  EXPECT_GT(ratios.front(), 2.0 * ratios.back());
  EXPECT_LT(2 * triangles.front(), triangles.back());
}

// A chord longer than the segment between the middles of the two edges it joins gets the point of largest curvature.
TEST(CutElement, AddsThePointOfLargestCurvatureToALongChord) {
  CutOptions loose = by_element();
  loose.tolerance = 0.5;
  const mesh::TriangleMesh sheet = grid(2);  // two triangles; the lower right one has its right angle at (1, 0)
  const auto lips = [&](const CubicBezier& curve) {
    mesh::TriangleMesh mesh = sheet;
    const CutOutcome outcome = cut(mesh, {curve, loose, {}});
    return outcome.report.new_lip_edges;
  };
  // From the bottom to the right edge, near the corner: the chord is 0.28 long, the segment between the middles 0.71.
  EXPECT_EQ(lips({{{0.8, -0.01}, {0.85, 0.12}, {0.9, 0.19}, {1.01, 0.2}}}), 1);
  // Farther out: 0.99.
  EXPECT_EQ(lips({{{0.3, -0.01}, {0.4, 0.3}, {0.7, 0.6}, {1.01, 0.7}}}), 2);
  // A straight one has no curvature.
  EXPECT_EQ(lips({{{0.29, -0.01}, {0.53, 0.23}, {0.77, 0.47}, {1.01, 0.71}}}), 1);
}

TEST(CutElement, IsDeterministic) {
  for (const Curve& curve : {s_curve(), Curve(Circle{{0.5, 0.5}, 0.2})}) {
    mesh::TriangleMesh mesh = grid(20);
    EXPECT_EQ(cut(mesh, {curve, by_element(), {}}).report.refinement_stopped, false);
    const mesh::TriangleMesh before = mesh;
    mesh::TriangleMesh again = grid(20);
    cut(again, {curve, by_element(), {}});
    EXPECT_TRUE(again == before);
  }
}

}  // namespace
}  // namespace kerf::cut
