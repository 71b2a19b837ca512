// Ticks whose integration is ended early: all is as after Sheet::apply.
#include "server/base/stop_condition.h"
#include "tests/sheet/calls.h"

namespace kerf::sheet {
namespace {

const StopCondition kEnds = [] { return true; };

// Gravity that grows, an edge that rises, a force that fades, a point that is held: all that a tick sets before it.
scene::SheetConfig under_changing_loads() {
  scene::SheetConfig config = scenes::hanging(7);
  config.pins.clear();
  config.gravity_history = {{0.0, 1.0}, {0.5, 1.0}};
  scene::Constraint top = hold(scene::RegionEdge::kTop);
  top.displacement = {0.0, 0.1, 0.3};
  top.history = {{0.0, 0.5}, {0.0, 1.0}};
  config.constraints = {top};
  config.loads = {{scene::AreaForce{scene::WholeSheet{}, {0.0, 2.0, 0.0}, true}, {{0.0, 0.5}, {1.0, 0.0}}}};
  return config;
}

TEST(InterruptedTicks, AreAsIfTimeHadStoodStill) {
  for (const scene::SheetConfig& config : {under_changing_loads(), scenes::hanging(7), scenes::draped_over_sphere(7)}) {
    Sheet ended = make(config);
    Sheet stood = make(config);
    const scene::Grab grab{.grab_id = "g", .point = mesh::VertexId{3}, .target = Eigen::Vector3d(0.1, 0.2, 0.3)};
    const std::vector<scene::Command> none;
    const std::vector<std::vector<scene::Command>> turns = {none,
                                                            {grab},
                                                            {scenes::line_cut({0.2, 0.5}, {0.7, 0.45})},
                                                            none,
                                                            {scene::SetGravity{{0.0, 1.0, -5.0}}},
                                                            {scene::UndoCut{}}};
    for (const std::vector<scene::Command>& commands : turns) {
      run(ended, 2);
      run(stood, 2);
      const std::int64_t tick = ended.tick();
      const TickReport report = ended.step(commands, nullptr, &kEnds);
      const TickReport applied = stood.apply(commands);
      EXPECT_TRUE(report.stats.interrupted);
      EXPECT_FALSE(report.advanced);
      EXPECT_EQ(report.tick, tick);
      EXPECT_EQ(report.topology_changed, applied.topology_changed);
      ASSERT_EQ(report.replies.size(), commands.size());
      for (std::size_t i = 0; i < commands.size(); ++i) {
        ASSERT_TRUE(report.replies[i].ok()) << report.replies[i].error().message;
        EXPECT_EQ(report.replies[i]->tick, tick);
        EXPECT_EQ(report.replies[i]->state_hash, applied.replies[i]->state_hash);
      }
      ASSERT_EQ(ended.state_hash(), stood.state_hash());
    }
    run(ended, 3);
    run(stood, 3);
    EXPECT_EQ(ended.state_hash(), stood.state_hash());
  }
}

TEST(InterruptedTicks, WithScheduledCommandsGoOn) {
  scene::SheetConfig config = scenes::hanging(7);
  config.commands = {{2, scenes::line_cut({0.2, 0.5}, {0.7, 0.45})}};
  Sheet sheet = make(config);
  sheet.step({});
  const TickReport report = sheet.step({}, nullptr, &kEnds);
  ASSERT_EQ(report.scheduled.size(), 1U);
  EXPECT_FALSE(report.stats.interrupted);
  EXPECT_TRUE(report.advanced);
  EXPECT_TRUE(sheet.step({}, nullptr, &kEnds).stats.interrupted);
}

}  // namespace
}  // namespace kerf::sheet
