// Another material while the sheet runs.
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/condition.h"
#include "server/core/fem/model/model.h"
#include "server/core/scene/sheet_materials.h"
#include "server/core/sheet/undo_history.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

fem::Material preset(const char* name) {
  return fem::find_preset(name).value();
}

scene::SetMaterial everywhere(fem::Material material) {
  return {std::move(material), std::nullopt};
}

scene::SetMaterial in_part(fem::Material material, std::int32_t part) {
  return {std::move(material), part};
}

// Wool whose right half is denim, with a spot of silk in the middle. Ticks are short: foil takes many steps.
scene::SheetConfig three_materials() {
  scene::SheetConfig config = scenes::hanging(11);
  config.tick_rate_hz = 480.0;
  config.material = preset("wool");
  config.materials = {{scene::MaterialBox{{0.5, 0.0}, {1.0, 1.0}}, preset("denim")},
                      {scene::MaterialBox{{0.3, 0.3}, {0.7, 0.7}}, preset("silk")}};
  return config;
}

TEST(SetMaterial, TheSheetGoesOnAsOneMadeOfIt) {
  scene::SheetConfig config = scenes::hanging(11);
  config.material = preset("wool");
  Sheet changed = make(config);
  config.material = preset("rubber");
  Sheet made = make(config);
  ASSERT_TRUE(apply(changed, everywhere(preset("rubber"))).ok());
  EXPECT_EQ(changed.model().hash(), made.model().hash());
  EXPECT_EQ(changed.integrator_description(), made.integrator_description());
  run(changed, 20);
  run(made, 20);
  EXPECT_EQ(changed.state().x, made.state().x);
  EXPECT_EQ(changed.state().v, made.state().v);
}

TEST(SetMaterial, KeepsStatePinsGrabsCutsAndHistory) {
  Sheet sheet = make(scenes::hanging(11));
  run(sheet, 5);
  ASSERT_TRUE(apply(sheet, scenes::three_cuts()[0]).ok());
  ASSERT_TRUE(apply(sheet, scene::Grab{"given", 0, std::nullopt, 12.5}).ok());
  ASSERT_TRUE(apply(sheet, scene::Grab{"default", 5, std::nullopt, 0.0}).ok());
  run(sheet, 5);
  const Sheet before = sheet;
  ASSERT_TRUE(apply(sheet, everywhere(preset("silk"))).ok());
  EXPECT_EQ(sheet.state().x, before.state().x);
  EXPECT_EQ(sheet.state().v, before.state().v);
  EXPECT_EQ(sheet.mesh().state_hash(), before.mesh().state_hash());
  EXPECT_EQ(sheet.pinned_vertices(), before.pinned_vertices());
  EXPECT_EQ(sheet.history().num_done(), 1U);
  EXPECT_EQ(sheet.tick(), before.tick());
  EXPECT_EQ(sheet.topology_version(), before.topology_version());
  EXPECT_EQ(sheet.settings_version(), before.settings_version() + 1);
  EXPECT_EQ(sheet.materials().entries, std::vector<fem::Material>{preset("silk")});
  EXPECT_EQ(sheet.model().hash(), fem::Model(sheet.mesh(), preset("silk")).hash());
  EXPECT_NE(sheet.state_hash(), before.state_hash()) << "it will move otherwise";
  EXPECT_EQ(sheet.grabs()[0].stiffness, 12.5);
  Sheet anew = sheet;
  ASSERT_TRUE(apply(anew, scene::Release{"default"}).ok());
  ASSERT_TRUE(apply(anew, scene::Grab{"default", 5, std::nullopt, 0.0}).ok());
  EXPECT_EQ(sheet.grabs()[1].stiffness, anew.grabs()[1].stiffness) << "as stiff as the new material bears";
  EXPECT_NE(sheet.grabs()[1].stiffness, before.grabs()[1].stiffness);
  EXPECT_NEAR(sheet.pieces()[0].mass, sheet.model().masses().total(), 1e-12);
}

TEST(SetMaterial, OnePartAtATime) {
  Sheet sheet = make(three_materials());
  const double mass = sheet.model().masses().total();
  const auto density = [](const fem::Material& m) { return m.density * m.thickness; };
  ASSERT_TRUE(apply(sheet, in_part(preset("rubber"), 1)).ok());
  EXPECT_NEAR(sheet.model().masses().total() - mass, 0.16 * (density(preset("rubber")) - density(preset("silk"))),
              1e-9);
  ASSERT_TRUE(apply(sheet, in_part(preset("cotton"), scene::SetMaterial::kOwn)).ok());
  const std::vector<fem::Material> expected{preset("cotton"), preset("denim"), preset("rubber")};
  EXPECT_EQ(sheet.materials().entries, expected);
  scene::SheetConfig config = three_materials();
  config.material = preset("cotton");
  config.materials[1].material = preset("rubber");
  EXPECT_EQ(sheet.model().hash(), make(config).model().hash());
  EXPECT_EQ(reason(apply(sheet, in_part(preset("silk"), 2))), "UNKNOWN_PART");
  ASSERT_TRUE(apply(sheet, everywhere(preset("foil"))).ok());
  EXPECT_EQ(sheet.materials().entries, std::vector<fem::Material>(3, preset("foil")));
  EXPECT_NEAR(sheet.model().masses().total(), density(preset("foil")), 1e-12);
}

TEST(SetMaterial, PartsThatWereEqualAreOneAndCoveredOnesAreNowhere) {
  scene::SheetConfig config = scenes::hanging(9);
  config.materials = {{scene::MaterialBox{{0.0, 0.0}, {0.5, 0.5}}, preset("denim")},
                      {scene::MaterialBox{{0.5, 0.5}, {1.0, 1.0}}, preset("denim")},
                      {scene::MaterialBox{{0.0, 0.5}, {0.5, 1.0}}, preset("silk")},
                      {scene::MaterialBox{{0.0, 0.5}, {0.5, 1.0}}, preset("foil")}};
  Sheet sheet = make(config);
  const std::uint64_t model = sheet.model().hash();
  const Result<scene::CommandReply> shared = apply(sheet, in_part(preset("wool"), 1));
  ASSERT_EQ(reason(shared), "MATERIAL_SHARED");
  EXPECT_EQ(shared.error().message.substr(0, 19), "part 1 and part 0 h");
  EXPECT_EQ(sheet.model().hash(), model);
  ASSERT_TRUE(apply(sheet, in_part(preset("wool"), 2)).ok()) << "covered by the one after it";
  EXPECT_EQ(sheet.model().hash(), model);
  EXPECT_EQ(sheet.materials().entries[3], preset("wool"));
}

TEST(SetMaterial, CutsUnderAnotherMaterialAreUndoneAndMadeAgain) {
  Sheet sheet = make(three_materials());
  run(sheet, 3);
  const std::uint64_t uncut = sheet.mesh().state_hash();
  ASSERT_TRUE(apply(sheet, scenes::three_cuts()[0]).ok());
  ASSERT_TRUE(apply(sheet, in_part(preset("foil"), 0)).ok());
  ASSERT_TRUE(apply(sheet, scenes::three_cuts()[2]).ok());
  run(sheet, 3);
  const std::uint64_t cut = sheet.mesh().state_hash();
  ASSERT_TRUE(apply(sheet, everywhere(preset("silk"))).ok());
  const auto expect_model_of_mesh = [&sheet] {
    EXPECT_EQ(sheet.model().hash(), fem::Model(sheet.mesh(), sheet.materials().by_region).hash());
    run(sheet, 3);
    EXPECT_TRUE(sheet.state().x.allFinite());
  };
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
    expect_model_of_mesh();
  }
  EXPECT_EQ(sheet.mesh().state_hash(), uncut);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
    expect_model_of_mesh();
  }
  EXPECT_EQ(sheet.mesh().state_hash(), cut);
}

TEST(SetMaterial, ARecordingWithItReplaysBitForBit) {
  std::vector<std::vector<scene::Command>> ticks(20);
  ticks[2] = {scenes::three_cuts()[0]};
  ticks[5] = {everywhere(preset("foil")), in_part(preset("rubber"), 1)};
  ticks[9] = {scene::UndoCut{}};
  ticks[12] = {scene::RedoCut{}, in_part(preset("silk"), scene::SetMaterial::kOwn)};
  ticks[16] = {scene::Reset{}};
  expect_equal_replay(three_materials(), ticks);
}

TEST(SetMaterial, ACopyGoesOnEqually) {
  Sheet sheet = make(three_materials());
  run(sheet, 2);
  ASSERT_TRUE(apply(sheet, in_part(preset("rubber"), 1)).ok());
  Sheet copy = sheet;
  run(sheet, 10);
  run(copy, 10);
  EXPECT_EQ(copy.state_hash(), sheet.state_hash());
}

TEST(SetMaterial, TooStiffIsRefusedWithTheNumberAndChangesNothing) {
  scene::SheetConfig config = scenes::hanging(9);
  config.tick_rate_hz = 1.0;
  Sheet sheet = make(config);
  run(sheet, 3);
  fem::Material diamond = preset("foil");
  diamond.youngs_modulus_1 = diamond.youngs_modulus_2 = 1.0e12;
  diamond.shear_modulus = 4.0e11;
  diamond.density = 0.01;
  config.material = diamond;
  ASSERT_EQ(refused(config), "SHEET_TOO_STIFF material.youngs_modulus_pa");
  const std::uint64_t state = sheet.state_hash(), model = sheet.model().hash();
  const std::int32_t settings = sheet.settings_version();
  const Result<scene::CommandReply> reply = apply(sheet, everywhere(diamond));
  ASSERT_EQ(reason(reply), "SHEET_TOO_STIFF");
  EXPECT_EQ(reply.error().field, "set_material.material.youngs_modulus_pa");
  const double condition = fem::condition_number(fem::Model(sheet.mesh(), diamond), 1.0);
  EXPECT_EQ(reply.error().message.find(fem::describe_condition(condition)), 0U);
  EXPECT_EQ(sheet.state_hash(), state);
  EXPECT_EQ(sheet.model().hash(), model);
  EXPECT_EQ(sheet.settings_version(), settings);
  Sheet untouched = make(scenes::hanging(9));
  EXPECT_EQ(sheet.materials().entries, untouched.materials().entries);
}

TEST(SetMaterial, IsRefusedOutOfItsRanges) {
  Sheet sheet = make(scenes::hanging(5));
  fem::Material bad = preset("wool");
  bad.thickness = 2.0;
  const Result<scene::CommandReply> thick = apply(sheet, everywhere(bad));
  ASSERT_FALSE(thick.ok());
  EXPECT_EQ(thick.error().field, "set_material.material.thickness_m");
  EXPECT_EQ(apply(sheet, in_part(preset("wool"), -2)).error().field, "set_material.part");
  EXPECT_EQ(apply(sheet, in_part(preset("wool"), 64)).error().field, "set_material.part");
  EXPECT_EQ(reason(apply(sheet, in_part(preset("wool"), 0))), "UNKNOWN_PART");
}

TEST(SetMaterial, AResetGoesBackToTheScenes) {
  Sheet sheet = make(three_materials());
  const std::uint64_t shape = sheet.shape_hash(), model = sheet.model().hash();
  ASSERT_TRUE(apply(sheet, everywhere(preset("foil"))).ok());
  EXPECT_NE(sheet.shape_hash(), shape);
  run(sheet, 5);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_EQ(sheet.shape_hash(), shape);
  EXPECT_EQ(sheet.model().hash(), model);
}

TEST(SetMaterial, TheSceneSOwnMaterialSetAgainLeavesTheHashAlone) {
  Sheet sheet = make(three_materials());
  const std::uint64_t state = sheet.state_hash();
  ASSERT_TRUE(apply(sheet, in_part(preset("foil"), 0)).ok());
  ASSERT_TRUE(apply(sheet, in_part(preset("denim"), 0)).ok());
  EXPECT_EQ(sheet.state_hash(), state);
}

TEST(SetMaterial, APlanarSheetStillBendsNowhere) {
  scene::SheetConfig config = scenes::hanging(7);
  config.planar = true;
  Sheet sheet = make(config);
  ASSERT_TRUE(apply(sheet, everywhere(preset("denim"))).ok());
  EXPECT_FALSE(sheet.model().materials().has_bending());
  EXPECT_EQ(sheet.materials().entries[0], fem::without_bending(preset("denim")));
}

TEST(SetMaterial, AThickerSheetLiesHigher) {
  scene::SheetConfig config = scenes::lying_on_floor(7);
  Sheet sheet = make(config);
  fem::Material thick = config.material;
  thick.thickness = 0.02;
  ASSERT_TRUE(apply(sheet, everywhere(thick)).ok());
  run(sheet, 240);
  EXPECT_NEAR(sheet.state().x.row(2).minCoeff(), 0.01, 1e-3);
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  run(sheet, 60);
  EXPECT_NEAR(sheet.state().x.row(2).minCoeff(), 0.5 * config.material.thickness, 1e-4);
}

TEST(SetMaterial, WakesASheetAtRest) {
  Sheet sheet = make(scenes::lying_on_floor(5));
  for (int i = 0; i < 2000 && !sheet.at_rest(); ++i) run(sheet, 1);
  ASSERT_TRUE(sheet.at_rest());
  ASSERT_TRUE(apply(sheet, everywhere(preset("rubber"))).ok());
  EXPECT_FALSE(sheet.at_rest());
}

TEST(SetMaterial, OfASheetWithASlopeHeldAndAMomentIsTheModelOfAFreshOne) {
  scene::SheetConfig config = scenes::flat(9);
  scene::Constraint clamp = hold(scene::RegionEdge::kLeft);
  clamp.slope = true;
  config.constraints = {clamp};
  config.material = preset("rubber");
  scene::Load moment;
  moment.kind = scene::EdgeMoment{scene::RegionEdge::kRight, 1.0e-4, true};
  config.loads = {moment};
  Sheet changed = make(config);
  ASSERT_TRUE(apply(changed, everywhere(preset("paper"))).ok());
  config.material = preset("paper");
  Sheet made = make(config);
  EXPECT_EQ(changed.model().hash(), made.model().hash());
  run(changed, 10);
  run(made, 10);
  EXPECT_EQ(changed.state().x, made.state().x);
}

}  // namespace
}  // namespace kerf::sheet
