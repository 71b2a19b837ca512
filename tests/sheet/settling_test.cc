// Equilibria of sheets: Sheet::settle and Sheet::bend_by_angles.
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/statics/equilibrium.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

using scenes::flat;

TEST(Settling, FindsTheEquilibriumOfTheLoadAndLeavesTheTickAlone) {
  scene::SheetConfig config = flat(9);
  config.planar = true;
  config.constraints = {hold(scene::RegionEdge::kBottom), hold(scene::NearestVertex{{0.5, 0.0}})};
  config.constraints[0].held = {false, true, false};
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kTop, {0.0, 2.0, 0.0}, true}, {}}};
  Sheet sheet = make(config);
  const fem::Material& material = sheet.model().materials()[0].material;
  for (const double load : {0.5, 1.0}) {
    const fem::EquilibriumStats stats = sheet.settle(load, {}, {});
    EXPECT_TRUE(stats.converged);
    const double strain = 2.0 * load / (material.youngs_modulus_1 * material.thickness);
    EXPECT_NEAR(sheet.state().x(1, 76), 1.0 + strain, 1e-9 * strain);
    EXPECT_NEAR(sheet.state().x(0, 80) - sheet.state().x(0, 72), 1.0 - material.poissons_ratio_12 * strain, 1e-9);
  }
  EXPECT_EQ(sheet.tick(), 0);
  EXPECT_EQ(sheet.state().v.cwiseAbs().maxCoeff(), 0.0);
}

TEST(Settling, BendsByAnglesUntilTheNextStep) {
  scene::SheetConfig config = flat(9);
  config.pins = {scene::RegionEdge::kTop};
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  Sheet sheet = make(config);
  Sheet other = sheet;
  EXPECT_TRUE(sheet.settle(1.0, {}, {}).converged);
  EXPECT_NE(sheet.model().bending().angles(), nullptr);
  EXPECT_EQ(other.model().bending().angles(), nullptr);
  other = sheet;
  other.bend_by_angles();
  for (Sheet* each : {&sheet, &other}) {
    each->step({});
    EXPECT_EQ(each->model().bending().angles(), nullptr);
  }
  EXPECT_EQ(sheet.state_hash(), other.state_hash());
}

TEST(Settling, LeavesTheStateAloneWhereNoEquilibriumIsFound) {
  scene::SheetConfig config = flat(9);  // nothing holds it
  config.loads = {{scene::EdgeForce{scene::RegionEdge::kTop, {0.0, 2.0, 0.0}, true}, {}}};
  Sheet sheet = make(config);
  fem::EquilibriumOptions options;
  options.max_iterations = 5;
  const std::uint64_t before = sheet.shape_hash();
  EXPECT_FALSE(sheet.settle(1.0, options, {}).converged);
  EXPECT_EQ(sheet.shape_hash(), before);
}

TEST(Settling, StopsWhenTheWatchSaysSo) {
  scene::SheetConfig config = flat(9);
  config.pins = {scene::RegionEdge::kTop};
  config.gravity = {0.0, 0.0, -9.81};
  Sheet sheet = make(config);
  int calls = 0;
  const fem::EquilibriumStats stats = sheet.settle(1.0, {}, [&](const fem::EquilibriumStats&) { return ++calls < 3; });
  EXPECT_EQ(calls, 3);
  EXPECT_FALSE(stats.converged);
}

}  // namespace
}  // namespace kerf::sheet
