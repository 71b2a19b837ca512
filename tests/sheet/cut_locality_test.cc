// A cut costs what it crosses, not what the sheet has: counted, not timed.
#include <array>

#include <gtest/gtest.h>

#include "server/core/sheet/sheet.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

constexpr double kEdge = 1.0 / 60.0;  // m, of every sheet, so that what is stiff around a cut is the same

// Returns the same cut with the same number of triangles under it, for a sheet of `side` vertices a side. `offset`:
// edge lengths from the middle of the sheet.
scene::Cut cut_of(int side, double offset) {
  const double middle = 0.5 * (side - 1);
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return {kEdge * (middle + x), kEdge * (middle + y + offset)};
  };
  scene::Cut cut;
  cut.curve = cut::CubicBezier{{at(-8.3, 0.2), at(-3.1, 4.7), at(2.9, -5.2), at(8.4, 0.3)}};
  return cut;
}

// A piece of the same number of triangles, cut out beside.
scene::Cut hole_of(int side) {
  const double middle = 0.5 * (side - 1);
  scene::Cut cut;
  cut.curve = cut::Circle{{kEdge * (middle + 0.3), kEdge * (middle - 16.2)}, 5.1 * kEdge};
  return cut;
}

struct Work {
  std::size_t cut_bytes = 0;   // allocated by the cut and all that follows from it
  std::size_t undo_bytes = 0;  // by its undo
  std::size_t redo_bytes = 0;
  std::size_t split_bytes = 0;  // by a cut that a piece falls out by
  std::size_t pieces = 0;       // there are then
  std::int32_t crossed = 0;
};

Work work_of(int side, scene::IntegratorKind integrator) {
  scene::SheetConfig config = scenes::hanging(side);
  const double size = kEdge * (side - 1);
  config.mesh = scene::GridSource{side, side, size, size, scene::GridPattern::kUniformDiagonals, 0};
  config.integrator.kind = integrator;
  Sheet sheet = Sheet::create(config).value();
  // Makes buffers that grow with the sheet grow here, by half or more, so that they do not below.
  EXPECT_TRUE(sheet.apply({{scene::Command(cut_of(side, 12.0))}}).replies[0].ok());
  Work work;
  const auto bytes_of = [&](const scene::Command& command) {
    const std::size_t before = test::allocated_bytes();
    const TickReport report = sheet.apply({&command, 1});
    const std::size_t bytes = test::allocated_bytes() - before;
    EXPECT_TRUE(report.replies[0].ok());
    if (report.replies[0]->cut) work.crossed = report.replies[0]->cut->report.crossed_triangles;
    return bytes;
  };
  work.cut_bytes = bytes_of(cut_of(side, 0.0));
  work.undo_bytes = bytes_of(scene::UndoCut{});
  work.redo_bytes = bytes_of(scene::RedoCut{});
  work.split_bytes = bytes_of(hole_of(side));
  work.pieces = sheet.pieces().size();
  return work;
}

class CutLocality : public testing::TestWithParam<scene::IntegratorKind> {};

TEST_P(CutLocality, WhatACutItsUndoAndItsRedoAllocateDoesNotGrowWithTheSheet) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const Work small = work_of(61, GetParam());
  const Work large = work_of(241, GetParam());  // 16 times the triangles
  EXPECT_GT(small.crossed, 40);
  EXPECT_NEAR(large.crossed, small.crossed, 4);
  EXPECT_GT(small.cut_bytes, 0U);
  EXPECT_LT(large.cut_bytes, small.cut_bytes + small.cut_bytes / 4);
  EXPECT_LT(large.undo_bytes, small.undo_bytes + small.undo_bytes / 4);
  EXPECT_LT(large.redo_bytes, small.redo_bytes + small.redo_bytes / 4);
  EXPECT_EQ(small.pieces, 2U);
  EXPECT_EQ(large.pieces, 2U);
  EXPECT_LT(large.split_bytes, small.split_bytes + small.split_bytes / 4);
}

INSTANTIATE_TEST_SUITE_P(Integrators, CutLocality,
                         testing::Values(scene::IntegratorKind::kExplicitLeapfrog,
                                         scene::IntegratorKind::kImplicitEuler));

class FollowedCuts : public testing::TestWithParam<scene::IntegratorSettings> {};

// A copy makes a new integrator.
TEST_P(FollowedCuts, StepAsIfTheIntegratorWereNew) {
  scene::SheetConfig config = scenes::hanging(14);
  config.integrator = GetParam();
  Sheet sheet = Sheet::create(config).value();
  const std::array<scene::Command, 8> commands{scenes::line_cut({0.2, 0.31}, {0.8, 0.37}),
                                               scenes::bezier_cut({0.1, 0.6}, {0.3, 0.4}, {0.5, 0.7}, {0.9, 0.6}),
                                               scenes::line_cut({0.52, 0.1}, {0.47, 0.9}),
                                               scene::UndoCut{},
                                               scene::UndoCut{},
                                               scene::RedoCut{},
                                               scenes::circle_cut({0.3, 0.6}, 0.15),
                                               scene::UndoCut{}};
  for (const scene::Command& command : commands) {
    ASSERT_TRUE(sheet.apply({&command, 1}).replies[0].ok());
    Sheet copy = sheet;
    sheet.step({});
    copy.step({});
    ASSERT_EQ(sheet.state_hash(), copy.state_hash());
  }
}

scene::IntegratorSettings settings_of(scene::IntegratorKind kind, scene::LinearSolverKind solver) {
  scene::IntegratorSettings settings;
  settings.kind = kind;
  settings.solver = solver;
  return settings;
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, FollowedCuts,
    testing::Values(settings_of(scene::IntegratorKind::kExplicitLeapfrog, scene::LinearSolverKind::kBlockJacobiCg),
                    settings_of(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kBlockJacobiCg),
                    settings_of(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kDirect),
                    settings_of(scene::IntegratorKind::kImplicitEuler, scene::LinearSolverKind::kMultigridCg),
                    settings_of(scene::IntegratorKind::kAutomatic, scene::LinearSolverKind::kBlockJacobiCg)));

}  // namespace
}  // namespace kerf::sheet
