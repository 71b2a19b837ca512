// Sheets bent far by forces, moments and their own weight, against independent references.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/bending_forces.h"
#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/statics/reactions.h"
#include "tests/accuracy/statics.h"

namespace kerf::accuracy {
namespace {

// Rest position of the middle of one of the triangles of a vertex.
Eigen::Vector2d middle_of_a_triangle_at(const mesh::TriangleMesh& mesh, int v) {
  const auto& corners = mesh.vertices(mesh.triangle_at(v));
  return (mesh.rest_position(corners[0]) + mesh.rest_position(corners[1]) + mesh.rest_position(corners[2])) / 3.0;
}

mesh::TriangleMesh polar_grid(int radial, int around, double inner, double outer) {
  mesh::IndexedMesh grid;
  grid.rest.resize(2, (radial + 1) * around);
  grid.triangles.resize(3, 2 * radial * around);
  int t = 0;
  for (int j = 0; j < around; ++j) {
    const double angle = 2.0 * std::numbers::pi * j / around;
    for (int i = 0; i <= radial; ++i) {
      const double r = inner + (outer - inner) * i / radial;
      // Exactly on the axis where the cut goes.
      grid.rest.col(j * (radial + 1) + i) << r * std::cos(angle), j == 0 ? 0.0 : r * std::sin(angle);
      if (i == radial) continue;
      const int a = j * (radial + 1) + i;
      const int d = (j + 1) % around * (radial + 1) + i;
      grid.triangles.col(t++) = Eigen::Vector3i(a, a + 1, d + 1);
      grid.triangles.col(t++) = Eigen::Vector3i(a, d + 1, d);
    }
  }
  return mesh::import_mesh(grid).value();
}

class HeavyElastica : public testing::TestWithParam<const char*> {};

TEST_P(HeavyElastica, SagsAsTheClosedForm) {
  const Reference reference(GetParam());
  int segments = 10;
  for (const char* const fineness : kMeshes) {
    Cantilever strip(reference, "b", segments, std::max(1, segments / 8));
    for (const std::vector<double>& row : reference.rows("heavy elastica")) {
      strip.loads.gravity = {0.0, 0.0, -row[1]};
      const int iterations = settle(strip.model, strip.loads, strip.x).iterations;
      EXPECT_LE(iterations, 15) << "from flat";
      const Eigen::Vector3d tip = strip.tip();
      std::printf("%s, %d segments, gravity %.2f: U %+.2f %%, sag %+.2f %%\n", GetParam(), segments, row[1],
                  100.0 * (-tip.x() / row[2] - 1.0), 100.0 * (-tip.z() / row[3] - 1.0));
      EXPECT_NEAR(-tip.x(), row[2], reference.tolerance(fineness) * row[2]) << fineness;
      EXPECT_NEAR(-tip.z(), row[3], reference.tolerance(fineness) * row[3]) << fineness;
    }
    segments *= 2;
  }
}

INSTANTIATE_TEST_SUITE_P(References, HeavyElastica, testing::Values("07f_heavy_elastica", "07g_heavy_elastica"),
                         [](const testing::TestParamInfo<const char*>& tested) {
                           return std::string(tested.param).substr(0, 3);
                         });

TEST(CantileverUnderEndShear, FollowsTheElastica) {
  const Reference reference("07a_cantilever_end_shear");
  constexpr double kForce = 4.0;  // N
  int segments = 10;
  for (const char* const fineness : kMeshes) {
    Cantilever strip(reference, "b", segments, std::max(1, segments / 10));
    double worst = 0.0;
    for (const std::vector<double>& row : reference.rows("elastica (inextensible)")) {
      const double share = kForce * row[0] / static_cast<double>(strip.end.size() - 1);
      for (const int v : strip.end) {
        strip.loads.external_forces(2, v) = v == strip.end.front() || v == strip.end.back() ? 0.5 * share : share;
      }
      settle(strip.model, strip.loads, strip.x);
      const Eigen::Vector3d tip = strip.tip();
      worst = std::max({worst, std::abs(-tip.x() / row[1] - 1.0), std::abs(tip.z() / row[2] - 1.0)});
      EXPECT_NEAR(-tip.x(), row[1], reference.tolerance(fineness) * row[1]) << fineness;
      EXPECT_NEAR(tip.z(), row[2], reference.tolerance(fineness) * row[2]) << fineness;
    }
    std::printf("end shear, %d segments: within %.2f %%\n", segments, 100.0 * worst);
    segments *= 2;
  }
}

// A ring of radial x around cells, its grid polar, slit along theta = 0 by Kerf's cutter, one lip clamped, the other
// lifted.
TEST(SlitAnnularPlate, LiftedAtOneLipOpensAsTheReference) {
  const Reference reference("07c_slit_annular_plate");
  const double inner = reference.geometry("Ri");
  const double outer = reference.geometry("Ro");
  constexpr double kForce = 0.8;  // N/m
  const std::array<std::array<int, 2>, 3> cells{{{6, 40}, {10, 80}, {20, 160}}};
  for (std::size_t m = 0; m < kMeshes.size(); ++m) {
    const auto [radial, around] = cells[m];
    mesh::TriangleMesh mesh = polar_grid(radial, around, inner, outer);
    const auto plan = cut::plan(mesh, {cut::Polyline{{{inner - 1.0, 0.0}, {outer + 1.0, 0.0}}}, {}, {}});
    ASSERT_TRUE(plan.ok());
    ASSERT_TRUE(cut::apply(mesh, *plan).ok());
    fem::Model model(mesh, reference.material());
    fem::Loads loads;
    loads.gravity.setZero();
    loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    linear::VertexField x(mesh.num_vertices());
    std::vector<fem::Clamp> clamps;
    std::vector<int> lip;  // the free one
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d X = mesh.rest_position(v);
      x.col(v) << X, 0.0;
      if (X.x() < 0.0 || std::abs(X.y()) > 1e-9) continue;
      if (middle_of_a_triangle_at(mesh, v).y() < 0.0) {
        lip.push_back(v);
        continue;
      }
      loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
      clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
    model.bend_by_angles(mesh);
    std::sort(lip.begin(), lip.end(),
              [&](int a, int b) { return mesh.rest_position(a).x() < mesh.rest_position(b).x(); });
    double worst = 0.0;
    for (const std::vector<double>& row : reference.rows("Sze-Liu-Lo table 4 (subset)")) {
      loads.external_forces.setZero();
      for (std::size_t i = 0; i + 1 < lip.size(); ++i) {
        const double length = mesh.rest_position(lip[i + 1]).x() - mesh.rest_position(lip[i]).x();
        loads.external_forces(2, lip[i]) += 0.5 * row[0] * kForce * length;
        loads.external_forces(2, lip[i + 1]) += 0.5 * row[0] * kForce * length;
      }
      settle(model, loads, x);
      const double w_inner = x(2, lip.front());
      const double w_outer = x(2, lip.back());
      worst = std::max({worst, std::abs(w_inner / row[1] - 1.0), std::abs(w_outer / row[2] - 1.0)});
      EXPECT_NEAR(w_inner, row[1], reference.tolerance(kMeshes[m]) * row[1]) << kMeshes[m];
      EXPECT_NEAR(w_outer, row[2], reference.tolerance(kMeshes[m]) * row[2]) << kMeshes[m];
    }
    std::printf("slit ring, %d x %d: within %.2f %%\n", radial, around, 100.0 * worst);
  }
}

// Hung from two corners that are nearer to each other than the sheet is wide; it bulges to +z.
TEST(Curtain, HangsInTheReferenceShape) {
  const Reference reference("11a_curtain");
  const double width = reference.geometry("W");
  const double height = reference.geometry("H");
  const double chord = width - reference.geometry("close");
  // An arc of that chord to begin with, the same all the way down.
  double phi = 1.0;
  for (int i = 0; i < 50; ++i) phi -= (std::sin(phi) - phi * chord / width) / (std::cos(phi) - chord / width);
  const double radius = 0.5 * width / phi;
  int cells = 12;
  for (const char* const fineness : kMeshes) {
    const mesh::TriangleMesh mesh = mapped_grid(
        cells, cells, [=](double a, double b) { return Eigen::Vector2d((a - 0.5) * width, (b - 1.0) * height); });
    fem::Model model(mesh, reference.material());
    model.bend_by_angles(mesh);
    fem::Loads loads;
    loads.gravity = {0.0, -9.81, 0.0};
    linear::VertexField x(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d X = mesh.rest_position(v);
      const double angle = X.x() / radius;
      x.col(v) << radius * std::sin(angle), X.y(), radius * (std::cos(angle) - std::cos(phi));
    }
    for (const int v : {cells * (cells + 1), cells * (cells + 1) + cells}) {
      const Eigen::Vector3d corner(std::copysign(0.5 * chord, mesh.rest_position(v).x()), 0.0, 0.0);
      loads.pins.push_back({v, corner, Eigen::Vector3d::Zero()});
    }
    const fem::EquilibriumStats stats = settle(model, loads, x);
    EXPECT_EQ(stats.shift, 0.0) << "stable";
    double worst = 0.0;
    double largest = 0.0;
    for (const nlohmann::json& row : reference.json().at("quantities").at(0).at("table").at("rows")) {
      const Eigen::Vector2d X(row[1].get<double>(), row[2].get<double>());
      const Eigen::Vector3d expected(row[3].get<double>(), row[4].get<double>(), row[5].get<double>());
      int at = 0;
      while ((mesh.rest_position(at) - X).norm() > 1e-9) ++at;
      const Eigen::Vector3d moved = x.col(at) - Eigen::Vector3d(X.x(), X.y(), 0.0);
      largest = std::max(largest, expected.norm());
      worst = std::max(worst, (moved - expected).norm());
    }
    std::printf("curtain, %d cells a side: displacements within %.2f %% of the largest\n", cells,
                100.0 * worst / largest);
    EXPECT_LE(worst, reference.tolerance(fineness) * largest) << fineness;
    cells *= 2;
  }
}

// A strip with rows of slits made by Kerf's cutter, pulled: stiff while it is flat, soft once it opens out of the
// plane.
TEST(Kirigami, PulledFollowsTheReferenceThroughItsTransition) {
  const Reference reference("13a_kirigami_ECE");
  const double width = reference.geometry("W");
  const double length = reference.geometry("L");
  const double spacing = reference.geometry("row_spacing");
  const double end = reference.geometry("end");
  const double thickness = reference.material().thickness;
  int cells = 4;                                             // a row
  for (const char* const fineness : {"coarse", "medium"}) {  // fine: 13a_kirigami_ECE among the scenes
    const int across = cells * static_cast<int>(std::lround(width / spacing));
    mesh::TriangleMesh mesh =
        mapped_grid(across, across, [=](double a, double b) { return Eigen::Vector2d((a - 0.5) * width, b * length); });
    std::vector<cut::Polyline> slits;
    const double half = 0.5 * reference.geometry("centre_slit");
    const double inner = 0.5 * width - reference.geometry("edge_slit");
    for (const double y : {end, end + 2.0 * spacing}) {
      slits.push_back({{{-width, y}, {-inner, y}}});
      slits.push_back({{{inner, y}, {width, y}}});
    }
    slits.push_back({{{-half, end + spacing}, {half, end + spacing}}});
    for (const cut::Polyline& slit : slits) {
      cut::CutRequest request{slit, {}, {}};
      request.options.tip_edge_length_m = spacing / cells / 8.0;
      request.options.tip_grading = 1.5;
      const auto plan = cut::plan(mesh, request);
      ASSERT_TRUE(plan.ok());
      ASSERT_TRUE(cut::apply(mesh, *plan).ok());
    }
    fem::Model model(mesh, reference.material());
    fem::Loads loads;
    loads.gravity.setZero();
    linear::VertexField x(mesh.num_vertices());
    std::vector<fem::Clamp> clamps;
    std::vector<std::size_t> top;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d X = mesh.rest_position(v);
      const double row = (X.y() - end) / spacing;
      const double bump = row > 0.0 && row < 2.0 ? std::sin(std::numbers::pi * row) : 0.0;
      x.col(v) << X, 0.1 * thickness * bump * (1.0 + 0.3 * X.x() / width);
      if (X.y() > 1e-9 && X.y() < length - 1e-9) continue;
      if (X.y() > 1e-9) top.push_back(loads.pins.size());
      loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
      clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
    model.bend_by_angles(mesh);
    linear::VertexField rest = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    rest.row(2) = x.row(2);
    linear::VertexField bend = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    fem::add_bending_forces(model.bending().rows(), rest, bend);
    loads.external_forces = -bend;
    std::vector<std::vector<double>> rows = reference.rows("force-displacement");
    std::reverse(rows.begin(), rows.end());
    const auto pull = [&](double by) {
      for (const std::size_t pin : top) loads.pins[pin].target.y() = length + by;
      settle(model, loads, x);
      linear::VertexField reactions;
      fem::find_reactions(model, loads, x, reactions);
      double force = 0.0;
      for (const std::size_t pin : top) force += reactions(1, loads.pins[pin].vertex);
      return force;
    };
    const double unpulled = pull(0.0);  // what the load alone makes the ends hold
    x.row(2) = 200.0 * rest.row(2);
    double worst = 0.0;
    for (const std::vector<double>& row : rows) {
      const double force = pull(row[0]) - unpulled;
      worst = std::max(worst, std::abs(force / row[1] - 1.0));
      EXPECT_NEAR(force, row[1], reference.tolerance(fineness) * row[1]) << fineness << ' ' << row[0];
    }
    std::printf("kirigami, %d vertices: force within %.2f %%\n", mesh.num_vertices(), 100.0 * worst);
    cells *= 2;
  }
}

// A sheet clamped at one edge, slit by Kerf's cutter from the middle to the free edge, one flap lifted.
TEST(HalfSlitFlap, LiftedOpensAsTheReference) {
  const Reference reference("14a_half_slit_flap");
  const double length = reference.geometry("L");
  const double width = reference.geometry("W");
  int across = 8;
  for (const char* const fineness : kMeshes) {
    const int along = across * 3 / 2;
    mesh::TriangleMesh mesh =
        mapped_grid(along, across, [=](double a, double b) { return Eigen::Vector2d(a * length, (b - 0.5) * width); });
    const double slit_y = reference.geometry("slit_y");
    const auto plan = cut::plan(
        mesh, {cut::Polyline{{{reference.geometry("slit_start_x"), slit_y}, {1.1 * length, slit_y}}}, {}, {}});
    ASSERT_TRUE(plan.ok());
    ASSERT_TRUE(cut::apply(mesh, *plan).ok());
    fem::Model model(mesh, reference.material());
    fem::Loads loads;
    loads.gravity.setZero();
    linear::VertexField x(mesh.num_vertices());
    std::vector<fem::Clamp> clamps;
    std::vector<int> flap_end;
    std::map<std::string, int> points;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d X = mesh.rest_position(v);
      x.col(v) << X, 0.0;
      if (X.x() < 1e-9) {
        loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
        clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
      }
      if (X.x() < length - 1e-9) continue;
      std::vector<mesh::TriangleId> fan;
      mesh.triangles_around(v, fan);
      const auto& corners = mesh.vertices(fan.front());
      const double middle =
          (mesh.rest_position(corners[0]) + mesh.rest_position(corners[1]) + mesh.rest_position(corners[2])).y() / 3.0;
      if (middle > slit_y) flap_end.push_back(v);
      const std::string side = middle > slit_y ? "upper_" : "lower_";
      if (std::abs(X.y() - slit_y) < 1e-9) points[side + "slit_lip"] = v;
      if (std::abs(X.y()) > 0.5 * width - 1e-9) points[side + "outer_corner"] = v;
    }
    model.set_clamps(mesh, clamps);
    model.bend_by_angles(mesh);
    std::sort(flap_end.begin(), flap_end.end(),
              [&](int a, int b) { return mesh.rest_position(a).y() < mesh.rest_position(b).y(); });
    const linear::VertexField rest = x;
    constexpr double kForce = 0.4;  // N
    double worst = 0.0;
    double largest = 0.0;
    double share = 0.0;
    const nlohmann::json& table = reference.json().at("quantities").at(0).at("table").at("rows");
    for (const nlohmann::json& row : table) {
      if (row[0].get<double>() != share) {
        share = row[0].get<double>();
        loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
        const double end = mesh.rest_position(flap_end.back()).y() - slit_y;
        for (std::size_t i = 0; i + 1 < flap_end.size(); ++i) {
          const double part =
              (mesh.rest_position(flap_end[i + 1]).y() - mesh.rest_position(flap_end[i]).y()) / end * share * kForce;
          loads.external_forces(2, flap_end[i]) += 0.5 * part;
          loads.external_forces(2, flap_end[i + 1]) += 0.5 * part;
        }
        settle(model, loads, x);
      }
      const int v = points.at(row[1].get<std::string>());
      const Eigen::Vector3d expected(row[2].get<double>(), row[3].get<double>(), row[4].get<double>());
      largest = std::max(largest, expected.norm());
      worst = std::max(worst, (x.col(v) - rest.col(v) - expected).norm());
    }
    std::printf("flap, %d across: displacements within %.2f %% of the largest\n", across, 100.0 * worst / largest);
    EXPECT_LE(worst, reference.tolerance(fineness) * largest) << fineness;
    across *= 2;
  }
}

// Moments along the end of a cantilever, N m/m.
std::vector<fem::EdgeMoment> end_moments(const Cantilever& strip, double per_length) {
  std::vector<fem::EdgeMoment> moments;
  for (mesh::TriangleId slot = 0; slot < strip.mesh.num_triangle_slots(); ++slot) {
    for (int k = 0; strip.mesh.is_solid(slot) && k < 3; ++k) {
      const auto& corners = strip.mesh.vertices(slot);
      const auto is_at_end = [&](int i) {
        const mesh::VertexId v = corners[static_cast<std::size_t>(i % 3)];
        return std::binary_search(strip.end.begin(), strip.end.end(), v);
      };
      if (is_at_end(k + 1) && is_at_end(k + 2)) {
        moments.push_back(strip.model.edge_moment(strip.mesh, slot, k, per_length));
      }
    }
  }
  return moments;
}

TEST(CantileverUnderEndMoment, RollsUpToAFullCircle) {
  const Reference reference("07b_cantilever_end_moment");
  constexpr double kMoment = 50.0 * std::numbers::pi / 3.0;  // N m, over a width of 1 m
  const double length = reference.geometry("L");
  int segments = 12;
  for (const char* const fineness : kMeshes) {
    Cantilever strip(reference, "b", segments, std::max(1, segments / 12));
    double worst = 0.0;
    int iterations = 0;
    for (const std::vector<double>& row : reference.rows("exact circle")) {
      strip.loads.edge_moments = end_moments(strip, row[0] * kMoment);
      ASSERT_FALSE(strip.loads.edge_moments.empty());
      iterations += settle(strip.model, strip.loads, strip.x).iterations;
      const Eigen::Vector3d tip = strip.tip();
      worst = std::max({worst, std::abs(-tip.x() - row[1]) / length, std::abs(tip.z() - row[2]) / length});
      EXPECT_NEAR(-tip.x(), row[1], reference.tolerance(fineness) * length) << fineness;
      EXPECT_NEAR(tip.z(), row[2], reference.tolerance(fineness) * length) << fineness;
    }
    const double energy =
        strip.model.bending().energy(strip.model.element_blocks(), strip.x) + fem::edge_moment_energy(strip.loads);
    const double expected = reference.value("bending energy at full circle");
    std::printf("end moment, %d segments: tip within %.2f %% of the length, energy %+.2f %%, %d iterations\n", segments,
                100.0 * worst, 100.0 * (energy / expected - 1.0), iterations);
    EXPECT_NEAR(energy, expected, reference.tolerance(fineness) * expected) << fineness;
    segments *= 2;
  }
}

}  // namespace
}  // namespace kerf::accuracy
