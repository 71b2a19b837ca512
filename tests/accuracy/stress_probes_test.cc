// Stress where it is concentrated, by both ways to recover it from triangles, against closed forms.
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/accuracy/scene_file.h"
#include "tests/support/paths.h"

namespace kerf::accuracy {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFarStress = 1000.0;  // Pa, along x
constexpr double kRadius = 0.01;       // m, of the hole

scene::Probe stress_at(const std::string& name, std::vector<Vector2d> points, scene::Recovery recovery) {
  scene::Probe probe;
  probe.name = name;
  probe.quantity = scene::Quantity::kStress;
  probe.points = std::move(points);
  probe.recovery = recovery;
  return probe;
}

// The row of the probes at the equilibrium, over the stress far away.
std::vector<double> measured(const scene::SheetConfig& config) {
  const Result<offline::SceneRun> done = offline::run_scene(config, {});
  if (!done.ok()) {
    ADD_FAILURE() << done.error().message;
    return {};
  }
  EXPECT_TRUE(done->result.static_().converged());
  const auto& values = done->result.tables(0).rows(0).values();
  std::vector<double> row(values.begin() + 1, values.end());  // without the load
  for (double& value : row) value /= kFarStress;
  return row;
}

// Kirsch 1898: xx, yy, xy around a hole of radius 1 in a plate under tension 1 along x.
Vector3d kirsch(double r, double angle) {
  const double q = 1.0 / (r * r);
  const double c = std::cos(angle), s = std::sin(angle);
  const double c2 = std::cos(2.0 * angle), s2 = std::sin(2.0 * angle);
  const double rr = 0.5 * (1.0 - q) + 0.5 * (1.0 - 4.0 * q + 3.0 * q * q) * c2;
  const double tt = 0.5 * (1.0 + q) - 0.5 * (1.0 + 3.0 * q * q) * c2;
  const double rt = -0.5 * (1.0 + 2.0 * q - 3.0 * q * q) * s2;
  return {rr * c * c + tt * s * s - 2.0 * rt * s * c, rr * s * s + tt * c * c + 2.0 * rt * s * c,
          (rr - tt) * s * c + rt * (c * c - s * s)};
}

// On circles around the hole that the cutter made, root mean squares.
TEST(StressProbes, PatchesAreNearerToKirschThanTrianglesAllAroundTheHole) {
  constexpr int kPoints = 180;
  constexpr std::array<double, 5> kCircles{1.0, 1.02, 1.1, 1.5, 3.0};
  constexpr std::array<scene::Recovery, 2> kRecoveries{scene::Recovery::kMean, scene::Recovery::kPatch};
  scene::SheetConfig config = read_scene_file(test::source_path("tests/data/scenes/reference/04a_kirsch.json")).value();
  config.probes.clear();
  const auto angle = [](int point) { return 2.0 * std::numbers::pi * point / kPoints; };
  for (const double r : kCircles) {
    std::vector<Vector2d> points;
    for (int i = 0; i < kPoints; ++i) {
      points.emplace_back(0.05 + r * kRadius * std::cos(angle(i)), 0.05 + r * kRadius * std::sin(angle(i)));
    }
    for (const scene::Recovery recovery : kRecoveries) {
      config.probes.push_back(stress_at("p" + std::to_string(config.probes.size()), points, recovery));
    }
  }
  const std::vector<double> row = measured(config);
  ASSERT_EQ(row.size(), 3U * kPoints * 2 * kCircles.size());
  std::size_t column = 0;
  for (const double r : kCircles) {
    std::array<double, 2> rms{};
    for (double& each : rms) {
      for (int i = 0; i < kPoints; ++i, column += 3) {
        each += (Vector3d(row[column], row[column + 1], row[column + 2]) - kirsch(r, angle(i))).squaredNorm() / kPoints;
      }
      each = std::sqrt(each);
    }
    std::printf("Kirsch, r = %.2f: triangles %.4f, patches %.4f\n", r, rms[0], rms[1]);
    EXPECT_LT(rms[1], 0.05) << r;
    EXPECT_LT(rms[1], (r == 1.0 ? 0.9 : 0.5) * rms[0]) << r;  // on the rim the mesh that the cut left decides
  }
}

// A ring of radial x (2 radial) cells that grow outwards, to 20 radii: for a plate without end.
scene::ArraySource ring(int radial) {
  const int around = 2 * radial;
  scene::ArraySource arrays;
  arrays.material_positions.resize(2, around * (radial + 1));
  arrays.triangles.resize(3, 2 * around * radial);
  int t = 0;
  for (int j = 0; j < around; ++j) {
    const double angle = 2.0 * std::numbers::pi * j / around;
    for (int i = 0; i <= radial; ++i) {
      const double r = kRadius * std::pow(20.0, static_cast<double>(i) / radial);
      const int a = j * (radial + 1) + i;
      arrays.material_positions.col(a) << r * std::cos(angle), r * std::sin(angle);
      if (i == radial) continue;
      const int d = (j + 1) % around * (radial + 1) + i;
      arrays.triangles.col(t++) = Eigen::Vector3i(a, a + 1, d + 1);
      arrays.triangles.col(t++) = Eigen::Vector3i(a, d + 1, d);
    }
  }
  return arrays;
}

// Its border moved as a plate without a hole would move.
scene::SheetConfig pulled_ring(const fem::Material& material, int radial) {
  scene::SheetConfig config;
  const scene::ArraySource arrays = ring(radial);
  std::vector<mesh::VertexId> border;
  for (Eigen::Index v = 0; v < arrays.material_positions.cols(); ++v) {
    if (arrays.material_positions.col(v).norm() > 19.9 * kRadius) border.push_back(static_cast<mesh::VertexId>(v));
  }
  config.mesh = arrays;
  config.material = material;
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.gravity.setZero();
  config.planar = true;
  scene::Constraint constraint;
  constraint.region = border;
  constraint.stretch(0, 0) = kFarStress / material.youngs_modulus_1;
  constraint.stretch(1, 1) = -material.poissons_ratio_12 * constraint.stretch(0, 0);
  config.constraints = {constraint};
  config.analysis = scene::StaticAnalysis{};
  return config;
}

struct Concentration {
  double mean = 0.0, patch = 0.0, peak = 0.0;  // at the top of the hole; the greatest by patches. Relative errors
};

Concentration concentration_errors(const fem::Material& material, int radial) {
  scene::SheetConfig config = pulled_ring(material, radial);
  const std::vector<Vector2d> top{{0.0, kRadius}};
  config.probes = {stress_at("mean", top, scene::Recovery::kMean), stress_at("patch", top, scene::Recovery::kPatch)};
  scene::Probe peak = stress_at("peak", {}, scene::Recovery::kPatch);
  peak.region = scene::WholeSheet{};
  peak.reduce = scene::Reduce::kMax;
  config.probes.push_back(peak);
  const std::vector<double> row = measured(config);
  const double exact =
      1.0 +
      std::sqrt(2.0 * (std::sqrt(material.youngs_modulus_1 / material.youngs_modulus_2) - material.poissons_ratio_12) +
                material.youngs_modulus_1 / material.shear_modulus);
  if (row.size() != 9) return {};
  const Concentration errors{row[0] / exact - 1.0, row[3] / exact - 1.0, row[6] / exact - 1.0};
  std::printf("Kt %.3f, %d cells: mean %+.1f %%, patch %+.1f %%, peak %+.1f %%\n", exact, radial, 100.0 * errors.mean,
              100.0 * errors.patch, 100.0 * errors.peak);
  return errors;
}

// Lekhnitskii 1968, Anisotropic Plates: of an infinite plate 1 + sqrt(2 (sqrt(E1 / E2) - nu12) + E1 / G); isotropic: 3.
TEST(StressProbes, PatchesFindConcentrationsThatMeansMissAndFasterWithTheMesh) {
  const fem::Material isotropic = fem::isotropic(1.0e7, 0.3, 1.0e-3, 1000.0);
  fem::Material orthotropic = isotropic;
  orthotropic.youngs_modulus_2 = 2.0e6;
  orthotropic.shear_modulus = 1.0e6;
  for (const fem::Material& material : {isotropic, orthotropic}) {
    const Concentration coarse = concentration_errors(material, 48);
    const Concentration fine = concentration_errors(material, 96);
    EXPECT_LT(std::abs(fine.patch), 0.5 * std::abs(coarse.patch));
    EXPECT_LT(std::abs(fine.patch), 0.65 * std::abs(fine.mean));
    EXPECT_LT(fine.patch / fine.mean, 0.9 * coarse.patch / coarse.mean);
    EXPECT_NEAR(fine.peak, fine.patch, 0.02) << "it is the greatest";
  }
}

}  // namespace
}  // namespace kerf::accuracy
