// Slits made by Kerf's own cutter, with edges graded toward their tips: how far they open under tension.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"
#include "tests/accuracy/reference.h"

namespace kerf::accuracy {
namespace {

using Eigen::Vector2d;

constexpr double kTraction = 1000.0;  // Pa

struct Slit {
  cut::Curve curve;
  double half_length = 0.0;  // m; of an edge slit the whole
  // Maps a point on it to the coordinate along it (m) and the unit normal.
  std::function<std::pair<double, Vector2d>(const Vector2d&)> frame;
};

Slit line(const Vector2d& from, const Vector2d& to, bool from_mouth) {
  const Vector2d along = (to - from).normalized();
  const Vector2d origin = from_mouth ? from : Vector2d(0.5 * (from + to));
  Slit slit;
  // A slit from the border begins beyond it.
  slit.curve = cut::Polyline{{from_mouth ? Vector2d(from - 0.01 * along) : from, to}};
  slit.half_length = (from_mouth ? 1.0 : 0.5) * (to - from).norm();
  slit.frame = [=](const Vector2d& at) {
    return std::pair<double, Vector2d>(along.dot(at - origin), {-along.y(), along.x()});
  };
  return slit;
}

Slit arc(const Vector2d& centre, double radius, double from_deg, double to_deg) {
  const auto at = [&](double degrees) {
    const double angle = degrees * std::numbers::pi / 180.0;
    return Vector2d(centre + radius * Vector2d(std::cos(angle), std::sin(angle)));
  };
  Slit slit;
  cut::Path path;
  cut::ArcTo bow;
  bow.end = at(from_deg);
  bow.semi_axes = {radius, radius};
  bow.counter_clockwise = false;
  path.subpaths.push_back({at(to_deg), {bow}, false});
  slit.curve = path;
  slit.half_length = 0.5 * radius * (to_deg - from_deg) * std::numbers::pi / 180.0;
  const double middle = 0.5 * (from_deg + to_deg) * std::numbers::pi / 180.0;
  slit.frame = [=](const Vector2d& point) {
    const Vector2d out = (point - centre).normalized();
    return std::pair<double, Vector2d>(radius * (middle - std::atan2(out.y(), out.x())), out);
  };
  return slit;
}

Slit slit_of(const Reference& reference) {
  const nlohmann::json& slit = reference.json().at("geometry").at("slit");
  const auto point = [&](const char* name) {
    const auto at = slit.at(name).get<std::array<double, 2>>();
    return Vector2d(at[0], at[1]);
  };
  if (slit.at("kind") == "line") return line(point("p0"), point("p1"), slit.contains("mouth0"));
  return arc(point("centre"), slit.at("radius").get<double>(), slit.at("angle_from_deg").get<double>(),
             slit.at("angle_to_deg").get<double>());
}

struct Opening {
  double s = 0.0, normal = 0.0, tangential = 0.0;  // m
};

// Returns the openings along the slit, each of vertices that were one point before it opened.
std::vector<Opening> openings(const mesh::TriangleMesh& mesh, const Slit& slit, const linear::VertexField& x) {
  std::map<std::pair<double, double>, std::vector<int>> at;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const Vector2d X = mesh.rest_position(v);
    at[{X.x(), X.y()}].push_back(v);
  }
  std::vector<Opening> found;
  for (const auto& [place, vertices] : at) {
    if (vertices.size() != 2) continue;
    const Vector2d X(place.first, place.second);
    const auto [s, normal] = slit.frame(X);
    // Which of the two is on the side of the normal: where the triangles around it are.
    const auto side = [&, n = normal](int v) {
      double sum = 0.0;
      std::vector<mesh::TriangleId> fan;
      mesh.triangles_around(v, fan);
      for (const mesh::TriangleId t : fan) {
        for (const int w : mesh.vertices(t)) sum += n.dot(mesh.rest_position(w) - X);
      }
      return sum;
    };
    const bool first_is_above = side(vertices[0]) > side(vertices[1]);
    const Eigen::Vector3d gap = (first_is_above ? 1.0 : -1.0) * (x.col(vertices[0]) - x.col(vertices[1]));
    const Vector2d along(normal.y(), -normal.x());
    found.push_back({s, normal.dot(gap.head<2>()), along.dot(gap.head<2>())});
  }
  std::sort(found.begin(), found.end(), [](const Opening& a, const Opening& b) { return a.s < b.s; });
  return found;
}

Opening at(const std::vector<Opening>& line, double s) {
  const auto above = std::lower_bound(line.begin(), line.end(), s, [](const Opening& o, double v) { return o.s < v; });
  if (above == line.end()) return line.back();
  if (above == line.begin()) return line.front();
  const Opening& a = *(above - 1);
  const Opening& b = *above;
  const double t = (s - a.s) / (b.s - a.s);
  return {s, a.normal + t * (b.normal - a.normal), a.tangential + t * (b.tangential - a.tangential)};
}

class SlitUnderTension : public testing::TestWithParam<const char*> {};

TEST_P(SlitUnderTension, OpensAsTheReferenceWithEdgesGradedTowardItsTips) {
  const Reference reference(GetParam());
  const double width = reference.geometry("width");
  const double length = reference.geometry("length");
  const Slit slit = slit_of(reference);
  // Edges of a fifth of the slit's half length, an even number of them across: the middle of the bottom is a vertex.
  const int columns = 2 * static_cast<int>(std::ceil(0.5 * width / (0.2 * slit.half_length)));
  const int rows = static_cast<int>(std::lround(columns * length / width));
  mesh::IndexedMesh grid;
  const mesh::TriangleMesh unit = mesh::make_grid({columns + 1, rows + 1, width, length}).value();
  grid.rest.resize(2, unit.num_vertices());
  for (int v = 0; v < unit.num_vertices(); ++v) {
    grid.rest.col(v) = unit.rest_position(v) - 0.5 * Vector2d(width, length);
  }
  grid.triangles.resize(3, unit.num_triangle_slots());
  int count = 0;
  for (int t = 0; t < unit.num_triangle_slots(); ++t) {
    if (!unit.is_solid(t)) continue;
    for (int k = 0; k < 3; ++k) grid.triangles(k, count) = unit.vertices(t)[static_cast<std::size_t>(k)];
    ++count;
  }
  grid.triangles.conservativeResize(3, count);
  mesh::TriangleMesh mesh = mesh::import_mesh(grid).value();
  cut::CutRequest request{slit.curve, {}, {}};
  request.options.tip_edge_length_m = 0.01 * slit.half_length;
  request.options.tip_grading = 1.1;
  request.options.tolerance_m = 1e-4 * slit.half_length;
  const auto plan = cut::plan(mesh, request);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  const auto cut = cut::apply(mesh, *plan);
  ASSERT_TRUE(cut.ok()) << cut.error().message;

  fem::Material material = reference.material();
  // Bending resists second derivatives within the plane too; the reference is plane stress alone.
  material.bending_scale = 0.0;
  const fem::Model model(mesh, material);
  fem::Loads loads;
  loads.gravity.setZero();
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  linear::VertexField x(mesh.num_vertices());
  std::vector<int> top;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const Vector2d X = mesh.rest_position(v);
    x.col(v) << X, 0.0;
    const bool on_bottom = X.y() < -0.5 * length + 1e-9;
    const bool in_middle = on_bottom && std::abs(X.x()) < 1e-9;
    loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero(), {in_middle, on_bottom, true}});
    if (X.y() > 0.5 * length - 1e-9) top.push_back(v);
  }
  std::sort(top.begin(), top.end(),
            [&](int a, int b) { return mesh.rest_position(a).x() < mesh.rest_position(b).x(); });
  const double per_length = kTraction * reference.material().thickness;  // N/m
  for (std::size_t i = 0; i + 1 < top.size(); ++i) {
    const double share = 0.5 * per_length * (mesh.rest_position(top[i + 1]).x() - mesh.rest_position(top[i]).x());
    loads.external_forces(1, top[i]) += share;
    loads.external_forces(1, top[i + 1]) += share;
  }
  const linear::VertexField rest = x;
  fem::EquilibriumSolver solver({});
  solver.rebuild(model);
  const fem::EquilibriumStats stats = solver.solve(model, loads, nullptr, x);
  EXPECT_TRUE(stats.converged) << stats.residual;

  const std::vector<Opening> line = openings(mesh, slit, x);
  double largest = 0.0;
  double worst = 0.0;
  for (const std::vector<double>& row : reference.rows("slit opening profile")) {
    largest = std::max({largest, std::abs(row[1]), std::abs(row[2])});
  }
  for (const std::vector<double>& row : reference.rows("slit opening profile")) {
    const Opening found = at(line, row[0]);
    worst = std::max({worst, std::abs(found.normal - row[1]), std::abs(found.tangential - row[2])});
  }
  double mean = 0.0;
  for (const int v : top) mean += (x(1, v) - rest(1, v)) / static_cast<double>(top.size());
  const double expected = reference.value("mean top displacement");
  std::printf("%s: %d vertices, %d iterations; opening within %.2f %% of its largest, top %+.3f %%\n", GetParam(),
              mesh.num_vertices(), stats.iterations, 100.0 * worst / largest, 100.0 * (mean / expected - 1.0));
  EXPECT_LE(worst, 0.02 * largest);
  EXPECT_NEAR(mean, expected, 0.005 * expected);
}

INSTANTIATE_TEST_SUITE_P(References, SlitUnderTension,
                         testing::Values("05a_centre_slit_025", "05b_centre_slit_050", "05c_edge_slit_030",
                                         "05d_inclined_slit_45", "05e_arc_slit_50"),
                         [](const testing::TestParamInfo<const char*>& tested) {
                           return std::string(tested.param).substr(4);
                         });

}  // namespace
}  // namespace kerf::accuracy
