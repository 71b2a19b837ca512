// Clusters of local inertia, as a sheet reports them.
#include <optional>

#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

scene::Command line(double left, double right) {
  scene::Cut cut;
  cut.curve = cut::Polyline{{Eigen::Vector2d(0.1, left), Eigen::Vector2d(0.9, right)}};
  return cut;
}

// Three lines that cross at small angles.
void cut_slivers(Sheet& sheet) {
  ASSERT_TRUE(apply(sheet, line(0.5, 0.55)).ok());
  ASSERT_TRUE(apply(sheet, line(0.55, 0.5)).ok());
  ASSERT_TRUE(apply(sheet, line(0.53, 0.531)).ok());
}

TEST(SheetLocalInertia, IsToldOfWhileThereAreClusters) {
  Sheet sheet = make(scenes::hanging(20));
  EXPECT_FALSE(sheet.local_inertia());
  cut_slivers(sheet);
  const std::optional<fem::LocalInertiaStats> stats = sheet.local_inertia();
  ASSERT_TRUE(stats);
  EXPECT_GE(stats->clusters, 1);
  EXPECT_GE(stats->largest, 2);
  EXPECT_GE(stats->vertices, stats->largest);
  EXPECT_LE(stats->vertices, sheet.mesh().num_vertices());
  EXPECT_GT(stats->plain_substeps, 2.0 * stats->planned_substeps);
  EXPECT_GE(sheet.step({}).stats.substeps, stats->planned_substeps);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  EXPECT_FALSE(sheet.local_inertia());
}

TEST(SheetLocalInertia, IsOfExplicitStepsAlone) {
  scene::SheetConfig config = scenes::hanging(20);
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  Sheet sheet = make(config);
  cut_slivers(sheet);
  EXPECT_FALSE(sheet.local_inertia());
}

}  // namespace
}  // namespace kerf::sheet
