#include "server/core/sheet/vertex_strains.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "server/core/fem/element/material.h"
#include "server/core/sheet/sheet.h"

namespace kerf::sheet {
namespace {

Sheet flat_sheet() {
  scene::SheetConfig config;
  scene::GridSource grid;
  grid.columns = 6;
  grid.rows = 5;
  config.mesh = grid;
  config.material = fem::find_preset("rubber").value();
  return Sheet::create(std::move(config)).value();
}

std::vector<float> strains_under(const Eigen::Matrix3d& map) {
  const Sheet sheet = flat_sheet();
  return dominant_strains(sheet.model(), map * sheet.snapshot()->positions);
}

TEST(DominantStrains, AreThoseOfUniformStretchAndBlindToRotation) {
  // Placed in a plane of the world: stretch is along world axes that lie in it.
  const Sheet sheet = flat_sheet();
  const Eigen::Matrix3Xd x = sheet.snapshot()->positions;
  const Eigen::Vector3d along = (x.col(1) - x.col(0)).normalized();
  const Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity() + 0.08 * along * along.transpose();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
  for (const float strain : strains_under(stretch)) EXPECT_NEAR(strain, 0.08, 1e-6);
  for (const float strain : strains_under(turn * stretch)) EXPECT_NEAR(strain, 0.08, 1e-6);
  for (const float strain : strains_under(turn)) EXPECT_NEAR(strain, 0.0, 1e-6);
}

TEST(DominantStrains, AreBelowZeroWhereTheSheetIsMoreCompressedThanStretched) {
  for (const float strain : strains_under(0.9 * Eigen::Matrix3d::Identity())) EXPECT_NEAR(strain, -0.1, 1e-6);
  const Sheet sheet = flat_sheet();
  const Eigen::Matrix3Xd x = sheet.snapshot()->positions;
  const Eigen::Vector3d along = (x.col(1) - x.col(0)).normalized();
  const Eigen::Vector3d across = (x.col(6) - x.col(0)).normalized();
  const auto under = [&](double first, double second) {
    const Eigen::Matrix3d map =
        Eigen::Matrix3d::Identity() + first * along * along.transpose() + second * across * across.transpose();
    return strains_under(map);
  };
  for (const float strain : under(0.03, -0.05)) EXPECT_NEAR(strain, -0.05, 1e-6);
  for (const float strain : under(0.05, -0.03)) EXPECT_NEAR(strain, 0.05, 1e-6);
  for (const float strain : under(-0.02, -0.05)) EXPECT_NEAR(strain, -0.05, 1e-6);
}

TEST(DominantStrains, AreInASnapshotThatIsAskedForThemAlone) {
  const Sheet sheet = flat_sheet();
  EXPECT_TRUE(sheet.snapshot()->strains.empty());
  EXPECT_EQ(sheet.snapshot({}, true)->strains.size(), 30U);
}

}  // namespace
}  // namespace kerf::sheet
