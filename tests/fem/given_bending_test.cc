// Bending stiffness as measured, in place of that of a solid plate.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "server/core/fem/statics/equilibrium.h"
#include "server/core/fem/statics/modes.h"
#include "server/core/fem/step/integrator.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

constexpr std::array<std::optional<double> Material::*, 4> kGiven{
    &Material::bending_stiffness_1, &Material::bending_stiffness_2, &Material::bending_coupling,
    &Material::twisting_stiffness};

Material woven() {
  Material m = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  m.bending_stiffness_1 = 4.0e-5;
  m.bending_stiffness_2 = 1.0e-5;
  m.bending_coupling = 0.5e-5;
  m.twisting_stiffness = 0.8e-5;
  return m;
}

std::string refusal(const Material& material) {
  const Status status = validate(material, "m");
  return status.ok() ? "fine" : status.error().reason + " " + status.error().field;
}

TEST(GivenBending, StandsInForWhatWouldBeDerivedOneByOne) {
  const std::array<std::pair<Eigen::Index, Eigen::Index>, 4> at{{{0, 0}, {1, 1}, {0, 1}, {2, 2}}};
  Material material = orthotropic_cloth();
  material.bending_scale = 0.7;
  Eigen::Matrix3d expected = bending_law(material);
  for (std::size_t i = 0; i < kGiven.size(); ++i) {
    const auto [row, column] = at[i];
    expected(row, column) = expected(column, row) = 1.1 * expected(row, column);
    material.*kGiven[i] = expected(row, column);
    EXPECT_EQ(bending_law(material), expected) << i;
    EXPECT_EQ(membrane_law(material), membrane_law(orthotropic_cloth())) << i;
    EXPECT_EQ(refusal(material), "fine") << i;
  }
  material.bending_scale = 0.0;  // nothing is left to derive
  EXPECT_EQ(bending_law(material), expected);
  EXPECT_TRUE(MaterialLaw(material).has_bending());
  EXPECT_EQ(refusal(material), "fine");
  EXPECT_TRUE(bending_law(without_bending(material)).isZero(0.0));
  EXPECT_FALSE(MaterialLaw(without_bending(material)).has_bending());
}

TEST(GivenBending, ThatEqualsTheDerivedGivesTheSameBits) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  const Material derived = orthotropic_cloth();
  const Eigen::Matrix3d D = bending_law(derived);
  Material given = derived;
  given.bending_stiffness_1 = D(0, 0);
  given.bending_stiffness_2 = D(1, 1);
  given.bending_coupling = D(0, 1);
  given.twisting_stiffness = D(2, 2);
  const auto swung = [&mesh](const Material& material) {
    const Model model(mesh, material);
    State state = rest_state(mesh);
    Loads loads;
    loads.pins.push_back({0, state.x.col(0), Eigen::Vector3d::Zero()});
    const auto integrator = make_integrator({});
    integrator->rebuild(model);
    for (int i = 0; i < 20; ++i) integrator->step(model, loads, 1.0 / 60.0, nullptr, state);
    return std::pair(model.hash(), state.x);
  };
  const auto [model, x] = swung(derived);
  const auto [model_given, x_given] = swung(given);
  EXPECT_EQ(model, model_given);
  EXPECT_EQ(x, x_given);
  given.twisting_stiffness = 1.01 * D(2, 2);
  EXPECT_NE(swung(given).second, x);
}

// Jones, Mechanics of Composite Materials, eq. 5.120: omega^2 = pi^4 / (rho t) (D11 (m/a)^4 + 2 (D12 + 2 D66) (m n / (a
// b))^2
// + D22 (n/b)^4).
std::vector<double> supported_plate(const Material& m, double a, double b) {
  std::vector<double> squares;
  for (int i = 1; i <= 5; ++i) {
    for (int j = 1; j <= 5; ++j) {
      const double x = i / a;
      const double y = j / b;
      const double D = *m.bending_stiffness_1 * std::pow(x, 4) +
                       2.0 * (*m.bending_coupling + 2.0 * *m.twisting_stiffness) * x * x * y * y +
                       *m.bending_stiffness_2 * std::pow(y, 4);
      squares.push_back(std::pow(std::numbers::pi, 4) * D / (m.density * m.thickness));
    }
  }
  std::sort(squares.begin(), squares.end());
  return squares;
}

double worst_frequency(int cells, double direction) {
  constexpr double kWidth = 0.4, kHeight = 0.3;
  const mesh::TriangleMesh mesh = mesh::make_grid({cells + 1, cells + 1, kWidth, kHeight}).value();
  Material material = woven();
  const std::vector<double> expected =
      direction == 0.0 ? supported_plate(material, kWidth, kHeight) : supported_plate(material, kHeight, kWidth);
  material.direction = direction;
  const Model model(mesh, material);
  Loads loads;
  loads.gravity.setZero();
  const linear::VertexField x = rest_state(mesh).x;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    const int i = v % (cells + 1);
    const int j = v / (cells + 1);
    const bool is_border = i == 0 || j == 0 || i == cells || j == cells;
    loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero(), {true, true, is_border}});
  }
  const Modes modes = find_modes(model, loads, x, 4);
  EXPECT_TRUE(modes.converged);
  double worst = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double ratio = std::sqrt(modes.eigenvalues[static_cast<Eigen::Index>(i)] / expected[i]);
    worst = std::max(worst, std::abs(ratio - 1.0));
  }
  return worst;
}

TEST(GivenBending, SupportedPlateHasTheFrequenciesOfTheClosedForm) {
  for (const double direction : {0.0, 0.5 * std::numbers::pi}) {
    const double coarse = worst_frequency(12, direction);
    const double fine = worst_frequency(24, direction);
    std::printf("supported plate, axis at %.2f: %.2f %%, %.2f %%\n", direction, 100.0 * coarse, 100.0 * fine);
    EXPECT_LT(coarse, 0.03);
    EXPECT_LT(fine, 0.01);
    EXPECT_LT(fine, 0.5 * coarse);
  }
}

// Tip deflection of a narrow strip along x that is clamped at x = 0, over that of a beam, F L^3 / (3 b D).
double relative_sag(const Material& material, int breadths_long, double D) {
  constexpr double kBreadth = 0.01;  // m
  constexpr double kForce = 1e-10;   // N: small deflections
  const int along = 4 * breadths_long, across = 4;
  const double length = breadths_long * kBreadth;
  const mesh::TriangleMesh mesh = mesh::make_grid({along + 1, across + 1, length, kBreadth}).value();
  Model model(mesh, material);
  Loads loads;
  loads.gravity.setZero();
  loads.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  std::vector<Clamp> clamps;
  linear::VertexField x = rest_state(mesh).x;
  for (int j = 0; j <= across; ++j) {
    const int held = j * (along + 1);
    loads.pins.push_back({held, x.col(held), Eigen::Vector3d::Zero()});
    clamps.push_back({held, Eigen::Matrix<double, 3, 2>::Identity()});
    loads.external_forces(2, held + along) = (j == 0 || j == across ? 0.5 : 1.0) * kForce / across;
  }
  model.set_clamps(mesh, clamps);
  EquilibriumSolver solver({});
  solver.rebuild(model);
  EXPECT_TRUE(solver.solve(model, loads, nullptr, x).converged);
  return x(2, (across / 2) * (along + 1) + along) / (kForce * std::pow(length, 3) / (3.0 * kBreadth * D));
}

// Its free edges let it curl across, except near the clamp, over some breadths' length. So D = D11 - D12^2 / D22, and
// the error is as one over the length.
TEST(GivenBending, NarrowStripSagsAsTheBeamOfItsFreeEdges) {
  Material material = woven();
  material.bending_coupling = 0.0;
  EXPECT_NEAR(relative_sag(material, 20, 4e-5), 1.0, 0.01);
  material.bending_coupling = 1.4e-5;  // D12^2 / (D11 D22) = 0.49: it sags twice as far
  for (const auto& [direction, D] : {std::pair(0.0, 4e-5), std::pair(0.5 * std::numbers::pi, 1e-5)}) {
    material.direction = direction;
    const double shorter = relative_sag(material, 20, 0.51 * D);
    const double longer = relative_sag(material, 40, 0.51 * D);
    std::printf("strip, axis at %.2f: %+.2f %%, %+.2f %%\n", direction, 100.0 * (shorter - 1.0),
                100.0 * (longer - 1.0));
    EXPECT_NEAR(longer, 1.0, 0.03);
    EXPECT_NEAR(2.0 * longer - shorter, 1.0, 0.005);
  }
}

TEST(GivenBending, RangesIncludeTheirEndsAndNothingBeyond) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::array<std::string, 4> names{"bending_stiffness_1_nm", "bending_stiffness_2_nm", "bending_coupling_nm",
                                         "twisting_stiffness_nm"};
  for (std::size_t i = 0; i < kGiven.size(); ++i) {
    const bool is_coupling = i == 2;
    for (const double bad : {nan, inf, -inf, 1e14 * (1.0 + 1e-15), -1e14 * (1.0 + 1e-15)}) {
      Material material = woven();
      material.*kGiven[i] = bad;
      EXPECT_EQ(refusal(material), "MATERIAL_OUT_OF_RANGE m." + names[i]) << bad;
    }
    for (const double low : {0.0, 1e-25 * (1.0 - 1e-15)}) {
      Material material = woven();
      material.*kGiven[i] = low;
      EXPECT_EQ(refusal(material), is_coupling ? "fine" : "MATERIAL_OUT_OF_RANGE m." + names[i]) << low;
    }
  }
  for (const double end : {1e-25, 1e14}) {
    Material material = woven();
    for (const auto member : kGiven) material.*member = end;
    material.bending_coupling = 0.0;
    EXPECT_EQ(refusal(material), "fine") << end;
    EXPECT_GT(bending_law(material).determinant(), 0.0) << end;
  }
}

TEST(GivenBending, MustMakeAPositiveDefiniteLaw) {
  Material material = woven();  // D11 D22 = (2e-5)^2
  for (const double coupling : {1.999e-5, -1.999e-5}) {
    material.bending_coupling = coupling;
    EXPECT_EQ(refusal(material), "fine");
  }
  for (const double coupling : {2.001e-5, -2.001e-5}) {
    material.bending_coupling = coupling;
    EXPECT_EQ(refusal(material), "MATERIAL_NOT_POSITIVE_DEFINITE m.bending_coupling_nm");
  }
  // Derived, it is that of a solid plate, far stiffer than what was measured.
  material.bending_coupling.reset();
  material.bending_scale = 1.0;
  EXPECT_EQ(refusal(material), "MATERIAL_NOT_POSITIVE_DEFINITE m.bending_coupling_nm");
  EXPECT_NE(validate(material).error().message.find("derived"), std::string::npos);
  material.bending_scale = 0.1;
  EXPECT_EQ(refusal(material), "fine");
  material.bending_scale = 0.0;
  EXPECT_EQ(refusal(material), "fine") << "D12 = 0";
  material.twisting_stiffness.reset();
  EXPECT_EQ(refusal(material), "MATERIAL_NOT_POSITIVE_DEFINITE m.twisting_stiffness_nm");
}

}  // namespace
}  // namespace kerf::fem
