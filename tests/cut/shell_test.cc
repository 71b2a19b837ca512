// Cuts of sheets whose rest shape is curved.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "server/core/cut/cut.h"
#include "tests/cut/calls.h"
#include "tests/support/shells.h"

namespace kerf::cut {
namespace {

struct Shell {
  std::string name;
  mesh::TriangleMesh mesh;
  int most_per_crossed;
};

std::vector<Shell> shells() {
  std::vector<Shell> made;
  // New triangles a crossed one: measured, and a fifth more.
  const auto add = [&](const std::string& name, mesh::IndexedMesh sheet, bool with_chart, int most_per_crossed) {
    if (!with_chart) sheet.rest.resize(2, 0);
    made.push_back({name + (with_chart ? "" : ", made chart"), test::must(mesh::import_mesh(sheet)), most_per_crossed});
  };
  add("rolled", test::rolled_square(21, 0.4), true, 16);
  add("rolled jittered", test::rolled_square(21, 0.4, true), true, 25);
  add("rolled", test::rolled_square(21, 0.4), false, 16);
  add("creased", test::creased_sheet(21), true, 6);
  add("dome", test::dome(21, 1.2), true, 36);
  add("dome", test::dome(21, 1.2), false, 76);
  add("jittered dome", test::dome(21, 1.2, true), false, 28);
  return made;
}

double area_of(const mesh::TriangleMesh& mesh) {
  double sum = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) sum += mesh.area(t);
  }
  return sum;
}

// The position of a vertex on the surface must not depend on the triangle used.
double widest_tear(const mesh::TriangleMesh& mesh) {
  double widest = 0.0;
  std::vector<mesh::TriangleId> ring;
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    mesh.triangles_around(v, ring);
    for (const mesh::TriangleId t : ring) {
      const Eigen::Vector3d first = mesh.facet(ring.front())->at(mesh.rest_position(v));
      widest = std::max(widest, (mesh.facet(t)->at(mesh.rest_position(v)) - first).norm());
    }
  }
  return widest;
}

// Returns the middle of the sheet in its chart.
Eigen::Vector2d middle(const mesh::TriangleMesh& mesh) {
  return mesh.bounding_box().center();
}

Curve s_curve_over(const mesh::TriangleMesh& mesh) {
  const Eigen::Vector2d c = middle(mesh);
  const Eigen::Vector2d size = mesh.bounding_box().sizes();
  return CubicBezier{
      {c + Eigen::Vector2d(-0.6 * size.x(), -0.2 * size.y()), c + Eigen::Vector2d(0.3 * size.x(), -0.5 * size.y()),
       c + Eigen::Vector2d(-0.3 * size.x(), 0.5 * size.y()), c + Eigen::Vector2d(0.6 * size.x(), 0.2 * size.y())}};
}

TEST(CutShell, KeepsTheSurfaceAndItsArea) {
  for (const Shell& shell : shells()) {
    SCOPED_TRACE(shell.name);
    mesh::TriangleMesh mesh = shell.mesh;
    const double area = area_of(mesh);
    const double size = mesh.bounding_box().sizes().maxCoeff();
    const CutOutcome first = cut(mesh, {s_curve_over(mesh), {}, {}});
    EXPECT_EQ(first.status, CutStatus::kApplied);
    EXPECT_EQ(first.report.pieces, 2);
    const CutOutcome second = cut(mesh, {Ellipse{middle(mesh), {0.2 * size, 0.15 * size}, 0.3}, {}, {}});
    EXPECT_EQ(second.status, CutStatus::kApplied);
    EXPECT_EQ(second.report.pieces, 4);
    EXPECT_NEAR(area_of(mesh), area, 1e-12 * area);
    EXPECT_LT(widest_tear(mesh), 1e-11);
    EXPECT_FALSE(first.report.refinement_stopped);
    EXPECT_EQ(first.report.quality.triangles_below_contract, 0);
    EXPECT_EQ(second.report.quality.triangles_below_contract, 0);
    EXPECT_LE(first.report.new_triangles, shell.most_per_crossed * first.report.crossed_triangles);
  }
}

// Seen from above, without perspective, 400 pixels a metre: a circle in the picture cuts out what is seen in it.
TEST(CutShell, IsCutAsItIsSeen) {
  mesh::IndexedMesh sheet = test::dome(21, 1.2);
  sheet.rest.resize(2, 0);
  mesh::TriangleMesh mesh = test::must(mesh::import_mesh(sheet));
  const double area = area_of(mesh);
  linear::VertexField positions(mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) positions.col(v) = sheet.surface.col(v);
  View above;
  above.view(2, 3) = -5.0;
  above.projection(2, 2) = -0.1;
  above.width_px = above.height_px = 800.0;
  constexpr double kRadius = 0.3;  // m
  CutRequest request{Circle{{400.0 + 400.0 * 0.03, 400.0 - 400.0 * 0.02}, 400.0 * kRadius}, {}, {}, above, &positions};
  const Result<CutPlan> planned = plan(mesh, request);
  ASSERT_TRUE(planned.ok()) << planned.error().message;
  const Result<CutOutcome> outcome = apply(mesh, *planned);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome->report.pieces, 2);
  EXPECT_EQ(mesh.find_violation(), std::nullopt);
  EXPECT_NEAR(area_of(mesh), area, 1e-12 * area);
  double least = 1.0, most = 0.0;  // of the distances of the lips from the circle's centre, as they are seen
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (!mesh.is_solid(t) || (mesh.locks(t, k) & mesh::kLockCut) == 0) continue;
      const mesh::VertexId v = mesh.vertices(t)[static_cast<std::size_t>(mesh::next_corner(k))];
      const Eigen::Vector3d at = mesh.facet(t)->at(mesh.rest_position(v));
      const double distance = (at.head<2>() - Eigen::Vector2d(0.03, 0.02)).norm();
      least = std::min(least, distance);
      most = std::max(most, distance);
    }
  }
  EXPECT_NEAR(least, kRadius, 0.02 * mesh.base_edge_length());
  EXPECT_NEAR(most, kRadius, 0.02 * mesh.base_edge_length());
}

}  // namespace
}  // namespace kerf::cut
