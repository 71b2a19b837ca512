// Static equilibria against independent references.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "tests/accuracy/statics.h"

namespace kerf::accuracy {
namespace {

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
  linear::VertexField f(mesh.num_vertices());
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
  linear::VertexField x, rest;  // 3 x V, m
  fem::Loads loads;
};

// Sum over the vertices of component c of what holds them, N.
double reaction(const fem::Model& model, const Planar& problem, std::span<const int> vertices, int c) {
  linear::VertexField f(model.num_vertices());
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

}  // namespace
}  // namespace kerf::accuracy
