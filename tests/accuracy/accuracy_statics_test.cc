// Static equilibria against independent references.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <span>

#include "server/cut/cut.h"
#include "server/fem/equilibrium.h"
#include "server/mesh/mesh_import.h"
#include "tests/accuracy/reference.h"

namespace kerf::accuracy {
namespace {

constexpr std::array<const char*, 3> kMeshes{"coarse", "medium", "fine"};

// (num_x + 1) x (num_y + 1) vertices, x fastest, of the image of the unit square; cells are halved from lower
// right to upper left, which in Cook's membrane is the shorter diagonal.
template <typename Map>
mesh::TriangleMesh mapped_grid(int num_x, int num_y, const Map& map) {
  mesh::IndexedMesh grid;
  grid.rest.resize(2, (num_x + 1) * (num_y + 1));
  grid.triangles.resize(3, 2 * num_x * num_y);
  for (int j = 0; j <= num_y; ++j) {
    for (int i = 0; i <= num_x; ++i) {
      const Eigen::Vector2d X = map(static_cast<double>(i) / num_x, static_cast<double>(j) / num_y);
      grid.rest.col(j * (num_x + 1) + i) = X;
    }
  }
  int t = 0;
  for (int j = 0; j < num_y; ++j) {
    for (int i = 0; i < num_x; ++i) {
      const int a = j * (num_x + 1) + i;
      const int c = a + num_x + 2;
      grid.triangles.col(t++) = Eigen::Vector3i(a, a + 1, c - 1);
      grid.triangles.col(t++) = Eigen::Vector3i(a + 1, c, c - 1);
    }
  }
  return mesh::import_mesh(grid).value();
}

// x: where to start; becomes the equilibrium.
fem::EquilibriumStats settle(const fem::Model& model, const fem::Loads& loads, mesh::VertexField& x) {
  fem::EquilibriumSolver solver({});
  solver.rebuild(model);
  const fem::EquilibriumStats stats = solver.solve(model, loads, nullptr, x);
  EXPECT_TRUE(stats.converged) << stats.residual << " after " << stats.iterations;
  std::printf("  %d vertices: %d iterations, residual %.1e\n", model.num_vertices(), stats.iterations, stats.residual);
  return stats;
}

struct Deflection {
  double u = 0.0;
  double v = 0.0;
  double energy = 0.0;
};

// Cook's membrane of n x n x 2 triangles under the reference load, solved under `scale` of it and scaled back.
Deflection cook(const Reference& reference, int n) {
  constexpr double kScale = 1e-4;  // small enough for the co-rotational law to be linear
  const auto corners = reference.json().at("geometry").at("corners").get<std::vector<std::array<double, 2>>>();
  const auto corner = [&corners](std::size_t i) { return Eigen::Vector2d(corners[i][0], corners[i][1]); };
  const mesh::TriangleMesh mesh = mapped_grid(n, n, [&](double a, double b) {
    return Eigen::Vector2d((1.0 - b) * ((1.0 - a) * corner(0) + a * corner(1)) +
                           b * ((1.0 - a) * corner(3) + a * corner(2)));
  });
  fem::Material material = reference.material();
  // The reference is plane stress alone. Bending resists second derivatives of all of x, those within the plane too:
  // with a thickness of 1 that stiffens the singular corner at (0, 44), by 0.5 % of v on any mesh.
  material.bending_scale = 0.0;
  const fem::Model model(mesh, material);
  fem::State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int i = 0; i < mesh.num_vertices(); ++i) state.x.col(i).head<2>() = mesh.rest_position(i);
  const Eigen::Matrix3Xd rest = state.x;
  fem::Loads loads;
  loads.gravity.setZero();
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (int j = 0; j <= n; ++j) {
    const int left = j * (n + 1);
    loads.pins.push_back({left, state.x.col(left), Eigen::Vector3d::Zero()});
    const double share = j == 0 || j == n ? 0.5 : 1.0;
    loads.external_forces(1, left + n) = kScale * share / n;
  }
  settle(model, loads, state.x);
  EXPECT_LT(state.x.row(2).cwiseAbs().maxCoeff(), 1e-12);
  const int middle = (n / 2) * (n + 1) + n;
  EXPECT_NEAR(rest(0, middle), 48.0, 1e-9);
  EXPECT_NEAR(rest(1, middle), 52.0, 1e-9);
  const Eigen::Vector3d moved = (state.x.col(middle) - rest.col(middle)) / kScale;
  return {moved.x(), moved.y(), model.energies(state, loads.gravity).membrane / (kScale * kScale)};
}

TEST(CooksMembrane, ConvergesToTheReferenceWithinTheToleranceOfEachMesh) {
  const Reference reference("03a_cook_membrane");
  const double v = reference.value("v at (48,52)");
  const double u = reference.value("u at (48,52)");
  const double energy = reference.value("strain energy (external work/2)");
  double last_error = 1.0;
  int n = 8;
  for (const char* const mesh : kMeshes) {
    const double tolerance = reference.tolerance(mesh);
    const Deflection found = cook(reference, n);
    const double error = std::abs(found.v / v - 1.0);
    std::printf("Cook %2d x %2d x 2: v %.4f (%+.2f %%), u %.4f (%+.2f %%), energy %.4f (%+.2f %%)\n", n, n, found.v,
                100.0 * (found.v / v - 1.0), found.u, 100.0 * (found.u / u - 1.0), found.energy,
                100.0 * (found.energy / energy - 1.0));
    EXPECT_LE(error, tolerance) << mesh;
    EXPECT_NEAR(found.u, u, tolerance * std::abs(u)) << mesh;
    EXPECT_NEAR(found.energy, energy, tolerance * energy) << mesh;
    EXPECT_LT(found.v, v) << "conforming triangles are too stiff, never too soft";
    EXPECT_LT(error, 0.4 * last_error) << "nearly second order";
    last_error = error;
    n *= 2;
  }
}

struct Hanging {
  Eigen::Matrix3Xd line;    // 3 x (segments + 1), the first edge of the strip, m
  double horizontal = 0.0;  // N, on the support at s = 0
  double vertical = 0.0;    // N
};

// A strip of one cell across, pinned at both ends.
Hanging hang(const Reference& reference, int segments) {
  const double length = reference.geometry("L0");
  const double width = reference.geometry("width");
  const double span = reference.geometry("span");
  const mesh::TriangleMesh mesh =
      mapped_grid(segments, 1, [=](double a, double b) { return Eigen::Vector2d(a * length, b * width); });
  fem::Material material = reference.material();
  material.bending_scale = 0.0;  // the reference neglects bending
  const fem::Model model(mesh, material);
  fem::State state;
  state.x = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  state.v = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  fem::Loads loads;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const double a = mesh.rest_position(i).x() / length;
    state.x.col(i) = Eigen::Vector3d(a * span, mesh.rest_position(i).y(), -0.8 * a * (1.0 - a));
    if (i % (segments + 1) == 0 || i % (segments + 1) == segments) {
      loads.pins.push_back({i, state.x.col(i), Eigen::Vector3d::Zero()});
    }
  }
  settle(model, loads, state.x);
  Hanging result;
  result.line = state.x.leftCols(segments + 1);
  mesh::VertexField f(mesh.num_vertices());
  model.internal_forces(state.x, f);
  for (const int i : {0, segments + 1}) {
    result.horizontal += f(0, i);
    result.vertical += -f(2, i) + model.mass()[static_cast<std::size_t>(i)] * 9.81;
  }
  return result;
}

class Catenary : public testing::TestWithParam<const char*> {};

TEST_P(Catenary, HangsInTheReferenceShapeWithTheReferenceForces) {
  const Reference reference(GetParam());
  const std::vector<std::vector<double>> rows = reference.rows("centre line");
  double sag = 0.0;
  for (const std::vector<double>& row : rows) sag = std::max(sag, row[2]);
  int segments = 10;
  for (const char* const mesh : kMeshes) {
    const double tolerance = reference.tolerance(mesh);
    const Hanging found = hang(reference, segments);
    double worst = 0.0;
    for (const std::vector<double>& row : rows) {
      // On the straight segment between the two vertices around s.
      const double at = row[0] * segments;
      const int i = std::min(static_cast<int>(at), segments - 1);
      const Eigen::Vector3d p = found.line.col(i) + (at - i) * (found.line.col(i + 1) - found.line.col(i));
      worst = std::max({worst, std::abs(p.x() - row[1]), std::abs(-p.z() - row[2])});
    }
    const double H = reference.value("horizontal force H");
    const double V = reference.value("vertical force at s=0");
    std::printf("%s, %d segments: shape within %.3f %% of the sag, H %+.3f %%, V %+.4f %%\n", GetParam(), segments,
                100.0 * worst / sag, 100.0 * (found.horizontal / H - 1.0), 100.0 * (found.vertical / V - 1.0));
    EXPECT_LE(worst, tolerance * sag) << mesh;
    EXPECT_NEAR(found.horizontal, H, tolerance * H) << mesh;
    EXPECT_NEAR(found.vertical, V, 1e-4 * V) << mesh;
    segments *= 2;
  }
}

INSTANTIATE_TEST_SUITE_P(References, Catenary, testing::Values("06a_catenary", "06b_stretchy_catenary"),
                         [](const testing::TestParamInfo<const char*>& tested) {
                           return std::string(tested.param).substr(4);
                         });

// A planar problem: vertices start at their rest positions with z = 0 held.
struct Planar {
  explicit Planar(const mesh::TriangleMesh& of) : mesh(of), x(of.num_vertices()) {
    loads.gravity.setZero();
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      x.col(i) << mesh.rest_position(i), 0.0;
      loads.pins.push_back({i, x.col(i), Eigen::Vector3d::Zero(), {false, false, true}});
    }
    rest = x;
  }
  // Holds component c of vertex v displaced by u.
  void hold(int v, std::size_t c, double u) {
    fem::Pin& pin = loads.pins[static_cast<std::size_t>(v)];
    pin.fixed[c] = true;
    pin.target[static_cast<Eigen::Index>(c)] = rest(static_cast<Eigen::Index>(c), v) + u;
  }

  const mesh::TriangleMesh& mesh;
  mesh::VertexField x, rest;  // 3 x V, m
  fem::Loads loads;
};

// Sum over the vertices of component c of what holds them, N.
double reaction(const fem::Model& model, const Planar& problem, std::span<const int> vertices, int c) {
  mesh::VertexField f(model.num_vertices());
  model.internal_forces(problem.x, f);
  double sum = 0.0;
  for (const int v : vertices) sum -= f(c, v);
  return sum;
}

TEST(PatchTest, LinearDisplacementsGiveTheExactStressInEveryTriangle) {
  const Reference reference("01a_patch_macneal_harder");
  const auto points = reference.json().at("geometry").at("vertices").get<std::vector<std::array<double, 2>>>();
  const auto triangles = reference.json().at("geometry").at("triangles").get<std::vector<std::array<int, 3>>>();
  mesh::IndexedMesh patch;
  patch.rest.resize(2, static_cast<Eigen::Index>(points.size()));
  patch.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    patch.rest.col(static_cast<Eigen::Index>(i)) << points[i][0], points[i][1];
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    patch.triangles.col(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1], triangles[t][2];
  }
  const mesh::TriangleMesh mesh = mesh::import_mesh(patch).value();
  const fem::Model model(mesh, reference.material());
  Planar problem(mesh);
  const auto displacement = [&](int v) {
    const Eigen::Vector3d X = problem.rest.col(v);
    return Eigen::Vector2d(1e-3 * (X.x() + 0.5 * X.y()), 1e-3 * (X.y() + 0.5 * X.x()));
  };
  for (const int v : reference.json().at("geometry").at("boundary_vertices").get<std::vector<int>>()) {
    for (std::size_t c = 0; c < 2; ++c) problem.hold(v, c, displacement(v)[static_cast<Eigen::Index>(c)]);
  }
  settle(model, problem.loads, problem.x);
  for (const std::vector<double>& row : reference.rows("interior displacement")) {
    const int v = static_cast<int>(row[0]);
    EXPECT_NEAR(problem.x(0, v) - problem.rest(0, v), row[1], 1e-9);
    EXPECT_NEAR(problem.x(1, v) - problem.rest(1, v), row[2], 1e-9);
  }
}

TEST(UniaxialStretch, HasTheForceAndTheEnergyOfTheClosedForm) {
  const Reference reference("02a_uniaxial_biot");
  const double width = reference.geometry("width");
  const double length = reference.geometry("length");
  const mesh::TriangleMesh mesh =
      mapped_grid(2, 4, [=](double a, double b) { return Eigen::Vector2d(a * width, b * length); });
  const fem::Model model(mesh, reference.material());
  for (const std::vector<double>& row : reference.rows("nominal axial force")) {
    Planar problem(mesh);
    std::vector<int> top;
    problem.hold(0, 0, 0.0);
    for (int i = 0; i < 3; ++i) {
      problem.hold(i, 1, 0.0);
      top.push_back(12 + i);
      problem.hold(top.back(), 1, row[0] * length);
    }
    settle(model, problem.loads, problem.x);
    EXPECT_NEAR(reaction(model, problem, top, 1), row[1], 1e-6 * row[1]);
    EXPECT_NEAR(problem.x(0, 2) - problem.x(0, 0), row[2] * width, 1e-6 * width);
    EXPECT_NEAR(model.energies({problem.x, problem.x}, problem.loads.gravity).membrane, row[3], 1e-6 * row[3]);
  }
}

TEST(ClampedStrip, PulledFarHasTheForceEnergyAndContractionOfTheReference) {
  const Reference reference("02b_clamped_strip");
  const double width = reference.geometry("width");
  const double length = reference.geometry("length");
  int across = 8;
  for (const char* const fineness : kMeshes) {
    const int along = 2 * across;
    const mesh::TriangleMesh mesh =
        mapped_grid(across, along, [=](double a, double b) { return Eigen::Vector2d(a * width, b * length); });
    const fem::Model model(mesh, reference.material());
    for (const std::vector<double>& row : reference.rows("reaction, energy, side contraction")) {
      Planar problem(mesh);
      std::vector<int> top;
      for (int i = 0; i <= across; ++i) {
        top.push_back(along * (across + 1) + i);
        for (std::size_t c = 0; c < 2; ++c) {
          problem.hold(i, c, 0.0);
          problem.hold(top.back(), c, c == 1 ? row[0] * length : 0.0);
        }
      }
      settle(model, problem.loads, problem.x);
      const double force = reaction(model, problem, top, 1);
      const double energy = model.energies({problem.x, problem.x}, problem.loads.gravity).membrane;
      const int side = across * (across + 1);
      const double contraction = problem.x(0, side) - problem.rest(0, side);
      const double tolerance = reference.tolerance(fineness);
      std::printf("strip %2d across, Delta/L %.1f: force %+.3f %%, energy %+.3f %%, contraction %+.3f %%\n", across,
                  row[0], 100.0 * (force / row[1] - 1.0), 100.0 * (energy / row[2] - 1.0),
                  100.0 * (contraction / row[3] - 1.0));
      EXPECT_NEAR(force, row[1], tolerance * row[1]) << fineness;
      EXPECT_NEAR(energy, row[2], tolerance * row[2]) << fineness;
      EXPECT_NEAR(contraction, row[3], 3.0 * tolerance * row[3]) << fineness;
    }
    across *= 2;
  }
}

TEST(OffAxisStretch, OfTheSourcesMaterialHasTheForceOfTheRotatedCompliance) {
  const Reference reference("10a_thesis_material_45");
  const double width = reference.geometry("width");
  const double length = reference.geometry("length");
  const mesh::TriangleMesh mesh =
      mapped_grid(10, 2, [=](double a, double b) { return Eigen::Vector2d(a * length, b * width); });
  fem::Material material = reference.material();
  material.direction = 0.25 * std::numbers::pi;
  const fem::Model model(mesh, material);
  for (const std::vector<double>& row :
       reference.rows("force at 45 deg, strip 20 mm x 100 mm x 0.1 mm (Biot, exact at any strain: no rotation by "
                      "symmetry)")) {
    Planar problem(mesh);
    std::vector<int> right;
    problem.hold(0, 1, 0.0);
    for (int j = 0; j <= 2; ++j) {
      problem.hold(11 * j, 0, 0.0);
      right.push_back(11 * j + 10);
      problem.hold(right.back(), 0, row[0] * length);
    }
    settle(model, problem.loads, problem.x);
    EXPECT_NEAR(reaction(model, problem, right, 0), row[1], 1e-6 * row[1]);
  }
}

// A strip along x in the plane z = 0, clamped at x = 0, in its undeformed state.
struct Cantilever {
  Cantilever(const Reference& reference, const char* breadth, int segments, int across)
      : length(reference.geometry("L")),
        mesh(mapped_grid(
            segments, across,
            [&](double a, double b) { return Eigen::Vector2d(a * length, b * reference.geometry(breadth)); })),
        model(mesh, reference.material()),
        x(mesh.num_vertices()) {
    loads.gravity.setZero();
    loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
    std::vector<fem::Clamp> clamps;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      x.col(v) << mesh.rest_position(v), 0.0;
      if (v % (segments + 1) == segments) end.push_back(v);
      if (v % (segments + 1) != 0) continue;
      loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
      clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
    rest = x;
  }
  // Of the end, m: mean over its vertices.
  [[nodiscard]] Eigen::Vector3d tip() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const int v : end) sum += x.col(v) - rest.col(v);
    return sum / static_cast<double>(end.size());
  }

  double length;  // m
  mesh::TriangleMesh mesh;
  fem::Model model;
  mesh::VertexField x, rest;
  fem::Loads loads;
  std::vector<int> end;  // vertices at x = L, in order
};

TEST(HeavyElastica, SagsAsTheClosedForm) {
  const Reference reference("07f_heavy_elastica");
  int segments = 10;
  for (const char* const fineness : kMeshes) {
    Cantilever strip(reference, "b", segments, std::max(1, segments / 8));
    for (const std::vector<double>& row : reference.rows("heavy elastica")) {
      strip.loads.gravity = {0.0, 0.0, -row[1]};
      settle(strip.model, strip.loads, strip.x);
      const Eigen::Vector3d tip = strip.tip();
      std::printf("elastica, %d segments, gravity %.2f: U %+.2f %%, sag %+.2f %%\n", segments, row[1],
                  100.0 * (-tip.x() / row[2] - 1.0), 100.0 * (-tip.z() / row[3] - 1.0));
      EXPECT_NEAR(-tip.x(), row[2], reference.tolerance(fineness) * row[2]) << fineness;
      EXPECT_NEAR(-tip.z(), row[3], reference.tolerance(fineness) * row[3]) << fineness;
    }
    segments *= 2;
  }
}

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
    mesh::VertexField x(mesh.num_vertices());
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
    std::sort(flap_end.begin(), flap_end.end(),
              [&](int a, int b) { return mesh.rest_position(a).y() < mesh.rest_position(b).y(); });
    const mesh::VertexField rest = x;
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

}  // namespace
}  // namespace kerf::accuracy
