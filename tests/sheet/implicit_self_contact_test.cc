// Contact of sheets with themselves beside implicit steps.
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

#include "server/core/contact/intersections.h"
#include "server/core/fem/element/state.h"
#include "server/core/fem/step/step_stats.h"
#include "server/core/sheet/sheet.h"
#include "tests/sheet/calls.h"
#include "tests/support/self_contact_scenes.h"
#include "tests/support/solid_triangles.h"

namespace kerf::sheet {
namespace {

using scene::IntegratorKind;
using scenes::SelfContactScene;

class ImplicitSelfContact : public testing::TestWithParam<IntegratorKind> {
 protected:
  static Sheet touching(scene::SheetConfig config, bool has_self_contact = true) {
    config.self_contact.is_on = has_self_contact;
    config.integrator.kind = GetParam();
    return make(std::move(config));
  }

  static void expect_nothing_passes(char letter, int ticks) {
    for (const SelfContactScene& scene : scenes::self_contact_scenes()) {
      if (scene.letter != letter) continue;
      Sheet sheet = touching(scene.make_small());
      std::uint32_t flags = 0;
      for (int i = 0; i < ticks; ++i) {
        const TickReport report = sheet.step({});
        ASSERT_FALSE(report.frozen);
        ASSERT_EQ(report.stats.self_contact.intersections, 0) << "after tick " << i + 1;
        ASSERT_EQ(contact::IntersectionSearch().count(test::solid_triangles(sheet.mesh()), sheet.state().x), 0)
            << "after tick " << i + 1;
        flags |= report.stats.flags;
      }
      EXPECT_NE(flags & fem::kSplitContact, 0U);
    }
  }
};

TEST_P(ImplicitSelfContact, NothingPassesWhereASheetFallsOnItsEdge) {
  expect_nothing_passes('a', 60);
}
TEST_P(ImplicitSelfContact, NothingPassesWhereStripsFall) {
  expect_nothing_passes('d', 60);
}
TEST_P(ImplicitSelfContact, NothingPassesWhereALayerIsThrownOnAnother) {
  expect_nothing_passes('f', 60);
}

TEST_P(ImplicitSelfContact, ASheetThatDoesNotTouchItselfKeepsItsBits) {
  Sheet with = touching(scenes::hung_by_corner(10)), without = touching(scenes::hung_by_corner(10), false);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(with.step({}).stats.self_contact.contacts, 0);
    without.step({});
    ASSERT_EQ(with.state_hash(), without.state_hash()) << "after tick " << i + 1;
  }
}

TEST_P(ImplicitSelfContact, LayersRestThatFarApart) {
  Sheet sheet = touching(scenes::thrown_on_a_layer(10));
  const double thickness = sheet.config().material.thickness;
  run(sheet, 90);
  const std::vector<scene::Piece> pieces = sheet.pieces();
  ASSERT_EQ(pieces.size(), 2U);
  const double step = pieces[1].world_centroid.z() - pieces[0].world_centroid.z();
  EXPECT_GT(step, 0.7 * thickness);
  EXPECT_LT(step, 1.1 * thickness);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ImplicitSelfContact,
                         testing::Values(IntegratorKind::kImplicitEuler, IntegratorKind::kTrapezoidal,
                                         IntegratorKind::kBdf2, IntegratorKind::kTrBdf2),
                         [](const testing::TestParamInfo<IntegratorKind>& tested) {
                           switch (tested.param) {
                             case IntegratorKind::kImplicitEuler:
                               return "Euler";
                             case IntegratorKind::kTrapezoidal:
                               return "Trapezoidal";
                             case IntegratorKind::kBdf2:
                               return "Bdf2";
                             default:
                               return "TrBdf2";
                           }
                         });

}  // namespace
}  // namespace kerf::sheet
