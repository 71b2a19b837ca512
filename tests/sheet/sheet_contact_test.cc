// Contact and friction as a whole sheet feels them, whichever integrator steps it.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "server/sheet/sheet.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

class SheetContact : public ::testing::TestWithParam<IntegratorKind> {
 protected:
  static Sheet make(SheetConfig config) {
    config.integrator.kind = GetParam();
    Result<Sheet> created = Sheet::create(std::move(config));
    if (!created) ADD_FAILURE() << created.error().message;
    return std::move(created).value();
  }
  // On a plane that gravity is inclined to, by an angle of this tangent.
  static Sheet on_incline(double tangent, double friction) {
    SheetConfig config = scenes::lying_on_floor(6);
    config.material.mass_damping = 0.0;
    config.colliders[0].friction = friction;
    const double angle = std::atan(tangent);
    config.gravity = kGravity * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
    return make(std::move(config));
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
  const mesh::VertexField before = sheet.state().x;
  for (int tick = 0; tick < 120; ++tick) sheet.step({});
  EXPECT_LT((sheet.state().x - before).cwiseAbs().maxCoeff(), 1e-7);
}

// What hangs below the sphere pulls at the vertices that touch it: a solve that knows nothing of the contact stretches
// the sheet by what each vertex is then moved back.
TEST_P(SheetContact, ASheetDrapedOverASphereIsHardlyStretched) {
  SheetConfig config = scenes::draped_over_sphere(14);
  config.material.mass_damping = 5.0;
  Sheet sheet = make(std::move(config));
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
  SheetConfig config = scenes::draped_over_sphere(8);
  const contact::Collider ball = config.colliders[0];
  Sheet alone = make(config);
  config.colliders.clear();
  for (int i = 0; i < 4; ++i) config.colliders.push_back({contact::Sphere{{0.0, 0.0, 5.0 + i}, 0.5}, 0.3});
  config.colliders.push_back(ball);
  Sheet among_many = make(std::move(config));
  for (int tick = 0; tick < 30; ++tick) {
    alone.step({});
    among_many.step({});
  }
  EXPECT_EQ(alone.state().x, among_many.state().x);
}

INSTANTIATE_TEST_SUITE_P(, SheetContact,
                         ::testing::Values(IntegratorKind::kExplicitLeapfrog, IntegratorKind::kImplicitEuler),
                         [](const ::testing::TestParamInfo<IntegratorKind>& tested) {
                           const bool is_explicit = tested.param == IntegratorKind::kExplicitLeapfrog;
                           return std::string(is_explicit ? "Explicit" : "Implicit");
                         });

}  // namespace
}  // namespace kerf::sheet
