#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/mass_redistribution.h"
#include "server/core/fem/model/model.h"
#include "server/core/mesh/build/grid_mesh.h"

namespace kerf::fem {
namespace {

const Material kCloth = isotropic(4e5, 0.3, 5e-4, 400.0);

mesh::TriangleMesh grid() {
  return mesh::make_grid({30, 30, 1.0, 1.0}).value();
}

// An S-shaped cut from outside to the middle: crosses the border close to a vertex.
mesh::TriangleMesh cut_grid() {
  mesh::TriangleMesh mesh = grid();
  cut::CutRequest request;
  request.curve = cut::CubicBezier{{{0.42, -0.05}, {0.62, 0.1}, {0.38, 0.24}, {0.55, 0.4}}};
  const Result<cut::CutPlan> plan = cut::plan(mesh, request);
  EXPECT_TRUE(plan.ok());
  EXPECT_TRUE(cut::apply(mesh, *plan).ok());
  return mesh;
}

std::vector<double> thirds(const mesh::TriangleMesh& mesh) {
  std::vector<double> mass(static_cast<std::size_t>(mesh.num_vertices()), 0.0);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (const mesh::VertexId v : mesh.vertices(t)) {
      mass[static_cast<std::size_t>(v)] += kCloth.density * kCloth.thickness * mesh.area(t) / 3.0;
    }
  }
  return mass;
}

TEST(MassRedistribution, LeavesSheetsAsGeneratedAlone) {
  for (const mesh::TriangleMesh& mesh : {grid(), mesh::make_jittered_grid({30, 30, 1.0, 1.0}, 3).value()}) {
    const std::vector<double> expected = thirds(mesh);
    const Model model(mesh, kCloth);
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(model.mass()[i], expected[i], 1e-12 * expected[i]);
  }
}

TEST(MassRedistribution, KeepsTheMassAndMovesItOnlyNearTheCut) {
  const mesh::TriangleMesh mesh = cut_grid();
  const Model model(mesh, kCloth);
  const std::vector<double> before = thirds(mesh);
  EXPECT_NEAR(model.masses().total(), kCloth.density * kCloth.thickness * 1.0, 1e-14);
  double moved = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_GT(model.mass()[i], 0.0);
    const double change = std::abs(model.mass()[i] - before[i]);
    moved += 0.5 * change;
    const Eigen::Vector2d at = mesh.rest_position(static_cast<mesh::VertexId>(i));
    const bool near = at.x() > 0.3 && at.x() < 0.7 && at.y() < 0.6;
    EXPECT_TRUE(near || change < 1e-15) << at.transpose();
  }
  EXPECT_GT(moved, 0.0);
  EXPECT_LT(moved, 0.01 * model.masses().total());
}

TEST(MassRedistribution, AnOrdinaryCutAtMostTriplesTheSubsteps) {
  const double whole = std::sqrt(Model(grid(), kCloth).stiffness_bound().value());
  const double cut = std::sqrt(Model(cut_grid(), kCloth).stiffness_bound().value());
  EXPECT_LT(cut, 3.0 * whole);
}

// Cuts all over the sheet: what a vertex gets comes from its tile, and an edit concerns the tiles around it, however
// far the light vertices hang together.
TEST(MassRedistribution, CostsWhatACutTouchesAmongManyOthers) {
  mesh::TriangleMesh mesh = mesh::make_grid({60, 60, 1.0, 1.0}).value();
  Model model(mesh, kCloth);
  SeededRandom random(4);
  std::size_t most = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector2d from(random.uniform(0.05, 0.95), random.uniform(0.05, 0.95));
    const Eigen::Vector2d along(random.uniform(-0.04, 0.04), random.uniform(-0.04, 0.04));
    cut::CutRequest request;
    request.curve = cut::Polyline{{from, from + along}};
    const Result<cut::CutOutcome> outcome = cut::apply(mesh, cut::plan(mesh, request).value());
    ASSERT_TRUE(outcome.ok());
    const MassChange change = model.apply(mesh, outcome->edit);
    if (i >= 300) most = std::max(most, change.num_examined);
  }
  EXPECT_GT(mesh.num_vertices(), 6000);
  EXPECT_LT(most, 800U);
  EXPECT_EQ(model.hash(), Model(mesh, kCloth).hash());
  EXPECT_NEAR(model.masses().total(), kCloth.density * kCloth.thickness, 1e-12 * model.masses().total());
}

TEST(MassRedistribution, StopsWhereThereIsNotEnoughMass) {
  // One triangle: no neighbour to take from, and no vertex above its floor.
  linear::RowStore<mesh::TriangleId> incident;
  incident.resize(3);
  const std::vector<mesh::TriangleId> slot{0};
  for (int v = 0; v < 3; ++v) incident.set_row(v, slot);
  std::vector<ElementBlock> blocks(1);
  for (std::size_t k = 0; k < 3; ++k) blocks[0].vertex[k][0] = static_cast<mesh::VertexId>(k);
  const std::vector<double> floor{1.0, 2.0, 5.0};
  const std::vector<double> lumped{0.1, 0.2, 0.9};
  MassRedistribution redistribution;
  const std::vector<mesh::VertexId> all{0, 1, 2};
  std::vector<double> mass(3, 0.0);
  const std::vector<MassTile> tiles(3, MassTile{0, 0});
  redistribution.update({incident, blocks, lumped, floor, tiles}, all, mass);
  EXPECT_NEAR(mass[0] + mass[1] + mass[2], 1.2, 1e-15);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(mass[i] / floor[i], 0.15, 0.01);
}

TEST(MassRedistribution, CornerStiffnessIsTheTraceOfTheStiffnessBlock) {
  const Eigen::Matrix3d C{{3.0, 0.5, 0.1}, {0.5, 2.0, 0.2}, {0.1, 0.2, 1.5}};
  const double gx = 0.7;
  const double gy = -1.3;
  const Eigen::Matrix<double, 3, 2> B{{gx, 0.0}, {0.0, gy}, {gy, gx}};
  EXPECT_NEAR(corner_stiffness(gx, gy, 0.25, C), 0.25 * (B.transpose() * C * B).trace(), 1e-14);
}

}  // namespace
}  // namespace kerf::fem
