// Forces along borders that are normal to them, or vary along the sheet.
#include <cmath>
#include <numbers>

#include "server/core/fem/element/loads.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using scenes::flat;

scene::EdgeForce normal(scene::Region region, double newtons_per_metre) {
  scene::EdgeForce edge;
  edge.region = std::move(region);
  edge.normal = newtons_per_metre;
  return edge;
}

Vector3d force_at(const Sheet& sheet, mesh::VertexId v) {
  return sheet.loads().external_forces.col(v);
}

TEST(NormalForces, PointAwayFromTheMaterialAsTheSheetIsPlaced) {
  scene::SheetConfig config = flat(5);
  config.placement.x_axis = Vector3d(1.0, 1.0, 0.0).normalized();
  config.placement.y_axis = {0.0, 0.0, 1.0};
  config.loads = {{normal(scene::RegionEdge::kRight, 3.0), {}}};
  Sheet sheet = make(config);
  EXPECT_LT((force_at(sheet, 14) - 0.25 * 3.0 * config.placement.x_axis).norm(), 1e-12);
  EXPECT_LT((force_at(sheet, 4) - 0.125 * 3.0 * config.placement.x_axis).norm(), 1e-12);
  // Dead: where the sheet goes does not matter, nor do cuts through the border.
  run(sheet, 20);
  ASSERT_TRUE(apply(sheet, scenes::line_cut({0.5, 0.4}, {1.2, 0.6})).ok());
  const Vector3d sum = sheet.loads().external_forces.rowwise().sum();
  EXPECT_LT((sum - 3.0 * config.placement.x_axis).norm(), 1e-9);
}

TEST(NormalForces, AroundAHoleAreInBalanceAndPushItOpen) {
  scene::SheetConfig config = flat(4);
  scene::OutlineSource outline;
  outline.boundary = cut::Circle{{0.0, 0.0}, 0.5};
  outline.holes = {cut::Ellipse{{0.1, 0.0}, {0.2, 0.1}, 0.4}};
  outline.edge_length = 0.05;
  config.mesh = outline;
  config.loads = {{normal(scene::NearestBorder{{0.1, 0.0}}, -2.0), {}}};
  const Sheet sheet = make(config);
  Vector3d sum = Vector3d::Zero();
  double area = 0.0;  // m^2, of the hole, by the divergence theorem
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    sum += force_at(sheet, v);
    const Vector2d X = sheet.mesh().rest_position(v);
    area += 0.5 * X.dot(Vector2d(force_at(sheet, v).head<2>())) / 2.0;
  }
  EXPECT_LT(sum.norm(), 1e-12);
  EXPECT_NEAR(area, std::numbers::pi * 0.2 * 0.1, 0.03 * std::numbers::pi * 0.2 * 0.1);
}

TEST(NormalForces, ActOnBothLipsOfACutAgainstEachOther) {
  scene::SheetConfig config = flat(9);
  config.commands = {{1, scenes::line_cut({0.25, 0.5}, {0.75, 0.5})}};
  config.loads = {{normal(scene::MaterialLine{{0.25, 0.5}, {0.75, 0.5}}, -1.0), {}}};
  Sheet sheet = make(config);
  EXPECT_EQ(sheet.loads().external_forces.cwiseAbs().maxCoeff(), 0.0) << "no lips yet";
  sheet.step({});
  double up = 0.0;
  double down = 0.0;
  for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
    (force_at(sheet, v).y() > 0.0 ? up : down) += force_at(sheet, v).y();
  }
  // Equal except for the halves of the last edges that meet at the tips, where both cancel.
  EXPECT_NEAR(up, -down, 1e-12);
  EXPECT_GE(up, 0.5 - 0.125 - 1e-9);
  EXPECT_LT(up, 0.5);
}

TEST(LinearFactors, GiveTheIntegralsOfALinearTraction) {
  scene::SheetConfig config = flat(5);
  scene::EdgeForce edge;
  edge.region = scene::RegionEdge::kRight;
  edge.force = {2.0, 0.0, 0.0};
  edge.is_total = false;
  edge.factor = scene::LinearFactor{{0.7, 0.25}, {0.0, 4.0}};
  config.loads = {{edge, {}}};
  const Sheet sheet = make(config);
  double force = 0.0;
  double moment = 0.0;
  for (int j = 0; j < 5; ++j) {
    force += force_at(sheet, 5 * j + 4).x();
    moment += force_at(sheet, 5 * j + 4).x() * 0.25 * j;
  }
  // Integrals of 8 (y - 1/4) from 0 to 1: 2 and 5/3; hat functions give both exactly.
  EXPECT_NEAR(force, 2.0, 1e-14);
  EXPECT_NEAR(moment, 5.0 / 3.0, 1e-14);
  EXPECT_NEAR(force_at(sheet, 4).x(), 8.0 * (-0.25 * 0.25 / 2.0 + 0.25 * 0.25 / 6.0), 1e-14);
}

TEST(LinearFactors, MultiplyTotalsAndNormalsAlike) {
  scene::SheetConfig config = flat(5);
  config.mesh = scene::GridSource{5, 5, 2.0, 1.0, scene::GridPattern::kUniformDiagonals, 0};
  scene::EdgeForce total;
  total.region = scene::RegionEdge::kTop;
  total.force = {0.0, 6.0, 0.0};
  total.factor = scene::LinearFactor{{0.0, 0.0}, {0.5, 0.0}};  // 0 on the left, 1 on the right
  scene::EdgeForce along = normal(scene::RegionEdge::kTop, 3.0);
  along.factor = total.factor;
  config.loads = {{total, {}}};
  const Sheet of_total = make(config);
  config.loads = {{along, {}}};
  const Sheet of_normal = make(config);
  EXPECT_NEAR(of_total.loads().external_forces.row(1).sum(), 3.0, 1e-12);
  EXPECT_LT((of_total.loads().external_forces - of_normal.loads().external_forces).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(LinearFactors, AreRefusedByName) {
  scene::SheetConfig config = flat(5);
  scene::EdgeForce edge;
  edge.region = scene::RegionEdge::kRight;
  const auto with = [&](const scene::LinearFactor& factor) {
    edge.factor = factor;
    config.loads = {{edge, {}}};
    return refused(config);
  };
  EXPECT_EQ(with({{0.0, 0.0}, {0.0, 0.0}}), "FACTOR_ZERO loads[0].edge.factor.by_x");
  EXPECT_EQ(with({{0.0, 0.0}, {1.0e6, -1.0e6}}), "made");
  EXPECT_EQ(with({{0.0, 0.0}, {0.0, 1.1e6}}), "OUT_OF_RANGE loads[0].edge.factor.by_y");
  EXPECT_EQ(with({{0.0, 1.1e4}, {0.0, 1.0}}), "OUT_OF_RANGE loads[0].edge.factor.zero.y");
  edge.normal = 1.1e12;
  EXPECT_EQ(with({{0.0, 0.0}, {0.0, 1.0}}), "OUT_OF_RANGE loads[0].edge.normal_npm");
  edge.normal = 1.0e12;
  EXPECT_EQ(with({{0.0, 0.0}, {0.0, 1.0}}), "made");
}

}  // namespace
}  // namespace kerf::sheet
