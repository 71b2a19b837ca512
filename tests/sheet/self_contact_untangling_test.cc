// Sheets that pass through themselves, from the start or by a command: they come apart gently.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/model/model.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"
#include "tests/support/tangled_scenes.h"

namespace kerf::sheet {
namespace {

constexpr std::int32_t kTangledSide = 10;
constexpr double kPullSpeedOfContact = 0.05;  // m/s

Sheet tangled(scene::SheetConfig config) {
  Result<Sheet> made = Sheet::create(std::move(config));
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(made).value();
}

std::int64_t num_tangled(const Sheet& sheet) {
  return contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x);
}

double fastest_of(const Sheet& sheet) {
  return sheet.state().v.colwise().norm().maxCoeff();
}

// Expects that a sheet at rest comes apart within some ticks, with no more speed and energy than its pushes give.
void expect_comes_apart(scene::SheetConfig config, int ticks) {
  Sheet sheet = tangled(std::move(config));
  ASSERT_GT(num_tangled(sheet), 0);
  const double mass = sheet.model().masses().total(), first = sheet.energies().total();
  for (int i = 0; i < ticks; ++i) {
    const TickReport report = sheet.step({});
    ASSERT_FALSE(report.frozen);
    ASSERT_EQ(report.stats.self_contact.intersections, num_tangled(sheet));
    ASSERT_LE(fastest_of(sheet), 2.0 * kPullSpeedOfContact) << "after tick " << i + 1;
    ASSERT_LE(sheet.energies().total() - first, 0.5 * mass * kPullSpeedOfContact * kPullSpeedOfContact);
    ASSERT_LT(sheet.model().momentum(sheet.state()).linear.norm(), 1e-6 * mass * kPullSpeedOfContact);
  }
  EXPECT_EQ(num_tangled(sheet), 0);
}

TEST(SelfContactUntangling, AStripThatWasPushedThroughComesBack) {
  expect_comes_apart(scenes::pushed_through(1e-3, false, kTangledSide), 10);
  expect_comes_apart(scenes::pushed_through(1e-2, false, kTangledSide), 40);
}

TEST(SelfContactUntangling, AStripHalfBeyondTheBorderSlidesOut) {
  expect_comes_apart(scenes::pushed_through(3e-3, true, kTangledSide), 90);
  expect_comes_apart(scenes::pushed_through(0.15, true, kTangledSide), 90);
}

TEST(SelfContactUntangling, AStripHalfWayThroughComesBack) {
  expect_comes_apart(scenes::pushed_through(0.14, false, kTangledSide), 240);
}

// Bumps are strained, so that their energy becomes motion.
TEST(SelfContactUntangling, ABumpThatPokesThroughComesBack) {
  for (const double depth : {1e-3, 1e-2}) {
    Sheet sheet = tangled(scenes::poked_through(depth, kTangledSide));
    ASSERT_GT(num_tangled(sheet), 0);
    const double push = 0.5 * sheet.model().masses().total() * kPullSpeedOfContact * kPullSpeedOfContact;
    double energy = sheet.energies().total();
    for (int i = 0; i < 20; ++i) {
      ASSERT_FALSE(sheet.step({}).frozen);
      EXPECT_LE(sheet.energies().total(), energy + 0.1 * push);
      energy = sheet.energies().total();
    }
    EXPECT_EQ(num_tangled(sheet), 0);
  }
}

TEST(SelfContactUntangling, ImplicitStepsPullApartToo) {
  for (const scene::IntegratorKind kind : {scene::IntegratorKind::kTrBdf2, scene::IntegratorKind::kImplicitEuler}) {
    scene::SheetConfig config = scenes::pushed_through(1e-3, false, kTangledSide);
    config.integrator.kind = kind;
    Sheet sheet = tangled(std::move(config));
    const double mass = sheet.model().masses().total(), first = sheet.energies().total();
    for (int i = 0; i < 15; ++i) {
      ASSERT_FALSE(sheet.step({}).frozen);
      // The sheet is strained by the way that it is pulled in one substep, and gives it back.
      ASSERT_LE(sheet.energies().total() - first, 2.0 * mass * kPullSpeedOfContact * kPullSpeedOfContact);
      ASSERT_LT(sheet.model().momentum(sheet.state()).linear.norm(), 1e-6 * mass * kPullSpeedOfContact);
    }
    EXPECT_EQ(num_tangled(sheet), 0);
  }
}

TEST(SelfContactUntangling, AnUndoAroundAStripIsMended) {
  Sheet sheet = tangled(scenes::pushed_through(0.02, false, 16));
  scene::Cut cut;
  cut.curve = cut::Polyline{{scenes::at_strip(-0.5), scenes::at_strip(1.5)}};
  ASSERT_TRUE(sheet.step(std::vector<scene::Command>{cut}).replies[0].ok());
  for (int i = 0; i < 3; ++i) sheet.step({});
  ASSERT_EQ(num_tangled(sheet), 0);
  ASSERT_TRUE(sheet.step(std::vector<scene::Command>{scene::UndoCut{}}).replies[0].ok());
  ASSERT_GT(num_tangled(sheet), 0);
  for (int i = 0; i < 60; ++i) ASSERT_FALSE(sheet.step({}).frozen);
  EXPECT_EQ(num_tangled(sheet), 0);
}

// Self-contact is turned on in a pile that has fallen through itself.
TEST(SelfContactUntangling, APileHasFewerAndFewerPairs) {
  scene::SheetConfig config = scenes::falls_on_edge(12);
  config.self_contact.is_on = false;
  Sheet sheet = tangled(std::move(config));
  for (int i = 0; i < 60; ++i) sheet.step({});
  const std::int64_t first = num_tangled(sheet);
  ASSERT_GT(first, 200);
  scene::SetSelfContact on;
  on.is_on = true;
  sheet.step(std::vector<scene::Command>{on});
  Sheet copy = sheet;
  double energy = sheet.energies().total();
  const double push = 0.5 * sheet.model().masses().total() * kPullSpeedOfContact * kPullSpeedOfContact;
  for (int i = 1; i < 120; ++i) {
    ASSERT_FALSE(sheet.step({}).frozen);
    copy.step({});
    ASSERT_EQ(sheet.state_hash(), copy.state_hash());
    ASSERT_LE(sheet.energies().total(), energy + 4.0 * push) << "after tick " << i + 1;
    energy = sheet.energies().total();
  }
  EXPECT_LT(num_tangled(sheet), first / 3);
}

// Layers that pins force through each other stay so.
TEST(SelfContactUntangling, PinsWin) {
  scene::SheetConfig config = scenes::pushed_through(0.02, false, kTangledSide);
  config.pins = {scene::MaterialBox{{0.0, 0.0}, {1.0, 1.0}}};
  Sheet sheet = tangled(std::move(config));
  const linear::VertexField before = sheet.state().x;
  const std::int64_t first = num_tangled(sheet);
  for (int i = 0; i < 10; ++i) {
    const TickReport report = sheet.step({});
    ASSERT_FALSE(report.frozen);
    EXPECT_EQ(report.stats.self_contact.intersections, first);
  }
  EXPECT_EQ(sheet.state().x, before);
}

}  // namespace
}  // namespace kerf::sheet
