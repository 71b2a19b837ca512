// Contact of sheets with themselves, as a sheet has it; parts of it are tested in tests/contact.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"

namespace kerf::sheet {
namespace {

using scenes::SelfContactScene;

Sheet touching(scene::SheetConfig config, bool has_self_contact = true) {
  config.self_contact.is_on = has_self_contact;
  Result<Sheet> made = Sheet::create(std::move(config));
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(made).value();
}

std::int64_t num_intersections(const Sheet& sheet) {
  return contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x);
}

void expect_nothing_passes(char letter, int ticks, std::int64_t least_contacts) {
  for (const SelfContactScene& scene : scenes::self_contact_scenes()) {
    if (scene.letter != letter) continue;
    Sheet sheet = touching(scene.make_small());
    fem::SelfContactStats seen;
    for (int i = 0; i < ticks; ++i) {
      const TickReport report = sheet.step({});
      ASSERT_FALSE(report.frozen);
      ASSERT_EQ(num_intersections(sheet), 0) << "after tick " << i + 1;
      seen.contacts += report.stats.self_contact.contacts;
      seen.unsettled += report.stats.self_contact.unsettled;
    }
    EXPECT_EQ(seen.unsettled, 0);
    EXPECT_GE(seen.contacts, least_contacts);
  }
}

TEST(SelfContact, NothingPassesWhereASheetFallsOnItsEdge) {
  expect_nothing_passes('a', 90, 1000);
}
TEST(SelfContact, NothingPassesWhereASheetSwingsFromACorner) {
  expect_nothing_passes('b', 90, 0);
}
TEST(SelfContact, NothingPassesInFourLayers) {
  expect_nothing_passes('c', 25, 1000);
}
TEST(SelfContact, NothingPassesWhereStripsFall) {
  expect_nothing_passes('d', 90, 1000);
}
TEST(SelfContact, NothingPassesInATwistedStrip) {
  expect_nothing_passes('e', 240, 0);
}
TEST(SelfContact, NothingPassesWhereALayerIsThrownOnAnother) {
  expect_nothing_passes('f', 90, 1000);
}
TEST(SelfContact, NothingPassesInAStack) {
  expect_nothing_passes('s', 25, 1000);
}
TEST(SelfContact, AfterFiftyCutsNothingPassesAndNoEnergyIsGained) {
  Sheet sheet = touching(scenes::falls_after_cuts(12));
  double before = 0.0;
  for (int i = 0; i < 12; ++i) {
    const TickReport report = sheet.step({});
    ASSERT_FALSE(report.frozen);
    EXPECT_EQ(report.stats.self_contact.intersections, 0);
    EXPECT_EQ(num_intersections(sheet), 0);
    const double energy = sheet.energies().total();
    if (i > 0) {
      EXPECT_LE(energy, (1.0 + 1e-6) * before);
    }
    before = energy;
  }
}

TEST(SelfContact, WithoutItTheSameScenesPassThrough) {
  Sheet sheet = touching(scenes::falls_on_edge(12), false);
  std::int64_t most = 0;
  for (int i = 0; i < 90; ++i) {
    sheet.step({});
    most = std::max(most, num_intersections(sheet));
  }
  EXPECT_GT(most, 10);
}

TEST(SelfContact, ASheetThatDoesNotTouchItselfKeepsItsBits) {
  scene::SheetConfig config = scenes::hung_by_corner(12);
  config.placement.origin.z() += 2.0;
  Sheet with = touching(config), without = touching(config, false);
  for (int i = 0; i < 15; ++i) {
    EXPECT_EQ(with.step({}).stats.self_contact.contacts, 0);
    without.step({});
    ASSERT_EQ(with.state_hash(), without.state_hash()) << "after tick " << i + 1;
  }
}

TEST(SelfContact, ACopyAndASecondRunHaveTheSameBits) {
  Sheet first = touching(scenes::cut_in_the_pile(12)), second = touching(scenes::cut_in_the_pile(12));
  for (int i = 0; i < 40; ++i) first.step({});
  Sheet copy = first;
  for (int i = 0; i < 40; ++i) second.step({});
  for (int i = 0; i < 30; ++i) {
    first.step({});
    second.step({});
    copy.step({});
    ASSERT_EQ(first.state_hash(), second.state_hash());
    ASSERT_EQ(first.state_hash(), copy.state_hash());
  }
}

TEST(SelfContact, TheLayerBelowCarriesTheOneAboveAndBothComeToRest) {
  Sheet sheet = touching(scenes::thrown_on_a_layer(12));
  const double thickness = sheet.config().material.thickness;
  for (int i = 0; i < 60; ++i) sheet.step({});
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 2U);
  const double step = pieces[1].world_centroid.z() - pieces[0].world_centroid.z();
  EXPECT_GT(step, 0.7 * thickness);
  EXPECT_LT(step, 1.1 * thickness);
  for (int i = 60; i < 600 && !sheet.at_rest(); ++i) sheet.step({});
  EXPECT_TRUE(sheet.at_rest());
  EXPECT_LT(sheet.energies().kinetic, 1e-7);
}

// New triangles lie in the old ones, so cuts of a pile make nothing pass and add no energy.
TEST(SelfContact, NothingPassesAfterCutsOfAPile) {
  for (const int seed : {100, 101}) {
    SCOPED_TRACE(seed);
    SeededRandom random(static_cast<std::uint64_t>(seed));
    Sheet sheet = touching(scenes::falls_on_edge(12));
    for (int i = 0; i < 45; ++i) sheet.step({});
    std::vector<scene::Command> commands;
    for (int i = 0; i < 3; ++i) {
      cut::Polyline line;
      for (int k = 0; k < 4; ++k) line.points.emplace_back(random.uniform(0.05, 0.95), random.uniform(0.05, 0.95));
      scene::Cut cut;
      cut.curve = line;
      commands.push_back(scene::Command{cut});
    }
    double energy = sheet.energies().total();
    TickReport report = sheet.step(commands);
    for (const auto& reply : report.replies) ASSERT_TRUE(reply.ok());
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(report.stats.self_contact.intersections, 0);
      EXPECT_EQ(num_intersections(sheet), 0);
      EXPECT_LE(sheet.energies().total(), 1.005 * energy);
      energy = sheet.energies().total();
      report = sheet.step({});
    }
  }
}

TEST(SelfContact, LipsOfASlitStartApartAndStayClosed) {
  scene::SheetConfig config = scenes::hung_by_corner(12);
  config.pins.clear();
  config.gravity.setZero();
  Sheet sheet = touching(std::move(config));
  scene::Cut cut;
  cut.curve = cut::Polyline{{{0.5, 0.2}, {0.5, 0.8}}};
  const std::vector<scene::Command> commands{scene::Command{cut}};
  ASSERT_TRUE(sheet.step(commands).replies[0].ok());
  for (int i = 0; i < 30; ++i) {
    sheet.step({});
    ASSERT_EQ(num_intersections(sheet), 0);
  }
  // Lips that were moved apart by 6 % of the thickness spring back.
  EXPECT_LT(sheet.energies().kinetic, 1e-6);
}

}  // namespace
}  // namespace kerf::sheet
