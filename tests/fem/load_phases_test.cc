// Loads that do nothing are not looked at in any substep.
#include "tests/fem/integrator_cases.h"

namespace kerf::fem {
namespace {

class IntegratorLoads : public IntegratorTest {};

TEST_P(IntegratorLoads, LoadsOfNothingCostNothing) {
  const mesh::TriangleMesh mesh = square_grid(5);
  const Model model(mesh, orthotropic_cloth());
  const std::unique_ptr<Integrator> integrator = make(model);
  SeededRandom random(9);
  State start = rest_state(mesh);
  start.x += random_field(random, start.x.cols(), 0.01);
  const auto step = [&](const Loads& loads, State& state) {
    state = start;
    return integrator->step(model, loads, 1e-2, nullptr, state);
  };
  Loads nothing = no_loads();
  nothing.external_forces = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  nothing.pressure.assign(static_cast<std::size_t>(mesh.num_triangle_slots()), 0.0);
  nothing.edge_moments = border_moments(model, mesh, 0.0);
  nothing.wind = {{1.0, 0.0, 0.0}, 1.2, 0.0, 0.0};
  State state;
  State unloaded;
  EXPECT_EQ(step(no_loads(), unloaded).load_phases, 0);
  EXPECT_EQ(step(nothing, state).load_phases, 0);
  EXPECT_EQ((state.x - unloaded.x).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((state.v - unloaded.v).cwiseAbs().maxCoeff(), 0.0);
  // Each of them alone is something.
  std::vector<Loads> loaded(4, nothing);
  loaded[0].wind.normal_drag = 1.0;
  loaded[1].external_forces(2, 7) = 1e-3;
  loaded[2].pressure[0] = 1.0;
  loaded[3].edge_moments = border_moments(model, mesh, 1e-4);
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    const StepStats stats = step(loaded[i], state);
    const bool is_counted = i == 0 || is(IntegratorKind::kExplicit);
    EXPECT_EQ(stats.load_phases > 0, is_counted) << i;
    EXPECT_GT((state.v - unloaded.v).cwiseAbs().maxCoeff(), 0.0) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, IntegratorLoads, testing::ValuesIn(all_integrators()), case_name);

}  // namespace
}  // namespace kerf::fem
