// Self-contact that is turned on, off or changed while the sheet runs, and its thickness.
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/softening.h"
#include "server/core/mesh/triangle_mesh.h"
#include "server/core/sheet/undo_history.h"
#include "tests/sheet/calls.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"

namespace kerf::sheet {
namespace {

scene::SetSelfContact turned(bool is_on) {
  return {is_on, std::nullopt, std::nullopt};
}

scene::SetSelfContact with_friction(double friction) {
  return {std::nullopt, friction, std::nullopt};
}

scene::SetSelfContact with_thickness(double thickness) {
  return {std::nullopt, std::nullopt, thickness};
}

scene::SetSelfContact of_material() {
  return {std::nullopt, std::nullopt, std::nullopt, true};
}

// So stiff that its automatic integrator is implicit.
scene::SheetConfig too_stiff() {
  scene::SheetConfig config = scenes::hanging(20);
  config.material = fem::isotropic(5.0e11, 0.3, 5.0e-4, 1000.0);
  return config;
}

std::int64_t num_intersections(const Sheet& sheet) {
  return contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x);
}

// Returns the distance of the two layers after one was thrown on the other, m.
double step_between_layers(Sheet& sheet, int ticks = 60) {
  run(sheet, ticks);
  const std::vector<scene::Piece> pieces = sheet.pieces();
  EXPECT_EQ(pieces.size(), 2U);
  return pieces[1].world_centroid.z() - pieces[0].world_centroid.z();
}

TEST(SelfContactThickness, KeepsLayersThatFarApart) {
  scene::SheetConfig config = scenes::thrown_on_a_layer(12);
  config.self_contact.is_on = true;
  Sheet plain = make(config);
  const double before = step_between_layers(plain);
  const double thickness = 6.0 * config.material.thickness;
  config.self_contact.thickness = thickness;
  Sheet thick = make(config);
  const double apart = step_between_layers(thick);
  EXPECT_GT(apart, 2.0 * before);
  EXPECT_GT(apart, 0.7 * thickness);
  EXPECT_LT(apart, 1.1 * thickness);
}

TEST(SelfContactThickness, ThatOfTheMaterialsIsTheDefault) {
  scene::SheetConfig config = scenes::thrown_on_a_layer(12);
  config.self_contact.is_on = true;
  Sheet plain = make(config);
  config.self_contact.thickness = config.material.thickness;
  Sheet given = make(config);
  run(plain, 20);
  run(given, 20);
  EXPECT_EQ(given.state_hash(), plain.state_hash());
}

TEST(SelfContactThickness, StaysFiniteAtBothEndsOfItsRange) {
  for (const double thickness : {scene::kMinSelfThickness, scene::kMaxSelfThickness}) {
    scene::SheetConfig config = scenes::thrown_on_a_layer(8);
    config.self_contact = {true, 0.3, thickness};
    Sheet sheet = make(config);
    for (int i = 0; i < 20; ++i) ASSERT_FALSE(sheet.step({}).frozen) << thickness;
    EXPECT_EQ(num_intersections(sheet), 0) << thickness;
  }
}

TEST(SetSelfContact, FieldsNotGivenStayAndChangesCount) {
  Sheet sheet = make(scenes::hanging(6));
  const std::int32_t version = sheet.settings_version();
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  EXPECT_EQ(sheet.self_contact(), (scene::SelfContact{true, 0.3, {}}));
  ASSERT_TRUE(apply(sheet, with_friction(0.0)).ok());
  ASSERT_TRUE(apply(sheet, with_thickness(0.002)).ok());
  EXPECT_EQ(sheet.self_contact(), (scene::SelfContact{true, 0.0, 0.002}));
  ASSERT_TRUE(apply(sheet, turned(false)).ok());
  EXPECT_EQ(sheet.self_contact(), (scene::SelfContact{false, 0.0, 0.002}));
  ASSERT_TRUE(apply(sheet, scene::SetSelfContact{}).ok());
  EXPECT_EQ(sheet.self_contact(), (scene::SelfContact{false, 0.0, 0.002}));
  EXPECT_EQ(sheet.settings_version(), version + 5);
  ASSERT_TRUE(apply(sheet, of_material()).ok());
  EXPECT_EQ(sheet.self_contact(), (scene::SelfContact{false, 0.0, {}}));
  EXPECT_EQ(sheet.config().self_contact, scene::SelfContact{}) << "as given";
}

TEST(SetSelfContact, IsRefusedOutOfItsRanges) {
  Sheet sheet = make(scenes::hanging(5));
  const auto field = [&](const scene::SetSelfContact& change) {
    const Result<scene::CommandReply> reply = apply(sheet, change);
    return reply.ok() ? "done" : reply.error().field;
  };
  EXPECT_EQ(field(with_friction(0.0)), "done");
  EXPECT_EQ(field(with_friction(scene::kMaxSelfFriction)), "done");
  const scene::SelfContact before = sheet.self_contact();
  for (const double friction : {-1e-9, 10.001, kNan, kInfinity}) {
    EXPECT_EQ(field(with_friction(friction)), "set_self_contact.friction");
  }
  for (const double thickness : {0.0, 0.999e-6, -1e-9, 0.1001, kNan, kInfinity}) {
    EXPECT_EQ(field(with_thickness(thickness)), "set_self_contact.thickness_m");
    EXPECT_EQ(field({true, 0.5, thickness}), "set_self_contact.thickness_m");
  }
  EXPECT_EQ(field({true, 0.5, 0.01, true}), "set_self_contact.material_thickness");
  EXPECT_EQ(sheet.self_contact(), before) << "nothing of them was done";
  EXPECT_EQ(field(with_thickness(scene::kMinSelfThickness)), "done");
  EXPECT_EQ(field(with_thickness(scene::kMaxSelfThickness)), "done");
}

TEST(SetSelfContact, ImplicitStepsHaveItToo) {
  scene::SheetConfig config = scenes::falls_on_edge(10);
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  Sheet sheet = make(config);
  run(sheet, 10);
  const std::string integrator = sheet.integrator_description();
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  EXPECT_EQ(sheet.integrator_description(), integrator);
  std::uint32_t flags = 0;
  for (int i = 0; i < 60; ++i) {
    const TickReport report = sheet.step({});
    ASSERT_FALSE(report.frozen);
    flags |= report.stats.flags;
    ASSERT_EQ(num_intersections(sheet), 0) << i;
  }
  EXPECT_NE(flags & fem::kSplitContact, 0U);
}

TEST(SetSelfContact, IsRefusedForAPlanarSheet) {
  scene::SheetConfig config = scenes::hanging(6);
  config.planar = true;
  Sheet sheet = make(config);
  const Result<scene::CommandReply> reply = apply(sheet, turned(true));
  ASSERT_EQ(reason(reply), "SELF_CONTACT_PLANAR");
  EXPECT_EQ(reply.error().field, "set_self_contact.mode");
  EXPECT_FALSE(sheet.self_contact().is_on);
}

TEST(SetSelfContact, AutomaticStepsAreRatherExplicitWhileItIsOn) {
  scene::SheetConfig config = scenes::hanging(20);
  const auto stiff = [](double density) {
    return scene::SetMaterial{fem::isotropic(5.0e11, 0.3, 5.0e-4, density), std::nullopt};
  };
  Sheet sheet = make(config);
  const auto says = [&](const std::string& text) {
    EXPECT_EQ(sheet.integrator_description().find("automatic: " + text), 0U) << sheet.integrator_description();
  };
  ASSERT_TRUE(apply(sheet, stiff(1000.0)).ok());
  says("TR-BDF2");
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  says("explicit, preferred for self-contact; ");
  ASSERT_TRUE(apply(sheet, stiff(50.0)).ok());
  says("SDIRK2");
  ASSERT_TRUE(apply(sheet, stiff(1000.0)).ok());
  says("explicit, preferred for self-contact; ");
  ASSERT_TRUE(apply(sheet, turned(false)).ok());
  says("TR-BDF2");
}

TEST(SetSelfContact, ARealTimeSheetIsSoftenedForExplicitStepsWhileItIsOn) {
  scene::SheetConfig config = too_stiff();
  const scene::SetMaterial stiff{config.material, std::nullopt};
  config.material = scenes::demo_material();
  config.fidelity = scene::Fidelity::kRealTime;
  Sheet off = make(config), changed = make(config);
  ASSERT_TRUE(apply(changed, turned(true)).ok());
  config.self_contact.is_on = true;
  Sheet made = make(config);
  for (Sheet* each : {&off, &changed, &made}) ASSERT_TRUE(apply(*each, stiff).ok());
  EXPECT_EQ(changed.softening()->cost, made.softening()->cost);
  EXPECT_NE(changed.softening()->cost, off.softening()->cost);
}

TEST(SetSelfContact, OnAndOffAgainWhereNothingTouchedLeavesTheBits) {
  for (const bool is_cut : {false, true}) {
    scene::SheetConfig config = scenes::hung_by_corner(12);
    config.placement.origin.z() += 2.0;
    Sheet changed = make(config), other = make(config);
    if (is_cut) {
      scene::Cut ring = scenes::circle_cut({0.5, 0.5}, 0.2);
      ring.options.width_m = 0.05;  // so that no lips coincide
      for (Sheet* each : {&changed, &other}) ASSERT_TRUE(apply(*each, ring).ok());
    }
    run(changed, 3);
    run(other, 3);
    ASSERT_TRUE(apply(changed, turned(true)).ok());
    EXPECT_NE(changed.state_hash(), other.state_hash()) << "it may move otherwise";
    EXPECT_EQ(changed.state().x, other.state().x);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(changed.step({}).stats.self_contact.contacts, 0);
    ASSERT_TRUE(apply(changed, turned(false)).ok());
    run(other, 5);
    ASSERT_EQ(changed.state_hash(), other.state_hash());
    run(changed, 5);
    run(other, 5);
    EXPECT_EQ(changed.state_hash(), other.state_hash());
  }
}

TEST(SetSelfContact, ASheetThatIsTurnedOnIsOneMadeWithIt) {
  scene::SheetConfig config = scenes::falls_in_strips(12);  // whose lips coincide
  Sheet changed = make(config);
  ASSERT_TRUE(apply(changed, scene::SetSelfContact{true, 0.5, 0.001}).ok());
  config.self_contact = {true, 0.5, 0.001};
  Sheet made = make(config);
  EXPECT_EQ(changed.integrator_description(), made.integrator_description());
  std::int64_t contacts = 0;
  for (int i = 0; i < 60; ++i) {
    contacts += changed.step({}).stats.self_contact.contacts;
    made.step({});
    ASSERT_EQ(changed.state().x, made.state().x) << "after tick " << i + 1;
    ASSERT_EQ(changed.state().v, made.state().v);
  }
  EXPECT_GT(contacts, 0);
  EXPECT_EQ(num_intersections(changed), 0);
}

TEST(SetSelfContact, LayersRestFartherApartWithALargerThickness) {
  scene::SheetConfig config = scenes::thrown_on_a_layer(12);
  config.self_contact.is_on = true;
  Sheet sheet = make(config);
  const double before = step_between_layers(sheet);
  const double thickness = 6.0 * config.material.thickness;
  ASSERT_TRUE(apply(sheet, with_thickness(thickness)).ok());
  const double apart = step_between_layers(sheet, 120);
  EXPECT_GT(apart, 2.0 * before);
  EXPECT_LT(apart, 1.1 * thickness);
  ASSERT_TRUE(apply(sheet, of_material()).ok());
  EXPECT_LT(step_between_layers(sheet, 120), 1.1 * config.material.thickness) << "that of the material again";
}

TEST(SetSelfContact, TurnedOffFoldsPassThroughEachOther) {
  Sheet sheet = make([] {
    scene::SheetConfig config = scenes::falls_on_edge(12);
    config.self_contact.is_on = true;
    return config;
  }());
  run(sheet, 30);
  EXPECT_EQ(num_intersections(sheet), 0);
  ASSERT_TRUE(apply(sheet, turned(false)).ok());
  std::int64_t most = 0;
  for (int i = 0; i < 60; ++i) {
    const fem::SelfContactStats stats = sheet.step({}).stats.self_contact;
    EXPECT_EQ(stats.phases + stats.intersections, 0);
    most = std::max(most, num_intersections(sheet));
  }
  EXPECT_GT(most, 10);
  // Folds that pass through each other already are counted, not taken apart.
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  const TickReport report = sheet.step({});
  EXPECT_FALSE(report.frozen);
  EXPECT_GT(report.stats.self_contact.phases, 0);
  EXPECT_EQ(report.stats.self_contact.intersections, num_intersections(sheet));
}

TEST(SetSelfContact, AResetGoesBackToTheScenesAndItsUndoBringsItBack) {
  scene::SheetConfig config = scenes::falls_on_edge(8);
  for (const bool is_on : {false, true}) {
    config.self_contact = {is_on, 0.2, 0.001};
    Sheet sheet = make(config);
    const std::uint64_t shape = sheet.shape_hash();
    const std::string integrator = sheet.integrator_description();
    ASSERT_TRUE(apply(sheet, scene::SetSelfContact{!is_on, 0.4, 0.003}).ok());
    const scene::SelfContact changed = sheet.self_contact();
    EXPECT_NE(sheet.shape_hash(), shape);
    run(sheet, 5);
    Sheet going_on = sheet;
    ASSERT_TRUE(apply(sheet, scene::Reset{}).ok());
    EXPECT_EQ(sheet.self_contact(), config.self_contact);
    EXPECT_EQ(sheet.shape_hash(), shape);
    EXPECT_EQ(sheet.integrator_description(), integrator);
    ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
    EXPECT_EQ(sheet.self_contact(), changed);
    EXPECT_EQ(sheet.shape_hash(), going_on.shape_hash());
    run(sheet, 5);
    run(going_on, 5);
    EXPECT_EQ(sheet.shape_hash(), going_on.shape_hash());
  }
}

TEST(SetSelfContact, StaysThroughUndoAndRedoOfCuts) {
  Sheet sheet = make(scenes::falls_on_edge(10));
  run(sheet, 2);
  ASSERT_TRUE(apply(sheet, scenes::circle_cut({0.5, 0.5}, 0.2)).ok());
  ASSERT_TRUE(apply(sheet, scene::SetSelfContact{true, 0.4, std::nullopt}).ok());
  const std::size_t steps = sheet.history().num_done();
  run(sheet, 20);
  ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_EQ(sheet.history().num_done() + 1, steps);
  EXPECT_TRUE(sheet.self_contact().is_on);
  run(sheet, 5);
  ASSERT_TRUE(apply(sheet, scene::RedoCut{}).ok());
  EXPECT_TRUE(sheet.self_contact().is_on);
  ASSERT_FALSE(sheet.step({}).frozen);
}

TEST(SetSelfContact, ARecordingWithItReplaysBitForBitAndCopiesAreEqual) {
  std::vector<std::vector<scene::Command>> ticks(60);
  ticks[1] = {scenes::line_cut({0.2, 0.5}, {0.8, 0.45})};
  ticks[4] = {scene::SetSelfContact{true, 0.6, std::nullopt}};
  ticks[20] = {with_thickness(0.002)};
  ticks[25] = {of_material()};
  ticks[30] = {turned(false), with_friction(0.1)};
  ticks[34] = {scene::UndoCut{}};
  ticks[36] = {turned(true)};
  ticks[50] = {scene::Reset{}};
  ticks[53] = {turned(true)};
  expect_equal_replay(scenes::falls_on_edge(12), ticks);
}

TEST(SetSelfContact, ASceneSchedulesIt) {
  scene::SheetConfig config = scenes::falls_on_edge(10);
  config.commands = {{3, turned(true)}, {6, turned(false)}};
  Sheet sheet = make(config), by_hand = make(scenes::falls_on_edge(10));
  for (int tick = 1; tick <= 12; ++tick) {
    sheet.step({});
    std::vector<scene::Command> commands;
    if (tick == 3 || tick == 6) commands = {turned(tick == 3)};
    by_hand.step(commands);
    EXPECT_EQ(sheet.self_contact().is_on, tick >= 3 && tick < 6);
    ASSERT_EQ(sheet.state_hash(), by_hand.state_hash());
  }
}

double self_contact_ms(const Sheet& sheet) {
  return 1e-6 * sheet.expected_cost()[fem::TickPart::kSelfContact];
}

TEST(SetSelfContact, TheEstimateOfATickCountsIt) {
  for (const scene::IntegratorKind kind : {scene::IntegratorKind::kExplicitLeapfrog, scene::IntegratorKind::kTrBdf2}) {
    scene::SheetConfig config = scenes::falls_on_edge(12);
    config.integrator.kind = kind;
    Sheet sheet = make(config);
    const fem::TickCost without = sheet.expected_cost();
    EXPECT_EQ(self_contact_ms(sheet), 0.0);
    ASSERT_TRUE(apply(sheet, turned(true)).ok());
    const double allowed = self_contact_ms(sheet);
    EXPECT_GT(allowed, 0.0);
    EXPECT_EQ(sheet.expected_cost()[fem::TickPart::kContact], without[fem::TickPart::kContact]);
    run(sheet, 1);
    const double apart = self_contact_ms(sheet);
    EXPECT_GT(apart, 0.0);
    EXPECT_LT(apart, allowed) << "nothing touches, and the allowance is for what may";
    run(sheet, 60);
    EXPECT_GT(self_contact_ms(sheet), 3.0 * apart) << "in a pile";
    ASSERT_TRUE(apply(sheet, turned(false)).ok());
    run(sheet, 1);
    EXPECT_EQ(self_contact_ms(sheet), 0.0);
  }
}

TEST(SetSelfContact, TheEstimateCountsNoBodiesOfASheetThatOnlyTouchesItself) {
  Sheet sheet = make(scenes::hanging(8));
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  EXPECT_EQ(sheet.expected_cost()[fem::TickPart::kContact], 0.0);
}

TEST(SetSelfContact, WakesASheetAtRest) {
  Sheet sheet = make(scenes::lying_on_floor(5));
  for (int i = 0; i < 2000 && !sheet.at_rest(); ++i) run(sheet, 1);
  ASSERT_TRUE(sheet.at_rest());
  ASSERT_TRUE(apply(sheet, turned(true)).ok());
  EXPECT_FALSE(sheet.at_rest());
}

}  // namespace
}  // namespace kerf::sheet
