// Plates on irregular meshes against closed forms: small deflections, for which the plate's equation is linear.
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/SparseCholesky>

#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/modes.h"
#include "server/core/mesh/build/outline_mesh.h"
#include "tests/support/meshes.h"

namespace kerf::accuracy {
namespace {

using MakeMesh = std::function<mesh::TriangleMesh(int cells)>;

struct Layout {
  const char* name;
  MakeMesh make;  // of the unit square
};
void PrintTo(const Layout& layout, std::ostream* out) {
  *out << layout.name;
}

mesh::TriangleMesh outlined(const std::vector<Eigen::Vector2d>& border, bool has_corners, double edge_length) {
  mesh::OutlineContour contour{border, {}, "border"};
  for (std::size_t i = 0; has_corners && i < border.size(); ++i) contour.corners.push_back(i);
  mesh::OutlineConfig config;
  config.contours = {contour};
  config.edge_length = edge_length;
  return test::must(mesh::mesh_outline(config));
}

const fem::Material kMaterial = fem::isotropic(1.0e9, 0.3, 1.0e-3, 1000.0);

double flexural_rigidity() {
  return fem::bending_law(kMaterial)(0, 0);  // N m
}

// Deflection under 1 N/m^2, at every vertex; 0 at those held.
Eigen::VectorXd deflection(const fem::Model& model, const std::vector<bool>& is_held) {
  const int n = model.num_vertices();
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd load = Eigen::VectorXd::Zero(n);
  for (int v = 0; v < n; ++v) {
    if (is_held[static_cast<std::size_t>(v)]) {
      entries.emplace_back(v, v, 1.0);
      continue;
    }
    for (const fem::BendingEntry& entry : model.bending().rows().row(v)) {
      if (!is_held[static_cast<std::size_t>(entry.column)]) entries.emplace_back(v, entry.column, entry.value);
    }
    load[v] = model.mass()[static_cast<std::size_t>(v)] / (kMaterial.density * kMaterial.thickness);
  }
  Eigen::SparseMatrix<double> Q(n, n);
  Q.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(Q);
  EXPECT_EQ(factor.info(), Eigen::Success);
  return factor.solve(load);
}

class SquarePlate : public testing::TestWithParam<Layout> {};

// Timoshenko and Woinowsky-Krieger 1959, Theory of Plates and Shells, table 8: 0.00406 q a^4 / D; more digits from
// Navier's series.
TEST_P(SquarePlate, SimplySupportedSagsAsNaviersSeries) {
  double exact = 0.0;
  for (int m = 1; m < 60; m += 2) {
    for (int n = 1; n < 60; n += 2) {
      const double sign = (m + n) / 2 % 2 == 1 ? 1.0 : -1.0;
      exact += sign * 16.0 / (std::pow(std::numbers::pi, 6) * m * n * std::pow(m * m + n * n, 2));
    }
  }
  ASSERT_NEAR(exact, 0.00406, 5e-6);
  for (const int cells : {10, 20, 40}) {
    const mesh::TriangleMesh mesh = GetParam().make(cells);
    const fem::Model model(mesh, kMaterial);
    std::vector<bool> is_held;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d X = mesh.rest_position(v);
      is_held.push_back(std::min(X.minCoeff(), 1.0 - X.maxCoeff()) < 1e-9);
    }
    const double sag = deflection(model, is_held).maxCoeff() * flexural_rigidity();
    const double error = sag / exact - 1.0;
    std::printf("%s, %d cells: %+.3f %%\n", GetParam().name, cells, 100.0 * error);
    EXPECT_LT(std::abs(error), 1.5 / (cells * cells)) << cells;
  }
}

// Leissa 1969, Vibration of Plates, NASA SP-160, table 4.66: omega a^2 sqrt(rho t / D) of the free square, nu = 0.3.
TEST_P(SquarePlate, FreeVibratesAsLeissa) {
  constexpr std::array<double, 4> kLeissa{13.468, 19.596, 24.270, 34.80};
  for (const int cells : {10, 20, 40}) {
    const mesh::TriangleMesh mesh = GetParam().make(cells);
    fem::Model model(mesh, kMaterial);
    model.bend_by_angles(mesh);
    fem::Loads loads;
    loads.gravity.setZero();
    linear::VertexField x(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) x.col(v) << mesh.rest_position(v), 0.0;
    const fem::Modes modes = fem::find_modes(model, loads, x, 10);
    EXPECT_TRUE(modes.converged);
    const double unit = std::sqrt(kMaterial.density * kMaterial.thickness / flexural_rigidity());
    std::printf("%s, %d cells:", GetParam().name, cells);
    for (std::size_t i = 0; i < kLeissa.size(); ++i) {
      const double omega = std::sqrt(modes.eigenvalues[6 + static_cast<Eigen::Index>(i)]) * unit;
      std::printf(" %+.2f %%", 100.0 * (omega / kLeissa[i] - 1.0));
      EXPECT_NEAR(omega, kLeissa[i], 3.0 / (cells * cells) * kLeissa[i]) << cells;
    }
    std::printf("\n");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, SquarePlate,
    testing::Values(Layout{"uniform", [](int cells) { return test::grid(cells + 1); }},
                    Layout{"jittered", [](int cells) { return test::jittered_grid(cells + 1, 7); }},
                    Layout{"union_jack", [](int cells) { return test::union_jack(cells + 1); }},
                    Layout{"outline",
                           [](int cells) {
                             return outlined({{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}}, true, 1.0 / cells);
                           }}),
    [](const testing::TestParamInfo<Layout>& tested) { return std::string(tested.param.name); });

// Timoshenko and Woinowsky-Krieger 1959, eq. 62: q a^4 / (64 D) at the centre of a clamped circle.
TEST(CircularPlate, ClampedSagsAsTheClosedForm) {
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < 512; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 512;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  for (const int cells : {8, 16, 32}) {  // along the radius
    const mesh::TriangleMesh mesh = outlined(circle, false, 1.0 / cells);
    fem::Model model(mesh, kMaterial);
    std::vector<bool> is_held;
    std::vector<fem::Clamp> clamps;
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      is_held.push_back(mesh.rest_position(v).norm() > 1.0 - 1e-4);
      if (is_held.back()) clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
    }
    model.set_clamps(mesh, clamps);
    const double error = deflection(model, is_held).maxCoeff() * flexural_rigidity() * 64.0 - 1.0;
    std::printf("clamped circle, %d cells: %+.3f %%\n", cells, 100.0 * error);
    EXPECT_LT(std::abs(error), 2.0 / (cells * cells)) << cells;
  }
}

}  // namespace
}  // namespace kerf::accuracy
