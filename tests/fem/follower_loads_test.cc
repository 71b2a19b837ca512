// Loads that turn with the sheet: forces, resultants, work and tangent, and equilibria with closed forms.
#include <cmath>
#include <numbers>

#include "server/core/fem/element/follower_loads.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/fem/statics/equilibrium.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;

linear::VertexField forces(const Model& model, const Loads& loads, const linear::VertexField& x) {
  linear::VertexField f = Matrix3Xd::Zero(3, x.cols());
  add_follower_forces(model.element_blocks(), loads, x, f);
  return f;
}

// -df/dx by central differences.
MatrixXd numeric_stiffness(const Model& model, const Loads& loads, const linear::VertexField& x) {
  constexpr double kStep = 1e-6;
  MatrixXd K(x.size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    linear::VertexField up = x;
    linear::VertexField down = x;
    up.data()[i] += kStep;
    down.data()[i] -= kStep;
    const linear::VertexField change = (forces(model, loads, down) - forces(model, loads, up)) / (2.0 * kStep);
    K.col(i) = Eigen::Map<const Eigen::VectorXd>(change.data(), change.size());
  }
  return K;
}

MatrixXd assembled_stiffness(const Model& model, const Loads& loads, const linear::VertexField& x, MatrixPart part) {
  TangentMatrix matrix;
  matrix.rebuild(model);
  matrix.blocks().set_zero();
  matrix.add_follower_loads(model, loads, x, 1.0, part);
  MatrixXd K = MatrixXd::Zero(x.size(), x.size());
  const linear::BlockMatrix& blocks = matrix.blocks();
  for (int i = 0; i < blocks.num_rows(); ++i) {
    for (int at = blocks.row_begin(i); at < blocks.row_end(i); ++at) {
      K.block<3, 3>(3 * i, 3 * blocks.column(at)) = blocks.block(at);
    }
  }
  return K;
}

void expect_parts(const Model& model, const Loads& loads, const linear::VertexField& x, const MatrixXd& K) {
  const MatrixXd symmetric = assembled_stiffness(model, loads, x, MatrixPart::kSymmetric);
  const MatrixXd skew = assembled_stiffness(model, loads, x, MatrixPart::kSkew);
  EXPECT_LT((symmetric + skew - K).norm(), 1e-6 * K.norm());
  EXPECT_LT((symmetric - symmetric.transpose()).norm(), 1e-14 * K.norm());
  EXPECT_LT((skew + skew.transpose()).norm(), 1e-14 * K.norm());
}

Vector3d resultant(const linear::VertexField& f) {
  return f.rowwise().sum();
}

Vector3d torque(const linear::VertexField& x, const linear::VertexField& f) {
  Vector3d sum = Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.cols(); ++i) sum += x.col(i).cross(f.col(i));
  return sum;
}

bool is_on_border(const mesh::TriangleMesh& mesh, mesh::VertexId v) {
  const Eigen::Vector2d X = mesh.rest_position(v);
  return std::min({X.x(), X.y(), 1.0 - X.x(), 1.0 - X.y()}) < 1e-9;
}

// Moments along the border edges at x = 1 of a unit square, N m/m.
std::vector<EdgeMoment> moments_at_right(const Model& model, const mesh::TriangleMesh& mesh, double per_length) {
  std::vector<EdgeMoment> moments = border_moments(model, mesh, per_length);
  std::erase_if(moments, [&](const EdgeMoment& moment) {
    const double a = mesh.rest_position(moment.vertex[(moment.edge + 1) % 3]).x();
    const double b = mesh.rest_position(moment.vertex[(moment.edge + 2) % 3]).x();
    return std::min(a, b) < 1.0 - 1e-9;
  });
  return moments;
}

// A field that is bent and stretched by about `size`.
linear::VertexField bent(const mesh::TriangleMesh& mesh, double size, std::uint64_t seed) {
  SeededRandom random(seed);
  return random_rotation(random) * rest_state(mesh).x + random_field(random, mesh.num_vertices(), size);
}

TEST(Pressure, OnADomeHasTheForceAndTheMomentOfTheDiscBelowIt) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Model model(mesh, orthotropic_cloth());
  Loads loads;
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 70.0);
  linear::VertexField x = rest_state(mesh).x;
  SeededRandom random(3);
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (!is_on_border(mesh, v)) x.col(v) += random_vector(random, 0.03) + Vector3d(0.0, 0.0, 0.4);
  }
  const linear::VertexField f = forces(model, loads, x);
  EXPECT_LT((resultant(f) - Vector3d(0.0, 0.0, 70.0)).norm(), 1e-12);
  EXPECT_LT((torque(x, f) - Vector3d(0.5, 0.5, 0.0).cross(Vector3d(0.0, 0.0, 70.0))).norm(), 1e-12);
  EXPECT_LT((follower_resultant(model.element_blocks(), loads, x) - resultant(f)).norm(), 1e-12);
}

TEST(Pressure, ActsOnTheSlotsItIsGivenForAlone) {
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, orthotropic_cloth());
  Loads loads;
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 0.0);
  loads.pressure[3] = 6.0;
  const linear::VertexField f = forces(model, loads, rest_state(mesh).x);
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const std::array<mesh::VertexId, 3> corners = mesh.vertices(3);
    const bool touches = std::find(corners.begin(), corners.end(), v) != corners.end();
    EXPECT_NEAR(f(2, v), touches ? 6.0 * 0.125 / 3.0 : 0.0, 1e-15);
  }
}

TEST(Pressure, TangentIsTheDerivativeWhoseSkewPartIsOnTheBorder) {
  const mesh::TriangleMesh mesh = jittered_square(5);
  const Model model(mesh, orthotropic_cloth());
  const linear::VertexField x = bent(mesh, 0.05, 7);
  Loads loads;
  for (const bool is_even : {false, true}) {
    SeededRandom random(11);
    loads.pressure.clear();
    for (int t = 0; t < mesh.num_triangle_slots(); ++t) {
      loads.pressure.push_back(is_even ? 50.0 : random.uniform(-50.0, 50.0));
    }
    const MatrixXd K = numeric_stiffness(model, loads, x);
    expect_parts(model, loads, x, K);
    double inside = 0.0;
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      for (int j = 0; j < mesh.num_vertices(); ++j) {
        if (is_on_border(mesh, i) && is_on_border(mesh, j)) continue;
        inside = std::max(inside, (K.block<3, 3>(3 * i, 3 * j) - K.block<3, 3>(3 * j, 3 * i).transpose()).norm());
      }
    }
    if (is_even) {
      EXPECT_LT(inside, 1e-6);
    } else {
      EXPECT_GT(inside, 0.1);
    }
  }
}

// By Simpson's rule on many parts of the way.
double integrated_work(const Model& model, const Loads& loads, const linear::VertexField& from,
                       const linear::VertexField& to) {
  constexpr int kParts = 200;
  const linear::VertexField way = to - from;
  double sum = 0.0;
  for (int i = 0; i <= 2 * kParts; ++i) {
    const double share = i == 0 || i == 2 * kParts ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    const linear::VertexField x = from + (0.5 * i / kParts) * way;
    sum += share * forces(model, loads, x).cwiseProduct(way).sum();
  }
  return sum / (6.0 * kParts);
}

TEST(FollowerWork, IsTheIntegralOfTheForcesAlongTheWay) {
  const mesh::TriangleMesh mesh = jittered_square(4);
  const Model model(mesh, orthotropic_cloth());
  const linear::VertexField from = rest_state(mesh).x;
  const linear::VertexField to = bent(mesh, 0.1, 5);
  Loads loads;
  SeededRandom random(13);
  for (int t = 0; t < mesh.num_triangle_slots(); ++t) loads.pressure.push_back(random.uniform(-50.0, 50.0));
  EXPECT_NEAR(follower_work(model.element_blocks(), loads, from, to), integrated_work(model, loads, from, to), 1e-9);
  // A moment is tested only while its edge keeps its direction: rolled up about the y axis.
  loads.pressure.clear();
  loads.edge_moments = moments_at_right(model, mesh, 2.0);
  ASSERT_EQ(loads.edge_moments.size(), 3U);
  linear::VertexField rolled = from;
  for (Eigen::Index v = 0; v < rolled.cols(); ++v) {
    const double angle = 1.2 * from(0, v);
    rolled.col(v) << std::sin(angle) / 1.2, from(1, v), (1.0 - std::cos(angle)) / 1.2;
  }
  EXPECT_NEAR(follower_work(model.element_blocks(), loads, from, rolled), integrated_work(model, loads, from, rolled),
              1e-6);
  // The slope at the edge of a curvature that is not the moment's lags behind by up to half a cell.
  EXPECT_NEAR(follower_work(model.element_blocks(), loads, from, rolled), 2.0 * 1.2, 0.5 * 2.0 * 1.2 / 3.0);
}

TEST(EdgeMoment, HasNoForceAndItsMomentAboutTheEdgeHoweverTheSheetLies) {
  const mesh::TriangleMesh mesh = jittered_square(6);
  for (const double bending_scale : {1.0, 0.0}) {
    Material material = orthotropic_cloth();
    material.bending_scale = bending_scale;
    const Model model(mesh, material);
    for (const EdgeMoment& moment : moments_at_right(model, mesh, 3.0)) {
      Loads loads;
      loads.edge_moments = {moment};
      const linear::VertexField x = bent(mesh, 0.02, 17);
      const linear::VertexField f = forces(model, loads, x);
      const Vector3d edge = x.col(moment.vertex[(moment.edge + 2) % 3]) - x.col(moment.vertex[(moment.edge + 1) % 3]);
      EXPECT_LT(resultant(f).norm(), 1e-12);
      EXPECT_NEAR(torque(x, f).dot(edge.normalized()), -moment.moment, 1e-12);
      const Eigen::Vector2d A = mesh.rest_position(moment.vertex[(moment.edge + 1) % 3]);
      const Eigen::Vector2d B = mesh.rest_position(moment.vertex[(moment.edge + 2) % 3]);
      EXPECT_NEAR(moment.moment, 3.0 * (B - A).norm(), 1e-12);
    }
  }
}

TEST(EdgeMoment, TangentIsTheDerivative) {
  const mesh::TriangleMesh mesh = jittered_square(4);
  const Model model(mesh, orthotropic_cloth());
  Loads loads;
  loads.edge_moments = moments_at_right(model, mesh, 3.0);
  const linear::VertexField x = bent(mesh, 0.02, 19);
  const MatrixXd K = numeric_stiffness(model, loads, x);
  expect_parts(model, loads, x, K);
}

TEST(EdgeMoment, StaysFiniteWhereTheSheetHasCollapsed) {
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, orthotropic_cloth());
  Loads loads;
  loads.edge_moments = moments_at_right(model, mesh, 3.0);
  loads.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 5.0);
  const linear::VertexField x = Matrix3Xd::Zero(3, mesh.num_vertices());
  EXPECT_TRUE(forces(model, loads, x).allFinite());
  EXPECT_TRUE(assembled_stiffness(model, loads, x, MatrixPart::kSymmetric).allFinite());
  EXPECT_TRUE(std::isfinite(follower_work(model.element_blocks(), loads, x, rest_state(mesh).x)));
}

TEST(EdgeMoment, IsTakenByAClampAtTheSameEdge) {
  const mesh::TriangleMesh mesh = square_grid(4);
  Model model(mesh, orthotropic_cloth());
  std::vector<Clamp> clamps;
  for (int j = 0; j < 4; ++j) clamps.push_back({4 * j + 3, Eigen::Matrix<double, 3, 2>::Identity()});
  model.set_clamps(mesh, clamps);
  Loads loads;
  loads.edge_moments = moments_at_right(model, mesh, 3.0);
  ASSERT_EQ(loads.edge_moments.size(), 3U);
  EXPECT_TRUE(forces(model, loads, rest_state(mesh).x).isZero(0.0));
}

// num_x x num_y cells, in the plane z = 0, of which pins hold y and, at x = 0, everything.
struct Strip {
  Strip(int num_x, int num_y, double length, double width, const Material& material)
      : mesh(mesh::make_grid({.num_x = num_x + 1, .num_y = num_y + 1, .width = length, .height = width}).value()),
        model(mesh, material),
        x(rest_state(mesh).x) {
    loads.gravity.setZero();
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const bool is_root = v % (num_x + 1) == 0;
      loads.pins.push_back({v, x.col(v), Vector3d::Zero(), {is_root, true, is_root}});
    }
  }
  void clamp_root() {
    std::vector<Clamp> clamps;
    for (const Pin& pin : loads.pins) {
      if (pin.fixed[0]) clamps.push_back({pin.vertex, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
  }
  EquilibriumStats settle() {
    EquilibriumSolver solver({});
    solver.rebuild(model);
    return solver.solve(model, loads, nullptr, x);
  }

  mesh::TriangleMesh mesh;
  Model model;
  linear::VertexField x;
  Loads loads;
};

// A membrane held at both ends of its span L bulges to an arc of half angle phi: tension p R = E t (phi / sin phi - 1)
// with R = L / (2 sin phi), hence phi - sin phi = p L / (2 E t).
TEST(Pressure, InflatesAStripToTheArcOfTheClosedForm) {
  Material material = isotropic(1.0e6, 0.0, 1.0e-3, 1000.0);
  material.bending_scale = 0.0;
  Strip strip(40, 1, 1.0, 0.05, material);
  for (fem::Pin& pin : strip.loads.pins) {
    if (pin.vertex % 41 == 40) pin.fixed = {true, true, true};
  }
  for (const double pressure : {20.0, 100.0, 400.0, -400.0}) {
    strip.loads.pressure.assign(static_cast<std::size_t>(strip.mesh.num_triangle_slots()), pressure);
    const EquilibriumStats stats = strip.settle();
    EXPECT_TRUE(stats.converged) << stats.residual;
    const double share = std::abs(pressure) / (2.0 * 1.0e6 * 1.0e-3);
    double phi = 1.0;
    for (int i = 0; i < 100; ++i) phi -= (phi - std::sin(phi) - share) / (1.0 - std::cos(phi));
    const double sag = 0.5 * std::tan(0.5 * phi);
    const double tension = std::abs(pressure) / (2.0 * std::sin(phi));
    linear::VertexField f(strip.x.cols());
    strip.model.internal_forces(strip.x, f);
    add_follower_forces(strip.model.element_blocks(), strip.loads, strip.x, f);
    const double pull = (f(0, 0) + f(0, 41)) / 0.05;
    std::printf("pressure %g: %d iterations, phi %.4f, sag %+.3f %%, tension %+.3f %%\n", pressure, stats.iterations,
                phi, 100.0 * (std::abs(strip.x(2, 20)) / sag - 1.0), 100.0 * (pull / (tension * std::cos(phi)) - 1.0));
    EXPECT_NEAR(strip.x(2, 20), std::copysign(sag, pressure), 5e-3 * sag);
    EXPECT_NEAR(pull, tension * std::cos(phi), 5e-3 * tension);
  }
}

// Returns the tip of an inextensible cantilever under a pressure p that stays normal to it. Heun's method starts from
// the free end, where force and moment are 0, and turns the result so that the root is level: M' = -t x F, F' = -p n,
// EI theta' = M.
Eigen::Vector2d follower_tip(double pressure, double stiffness, double length) {
  constexpr int kSteps = 20000;
  using Vector6 = Eigen::Matrix<double, 6, 1>;  // x, z, theta, M, F
  const auto rate = [&](const Vector6& y) {
    const double c = std::cos(y[2]);
    const double s = std::sin(y[2]);
    Vector6 d;
    d << c, s, y[3] / stiffness, -(c * y[5] - s * y[4]), pressure * s, -pressure * c;
    return d;
  };
  Vector6 y = Vector6::Zero();
  const double h = -length / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const Vector6 first = rate(y);
    y += 0.5 * h * (first + rate(y + h * first));
  }
  const Eigen::Vector2d way = -y.head<2>();
  const double c = std::cos(y[2]);
  const double s = std::sin(y[2]);
  return {c * way.x() + s * way.y(), -s * way.x() + c * way.y()};
}

TEST(Pressure, BendsACantileverToTheSolutionOfItsDifferentialEquation) {
  const Material material = isotropic(1.0e8, 0.0, 1.0e-3, 1000.0);
  const double stiffness = 1.0e8 * 1e-9 / 12.0;  // N m
  Strip strip(40, 2, 0.3, 0.05, material);
  strip.clamp_root();
  for (const double multiple : {2.0, 5.0, 10.0, 20.0}) {
    const double pressure = multiple * stiffness / 0.027;
    strip.loads.pressure.assign(static_cast<std::size_t>(strip.mesh.num_triangle_slots()), pressure);
    const EquilibriumStats stats = strip.settle();
    EXPECT_TRUE(stats.converged) << stats.residual;
    const Eigen::Vector2d tip = follower_tip(pressure, stiffness, 0.3);
    const Vector3d found = (strip.x.col(40) + strip.x.col(81) + strip.x.col(122)) / 3.0;
    std::printf("p L^3 / EI = %g: %d iterations, tip %.5f %.5f, off by %.3f %% of the length\n", multiple,
                stats.iterations, tip.x(), tip.y(), 100.0 * std::hypot(found.x() - tip.x(), found.z() - tip.y()) / 0.3);
    EXPECT_LT(std::hypot(found.x() - tip.x(), found.z() - tip.y()), 5e-3 * 0.3);
  }
}

// To a part of a circle of radius EI / M, with the energy M^2 L / (2 EI).
TEST(EdgeMoment, BendsAStripToACircleAndStoresItsEnergy) {
  const Material material = isotropic(1.0e8, 0.0, 1.0e-3, 1000.0);
  const double stiffness = 1.0e8 * 1e-9 / 12.0;  // N m
  Strip strip(20, 2, 1.0, 0.1, material);
  strip.clamp_root();
  strip.model.bend_by_angles(strip.mesh);
  for (const double turn : {0.5, 1.5, 3.0, 6.0}) {
    strip.loads.edge_moments = moments_at_right(strip.model, strip.mesh, turn * stiffness);
    EXPECT_TRUE(strip.settle().converged) << turn;
    const Vector3d tip = strip.x.col(41);
    EXPECT_NEAR(tip.x(), std::sin(turn) / turn, 1e-3) << turn;
    EXPECT_NEAR(tip.z(), (1.0 - std::cos(turn)) / turn, 1e-3) << turn;
    const double expected = 0.5 * turn * turn * stiffness * 0.1;
    EXPECT_NEAR(strip.model.bending().energy(strip.model.element_blocks(), strip.x) + edge_moment_energy(strip.loads),
                expected, 1e-4 * expected)
        << turn;
  }
}

}  // namespace
}  // namespace kerf::fem
