// A tick without a cut or another command allocates nothing.
#include <malloc.h>

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/contact/prepared_collider.h"
#include "server/core/sheet/sheet.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/random_cuts.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

constexpr double kReach = 1e-3;  // m, within which a vertex counts as in contact

// A sheet with everything switched on that acts without a command: it falls on every kind of collider, is held at two
// pins and by two grabs, is cut often, and the wind blows.
Sheet busy_sheet(const scene::IntegratorSettings& integrator) {
  scene::SheetConfig config = scenes::draped_over_sphere(12);
  config.integrator = integrator;
  config.pins = {std::vector<mesh::VertexId>{0, 1}};
  config.wind = {{1.0, 0.0, 0.0}, 1.2, 1.0};
  config.colliders.push_back({contact::Plane{{0.0, 0.0, 0.1}, {0.0, 0.0, 1.0}}, 0.5});
  config.colliders.push_back({contact::OrientedBox{{0.3, 0.3, 0.2}, {0.1, 0.1, 0.1}, {1.0, 0.0, 1.0}, 0.5}, 0.2});
  config.colliders.push_back({contact::Capsule{{-0.4, -0.4, 0.2}, {0.0, -0.4, 0.2}, 0.1}, 0.0});
  Sheet sheet = Sheet::create(config).value();
  std::vector<scene::Command> commands{scene::Grab{"hand", Eigen::Vector2d(0.5, 0.9), std::nullopt, 0.0},
                                       scene::Grab{"corner", mesh::VertexId{143}, Eigen::Vector3d(0.6, 0.6, 0.6), 0.0},
                                       scenes::line_cut({0.2, 0.5}, {0.8, 0.45})};
  SeededRandom random(1);
  for (int i = 0; i < 8; ++i) {
    scene::Cut cut;
    cut.curve = test::random_cubic(random);
    commands.emplace_back(cut);
  }
  for (const Result<scene::CommandReply>& reply : sheet.apply(commands).replies) EXPECT_TRUE(reply.ok());
  return sheet;
}

int num_touching(const Sheet& sheet) {
  int touching = 0;
  for (const contact::Collider& collider : sheet.config().colliders) {
    const contact::PreparedCollider prepared(collider);
    for (const Eigen::Vector3d x : sheet.state().x.colwise()) touching += prepared.query(x).distance < kReach ? 1 : 0;
  }
  return touching;
}

class SheetAllocation : public testing::TestWithParam<scene::IntegratorSettings> {};

TEST_P(SheetAllocation, ATickWithoutCommandsAllocatesNothing) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  Sheet sheet = busy_sheet(GetParam());
  EXPECT_EQ(num_touching(sheet), 0);
  const bool is_explicit = GetParam().kind == scene::IntegratorKind::kExplicitLeapfrog;
  EXPECT_EQ(sheet.integrator_description().find("clusters") != std::string::npos, is_explicit);
  const std::size_t before = test::num_allocations();
  for (int i = 0; i < 60; ++i) sheet.step({});
  EXPECT_EQ(test::num_allocations(), before);
  EXPECT_GE(num_touching(sheet), 5) << "contact was among it";
}

TEST_P(SheetAllocation, TheCounterSeesWhatAViewerAndAMatrixCost) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const Sheet sheet = busy_sheet(GetParam());
  const std::size_t before = test::num_allocations();
  const std::shared_ptr<const Snapshot> snapshot = sheet.snapshot();
  const std::size_t after_snapshot = test::num_allocations();
  EXPECT_GT(after_snapshot, before);
  const Eigen::Matrix3Xd copy = snapshot->positions;  // Eigen calls malloc, not operator new
  EXPECT_EQ(test::num_allocations(), after_snapshot + 1);
  EXPECT_EQ(copy.cols(), sheet.mesh().num_vertices());
}

scene::IntegratorSettings settings(scene::IntegratorKind kind, scene::LinearSolverKind solver) {
  scene::IntegratorSettings made;
  made.kind = kind;
  made.solver = solver;
  return made;
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, SheetAllocation,
    testing::Values(settings(scene::IntegratorKind::kExplicitLeapfrog, scene::LinearSolverKind::kDirect),
                    settings(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kDirect),
                    settings(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kBlockJacobiCg),
                    settings(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kMultigridCg)),
    [](const testing::TestParamInfo<scene::IntegratorSettings>& tested) {
      if (tested.param.kind == scene::IntegratorKind::kExplicitLeapfrog) return std::string("Explicit");
      if (tested.param.solver == scene::LinearSolverKind::kDirect) return std::string("ImplicitDirect");
      const bool is_multigrid = tested.param.solver == scene::LinearSolverKind::kMultigridCg;
      return std::string(is_multigrid ? "ImplicitMultigrid" : "ImplicitIterative");
    });

// Bytes a vertex that a sheet with nothing near it holds after two ticks.
double held_bytes(std::int32_t side, bool touches_itself) {
  const auto allocated = [] {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
  };
  scene::SheetConfig config = scenes::hanging(side);
  config.self_contact.is_on = touches_itself;
  const double before = allocated();
  Sheet sheet = Sheet::create(config).value();
  for (int i = 0; i < 2; ++i) sheet.step({});
  return (allocated() - before) / (side * side);
}

TEST(Allocation, SelfContactOfASheetWithNothingNearHoldsNoMoreThanIsReservedForIt) {
  if (!test::counts_allocations()) GTEST_SKIP() << "a sanitizer has its own malloc";
  for (const std::int32_t side : {12, 50, 90}) {
    const double added = held_bytes(side, true) - held_bytes(side, false);
    EXPECT_LT(added, static_cast<double>(scene::kSelfContactBytes)) << side;
    EXPECT_GT(added, 0.5 * static_cast<double>(scene::kSelfContactBytes)) << side;
  }
}

}  // namespace
}  // namespace kerf::sheet
