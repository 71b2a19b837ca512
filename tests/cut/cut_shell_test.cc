// Cuts of sheets whose rest shape is curved.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "server/cut/cut.h"
#include "tests/cut/cut_calls.h"
#include "tests/support/shells.h"

namespace kerf::cut {
namespace {

struct Shell {
  std::string name;
  mesh::TriangleMesh mesh;
};

std::vector<Shell> shells() {
  std::vector<Shell> made;
  const auto add = [&](const std::string& name, mesh::IndexedMesh sheet, bool with_chart) {
    if (!with_chart) sheet.rest.resize(2, 0);
    made.push_back({name + (with_chart ? "" : ", made chart"), test::must(mesh::import_mesh(sheet))});
  };
  add("rolled", test::rolled_square(21, 0.4), true);
  add("rolled jittered", test::rolled_square(21, 0.4, true), true);
  add("rolled", test::rolled_square(21, 0.4), false);
  add("creased", test::creased_sheet(21), true);
  add("dome", test::dome(21, 1.2), true);
  add("dome", test::dome(21, 1.2), false);
  add("jittered dome", test::dome(21, 1.2, true), false);
  return made;
}

double area_of(const mesh::TriangleMesh& mesh) {
  double sum = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (mesh.is_solid(t)) sum += mesh.area(t);
  }
  return sum;
}

// Where a vertex lies on the surface must not depend on the triangle that is asked.
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

// Where the middle of the sheet lies in its chart.
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
    printf("%-24s crossed %d new %d angle %.2f below %d contract %d min h %.4f\n", shell.name.c_str(),
           first.report.crossed_triangles, first.report.new_triangles, first.report.quality.min_angle_deg,
           first.report.quality.triangles_below_angle, first.report.quality.triangles_below_contract,
           first.report.quality.min_height_m / mesh.base_edge_length());
  }
}

}  // namespace
}  // namespace kerf::cut
