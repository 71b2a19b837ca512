// Contact and friction as a whole sheet feels them, whichever integrator steps it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "server/core/sheet/sheet.h"
#include "tests/sheet/calls.h"
#include "tests/support/random_cuts.h"
#include "tests/support/scenes.h"
#include "tests/support/trials.h"

namespace kerf::sheet {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

class SheetContact : public ::testing::TestWithParam<scene::IntegratorKind> {
 protected:
  static Sheet make_of_kind(scene::SheetConfig config) {
    config.integrator.kind = GetParam();
    return make(std::move(config));
  }
  // On a plane that gravity is inclined to, by an angle of this tangent.
  static Sheet on_incline(double tangent, double friction) {
    scene::SheetConfig config = scenes::lying_on_floor(6);
    config.material.mass_damping = 0.0;
    config.colliders[0].friction = friction;
    const double angle = std::atan(tangent);
    config.gravity = kGravity * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    return make_of_kind(std::move(config));
  }
};

TEST_P(SheetContact, SlidesDownAnInclineAsCoulombSays) {
  constexpr double kTangent = 0.5;
  for (const double friction : {0.0, 0.2, 0.4}) {
    Sheet sheet = on_incline(kTangent, friction);
    for (int tick = 0; tick < 30; ++tick) sheet.step({});
    const double cosine = 1.0 / std::sqrt(1.0 + kTangent * kTangent);
    const double expected = kGravity * cosine * (kTangent - friction) * 0.5;  // m/s after half a second
    EXPECT_NEAR(sheet.state().v.row(0).mean(), expected, 0.01 * expected) << "mu " << friction;
  }
}

TEST_P(SheetContact, SticksOnAnInclineWithoutCreeping) {
  Sheet sheet = on_incline(0.5, 0.6);
  const linear::VertexField before = sheet.state().x;
  for (int tick = 0; tick < 120; ++tick) sheet.step({});
  EXPECT_LT((sheet.state().x - before).cwiseAbs().maxCoeff(), 1e-7);
}

// The part below the sphere pulls at the vertices that touch it. A solve without contact stretches the sheet by the
// distance that each vertex is then moved back.
TEST_P(SheetContact, ASheetDrapedOverASphereIsHardlyStretched) {
  scene::SheetConfig config = scenes::draped_over_sphere(14);
  config.material.mass_damping = 5.0;
  Sheet sheet = make_of_kind(std::move(config));
  double deepest = 0.0;
  const double keep = 0.3 + 0.5 * sheet.config().material.thickness;
  for (int tick = 0; tick < 90; ++tick) {
    const TickReport report = sheet.step({});
    EXPECT_EQ(report.stats.flags & fem::kRepaired, 0U) << "tick " << tick;
    EXPECT_LT(report.stats.residual, 0.05) << "tick " << tick;
    deepest = std::max(deepest, keep - sheet.state().x.colwise().norm().minCoeff());
  }
  EXPECT_LT(deepest, 1e-5);
  EXPECT_GT(sheet.energies().membrane, 0.01);
  EXPECT_LT(sheet.energies().membrane, 0.03);  // J
}

TEST_P(SheetContact, CollidersOutOfReachChangeNothing) {
  scene::SheetConfig config = scenes::draped_over_sphere(8);
  const contact::Collider ball = config.colliders[0];
  Sheet alone = make_of_kind(config);
  config.colliders.clear();
  for (int i = 0; i < 4; ++i) config.colliders.push_back({contact::Sphere{{0.0, 0.0, 5.0 + i}, 0.5}, 0.3});
  config.colliders.push_back(ball);
  Sheet among_many = make_of_kind(std::move(config));
  for (int tick = 0; tick < 30; ++tick) {
    alone.step({});
    among_many.step({});
  }
  EXPECT_EQ(alone.state().x, among_many.state().x);
}

// Far from everything a sheet moves as without bodies, to the last bit.
TEST(ExplicitContact, ABodyThatNothingComesNearChangesNoBit) {
  for (const scene::Precision precision : {scene::Precision::kMixed, scene::Precision::kDouble}) {
    scene::SheetConfig config = scenes::hanging(12);
    config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
    config.integrator.precision = precision;
    Result<Sheet> alone = Sheet::create(config);
    config.colliders = {{contact::Plane{{0.0, 0.0, -50.0}, {0.0, 0.0, 1.0}}, 0.5},
                        {contact::Sphere{{3.0, 4.0, 0.0}, 1.0}, 0.5}};
    Result<Sheet> above = Sheet::create(config);
    ASSERT_TRUE(alone.ok() && above.ok());
    for (int tick = 0; tick < 60; ++tick) {
      alone->step({});
      above->step({});
    }
    EXPECT_EQ(alone->state_hash(), above->state_hash());
    EXPECT_EQ(above->contact_phases(), 0);
  }
}

TEST_P(SheetContact, ASheetThatStartsInsideABodyIsBroughtOutGently) {
  scene::SheetConfig config = scenes::draped_over_sphere(14);
  config.placement.origin.z() -= 0.2;
  config.material.mass_damping = 1.0;
  Sheet sheet = make_of_kind(std::move(config));
  const double keep = 0.3 + 0.5 * sheet.config().material.thickness;
  const double start = sheet.energies().total();
  EXPECT_LT(sheet.state().x.colwise().norm().minCoeff(), 0.25);
  int inside = 0;
  for (int tick = 0; tick < 120; ++tick) {
    const TickReport report = sheet.step({});
    inside += (report.stats.flags & fem::kInsideBody) != 0 ? 1 : 0;
    // Lifted by up to 0.2 m, at 0.25 m/s.
    EXPECT_LT(sheet.energies().total(), start + 1.0) << "tick " << tick;
    EXPECT_LT(report.stats.max_strain, 0.5) << "tick " << tick;
  }
  EXPECT_GT(inside, 10);
  EXPECT_LT(inside, 90);
  EXPECT_GT(sheet.state().x.colwise().norm().minCoeff(), keep - 1e-5);
}

// Offcuts and what they were cut from fall on a floor and come to rest on it, tiny triangles with local inertia among
// them.
TEST(ExplicitContact, WhatWasCutLandsOnTheFloor) {
  scene::SheetConfig config = scenes::lying_on_floor(30);
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.placement.origin.z() += 0.02;
  config.material.mass_damping = 2.0;
  config.colliders[0].friction = 0.5;
  Result<Sheet> made = Sheet::create(std::move(config));
  ASSERT_TRUE(made.ok());
  Sheet& sheet = *made;
  SeededRandom random(4);
  const std::size_t wanted = static_cast<std::size_t>(test::num_trials({.few = 12, .usual = 16, .many = 30}));
  for (std::size_t done = 0; done < wanted;) {
    scene::Cut cut;
    cut.curve = test::random_cubic(random);
    const std::array<scene::Command, 1> commands{cut};
    const TickReport report = sheet.step(commands);
    if (report.replies.front().ok()) ++done;
  }
  ASSERT_NE(sheet.integrator_description().find("clusters"), std::string::npos);
  const double floor = 0.5 * sheet.config().material.thickness;
  const double start = sheet.energies().total();
  for (int tick = 0; tick < 60; ++tick) {
    const TickReport report = sheet.step({});
    EXPECT_EQ(report.stats.flags & (fem::kFrozen | fem::kInsideBody | fem::kSubstepped), 0U) << "tick " << tick;
    EXPECT_LE(sheet.energies().total(), start + 1e-6);
    double lowest = floor;
    for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
      if (sheet.mesh().has_material(v)) lowest = std::min(lowest, sheet.state().x(2, v));
    }
    EXPECT_GE(lowest, floor - 1e-8) << "tick " << tick;
  }
  EXPECT_LT(sheet.energies().kinetic, 1e-6);
}

// One of these sheets gained 1.5e-4 J in a tick while bodies pushed the vertices of clusters one by one.
TEST(ExplicitContact, WhatWasCutIsNotThrownWhereItComesUponAnIncline) {
  scene::SheetConfig config = scenes::flat(30);
  config.gravity.z() = -kGravity;
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.material = fem::find_preset("demo").value();
  config.material.youngs_modulus_1 = config.material.youngs_modulus_2 = 1.5e5;
  config.material.shear_modulus = 1.5e5 / 2.6;
  config.placement.origin = {-0.5, -0.5, 0.35};
  config.colliders = {{contact::Plane{{0.0, 0.0, 0.0}, {0.4, 0.2, 1.0}}, 0.5}};
  const auto first = static_cast<std::uint64_t>(test::num_trials({.few = 3, .usual = 2, .many = 1}));
  for (std::uint64_t seed = first; seed <= 3; ++seed) {
    Result<Sheet> made = Sheet::create(config);
    ASSERT_TRUE(made.ok());
    Sheet& sheet = *made;
    SeededRandom random(seed);
    std::vector<scene::Command> cuts(20);
    for (scene::Command& command : cuts) {
      scene::Cut cut;
      cut.curve = test::random_cubic(random);
      command = cut;
    }
    for (const Result<scene::CommandReply>& reply : sheet.step(cuts).replies) EXPECT_TRUE(reply.ok());
    ASSERT_NE(sheet.integrator_description().find("clusters"), std::string::npos);
    const Eigen::Vector3d normal = Eigen::Vector3d(0.4, 0.2, 1.0).normalized();
    double before = sheet.energies().total();
    for (int tick = 0; tick < 60; ++tick) {
      EXPECT_EQ(sheet.step({}).stats.flags, 0U) << "seed " << seed << ", tick " << tick;
      const double after = sheet.energies().total();
      EXPECT_LE(after, before + 1e-8) << "seed " << seed << ", tick " << tick;
      before = after;
    }
    double lowest = 1.0;
    for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
      if (sheet.mesh().has_material(v)) lowest = std::min(lowest, normal.dot(sheet.state().x.col(v)));
    }
    EXPECT_NEAR(lowest, 0.5 * sheet.config().material.thickness, 1e-8);
  }
}

// Clusters that one wall pushes towards another are seen by both.
TEST(ExplicitContact, WhatWasCutStaysOutsideBothWallsOfAValley) {
  scene::SheetConfig config = scenes::flat(30);
  config.gravity.z() = -kGravity;
  config.integrator.kind = scene::IntegratorKind::kExplicitLeapfrog;
  config.placement.origin = {-0.5, -0.5, 0.85};
  const std::array<Eigen::Vector3d, 2> normals{Eigen::Vector3d(0.8, 0.0, 0.6),
                                               Eigen::Vector3d(-0.8, 0.1, 0.6).normalized()};
  for (const Eigen::Vector3d& normal : normals) {
    config.colliders.push_back({contact::Plane{Eigen::Vector3d::Zero(), normal}, 0.3});
  }
  Result<Sheet> made = Sheet::create(std::move(config));
  ASSERT_TRUE(made.ok());
  Sheet& sheet = *made;
  SeededRandom random(1);
  std::vector<scene::Command> cuts(20);
  for (scene::Command& command : cuts) {
    scene::Cut cut;
    cut.curve = test::random_cubic(random);
    command = cut;
  }
  sheet.step(cuts);
  ASSERT_NE(sheet.integrator_description().find("clusters"), std::string::npos);
  const double kept = 0.5 * sheet.config().material.thickness;
  bool has_touched_both = false;
  for (int tick = 0; tick < 90; ++tick) {
    EXPECT_EQ(sheet.step({}).stats.flags & (fem::kFrozen | fem::kInsideBody), 0U) << "tick " << tick;
    int touching = 0;
    for (const Eigen::Vector3d& normal : normals) {
      double least = 1.0;
      for (mesh::VertexId v = 0; v < sheet.mesh().num_vertices(); ++v) {
        if (sheet.mesh().has_material(v)) least = std::min(least, normal.dot(sheet.state().x.col(v)));
      }
      EXPECT_GE(least, kept - 1e-8) << "tick " << tick;
      touching += least < kept + 1e-6 ? 1 : 0;
    }
    has_touched_both = has_touched_both || touching == 2;
  }
  EXPECT_TRUE(has_touched_both);
}

constexpr std::array<scene::IntegratorKind, 5> kAllKinds{
    scene::IntegratorKind::kExplicitLeapfrog, scene::IntegratorKind::kImplicitEuler,
    scene::IntegratorKind::kTrapezoidal, scene::IntegratorKind::kBdf2, scene::IntegratorKind::kTrBdf2};

// Velocities of stages of second order follow from positions, and would be reflected by the floor.
TEST(EveryIntegrator, DropsASheetWithoutABounce) {
  for (const scene::IntegratorKind kind : kAllKinds) {
    for (const double height : {0.0, 0.02, 0.3}) {
      scene::SheetConfig config = scenes::lying_on_floor(6);
      config.integrator.kind = kind;
      config.placement.origin.z() += height;
      config.initial_velocity = scene::InitialVelocity{{0.0, 0.0, -5.0}, {0.0, 0.0, 0.0}, {}};
      Result<Sheet> sheet = Sheet::create(config);
      ASSERT_TRUE(sheet.ok());
      const double before = sheet->energies().kinetic;
      ASSERT_GT(before, 1.0);
      for (int i = 0; i < 6; ++i) sheet->step({});
      EXPECT_LT(sheet->energies().kinetic, 1e-3 * before) << static_cast<int>(kind) << ", " << height;
    }
  }
}

TEST(EveryIntegrator, SlidesDownAnInclineAsCoulombSays) {
  constexpr int kTicks = 48;
  constexpr double kTime = kTicks / 60.0, kSlope = 19.0 * std::numbers::pi / 180.0;
  for (const scene::IntegratorKind kind : kAllKinds) {
    for (const double friction : {0.2, 0.3, 0.36}) {
      scene::SheetConfig config = scenes::lying_on_floor(6);
      config.integrator.kind = kind;
      config.material.mass_damping = 0.0;
      config.colliders[0].friction = friction;
      config.gravity = kGravity * Eigen::Vector3d(std::sin(kSlope), 0.0, -std::cos(kSlope));
      Result<Sheet> sheet = Sheet::create(config);
      ASSERT_TRUE(sheet.ok());
      const double start = sheet->state().x.row(0).mean();
      for (int i = 0; i < kTicks; ++i) sheet->step({});
      const double acceleration = std::max(0.0, kGravity * (std::sin(kSlope) - friction * std::cos(kSlope)));
      const double slid = 0.5 * acceleration * kTime * kTime;
      // Implicit Euler moves ahead by half a tick.
      const double ahead = kind == scene::IntegratorKind::kImplicitEuler ? 0.5 * acceleration * kTime / 60.0 : 0.0;
      // One per cent of the friction.
      const double allowed = 0.01 * friction * kGravity * std::cos(kSlope) * 0.5 * kTime * kTime;
      EXPECT_NEAR(sheet->state().x.row(0).mean() - start, slid + ahead, allowed)
          << static_cast<int>(kind) << ", " << friction;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, SheetContact,
                         ::testing::Values(scene::IntegratorKind::kExplicitLeapfrog,
                                           scene::IntegratorKind::kImplicitEuler),
                         [](const ::testing::TestParamInfo<scene::IntegratorKind>& tested) {
                           const bool is_explicit = tested.param == scene::IntegratorKind::kExplicitLeapfrog;
                           return std::string(is_explicit ? "Explicit" : "Implicit");
                         });

}  // namespace
}  // namespace kerf::sheet
