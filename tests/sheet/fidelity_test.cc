// Sheets whose membrane is softened to fit their tick.
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/step/softening.h"
#include "server/core/scene/sheet_materials.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

constexpr int kTicksToCompare = 18;  // 0.3 s

fem::Material known_material(const char* name) {
  return fem::find_preset(name).value();
}

// Held by an edge, level at first.
scene::SheetConfig level_sheet(const char* material, std::int32_t n, scene::Fidelity fidelity) {
  scene::SheetConfig config = scenes::hanging(n);
  config.placement.y_axis = {0.0, 1.0, 0.0};
  config.material = known_material(material);
  config.fidelity = fidelity;
  return config;
}

// Makes a sheet of wool that is softened 4 times.
scene::SheetConfig softened_wool() {
  return level_sheet("wool", 42, scene::Fidelity::kRealTime);
}

std::int32_t substeps_of_a_tick(Sheet sheet) {
  return sheet.step({}).stats.substeps;
}

// m, the largest distance to the exact sheet after 0.3 s.
double largest_error(const scene::SheetConfig& real_time) {
  scene::SheetConfig config = real_time;
  config.fidelity = scene::Fidelity::kExact;
  Sheet exact = make(config), sheet = make(real_time);
  run(exact, kTicksToCompare);
  run(sheet, kTicksToCompare);
  return (sheet.state().x - exact.state().x).colwise().norm().maxCoeff();
}

TEST(Fidelity, IsExactUnlessAskedFor) {
  EXPECT_EQ(scene::SheetConfig{}.fidelity, scene::Fidelity::kExact);
  Sheet exact = make(level_sheet("demo", 15, scene::Fidelity::kExact));
  EXPECT_FALSE(exact.softening());
  EXPECT_EQ(exact.integrator_description().find("real time"), std::string::npos);
  Sheet sheet = make(level_sheet("demo", 15, scene::Fidelity::kRealTime));
  ASSERT_TRUE(sheet.softening());
  EXPECT_EQ(sheet.softening()->factor, 1) << "fits as it is";
  run(exact, 10);
  run(sheet, 10);
  EXPECT_EQ(sheet.state_hash(), exact.state_hash());
}

TEST(Fidelity, StiffSheetsTakeFewerSubstepsAndBendAsBefore) {
  const Sheet exact = make(level_sheet("wool", 42, scene::Fidelity::kExact));
  const Sheet sheet = make(softened_wool());
  ASSERT_TRUE(sheet.softening());
  EXPECT_EQ(sheet.softening()->factor, 4);
  EXPECT_TRUE(sheet.softening()->fits());
  EXPECT_NE(sheet.integrator_description().find("membrane 4 times softer"), std::string::npos)
      << sheet.integrator_description();
  EXPECT_EQ(sheet.model().elements().law(0).membrane * 4.0, exact.model().elements().law(0).membrane);
  EXPECT_EQ(sheet.model().elements().law(0).bending, exact.model().elements().law(0).bending);
  EXPECT_EQ(sheet.model().masses().total(), exact.model().masses().total());
  EXPECT_EQ(sheet.materials().entries.front(), known_material("wool")) << "as given";
  EXPECT_LT(substeps_of_a_tick(sheet), 0.6 * substeps_of_a_tick(exact));
}

TEST(Fidelity, TheErrorOfWoolIsWithinWhatIsStated) {
  const scene::SheetConfig config = softened_wool();
  const double error = largest_error(config);
  EXPECT_GT(error, 1e-6);
  EXPECT_LT(error, make(config).softening()->expected_error);
}

TEST(Fidelity, TheErrorOfPaperIsWithinWhatIsStated) {
  const scene::SheetConfig config = level_sheet("paper", 40, scene::Fidelity::kRealTime);
  ASSERT_EQ(make(config).softening()->factor, 4);
  const double error = largest_error(config);
  EXPECT_GT(error, 1e-6);
  EXPECT_LT(error, make(config).softening()->expected_error);
}

TEST(Fidelity, CutsUndoAndRedoKeepTheFactorAndAResetGivesItBack) {
  Sheet sheet = make(softened_wool());
  const fem::Material expected = fem::soften(known_material("wool"), 4);
  const std::uint64_t model = sheet.model().hash();
  const auto expect_softened = [&](const char* after) {
    EXPECT_EQ(sheet.softening()->factor, 4) << after;
    EXPECT_EQ(sheet.model().elements().law(sheet.mesh().triangle_at(0)).material, expected) << after;
    EXPECT_NE(sheet.integrator_description().find("4 times softer"), std::string::npos) << after;
  };
  for (scene::Cut& cut : scenes::three_cuts()) ASSERT_TRUE(apply(sheet, std::move(cut)).ok());
  expect_softened("cuts");
  const std::uint64_t cut_model = sheet.model().hash();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  expect_softened("undo");
  EXPECT_EQ(sheet.model().hash(), model);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_EQ(sheet.model().hash(), cut_model);
  ASSERT_TRUE(apply(sheet, scene::SetMaterial{known_material("demo"), std::nullopt}).ok());
  EXPECT_EQ(sheet.softening()->factor, 1);
  EXPECT_EQ(sheet.model().elements().law(sheet.mesh().triangle_at(0)).material, known_material("demo"));
  ASSERT_TRUE(apply(sheet, scene::SetMaterial{known_material("wool"), std::nullopt}).ok());
  EXPECT_EQ(sheet.model().hash(), cut_model) << "chosen on the uncut mesh";
  expect_softened("another material and back");
  ASSERT_TRUE(apply(sheet, scene::SetMaterial{known_material("demo"), std::nullopt}).ok());
  ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
  expect_softened("reset");
  EXPECT_EQ(sheet.model().hash(), model);
}

TEST(Fidelity, CopiesAndRecordingsGoTheSameWay) {
  std::vector<std::vector<scene::Command>> ticks(8);
  ticks[2] = {scenes::three_cuts()[0]};
  ticks[3] = {scene::UndoCut{}};
  ticks[4] = {scene::SetMaterial{known_material("paper"), std::nullopt}};
  ticks[6] = {scene::Reset{}};
  expect_equal_replay(softened_wool(), ticks);
}

TEST(Fidelity, StaticScenesAreExact) {
  scene::SheetConfig config = softened_wool();
  config.analysis = scene::StaticAnalysis{};
  EXPECT_FALSE(make(config).softening());
}

}  // namespace
}  // namespace kerf::sheet
