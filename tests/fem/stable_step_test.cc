#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/cut/cut.h"
#include "server/core/fem/model/stable_step.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/cut_patterns.h"

namespace kerf::fem {
namespace {

TEST(RunningMaximum, IsTheMaximumWhileValuesChangeComeAndGo) {
  SeededRandom random(3);
  RunningMaximum running;
  std::vector<double> values;
  EXPECT_EQ(running.value(), 0.0);
  for (int step = 0; step < 2000; ++step) {
    if (step % 7 == 0) {
      values.resize(1 + random.below(step < 1000 ? 40 : 5000), 0.0);
      running.resize(values.size());
    }
    std::vector<std::int32_t> changed;
    for (std::uint64_t i = 0; i <= random.below(6); ++i) {
      const auto at = static_cast<std::int32_t>(random.below(values.size()));
      changed.push_back(at);
      values[static_cast<std::size_t>(at)] = random.uniform();
      running.set(static_cast<std::size_t>(at), values[static_cast<std::size_t>(at)]);
    }
    running.update(changed);
    ASSERT_EQ(running.value(), *std::max_element(values.begin(), values.end())) << "step " << step;
  }
}

mesh::TriangleMesh slitted(mesh::TriangleMesh mesh) {
  for (const cut::Curve& curve : test::kirigami(2, 2)) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, {}, {}});
    EXPECT_TRUE(plan.ok() && cut::apply(mesh, *plan).ok());
  }
  return mesh;
}

TEST(StiffnessBound, IsCloselyAboveTheLargestEigenvalue) {
  for (const mesh::TriangleMesh& mesh : {square_grid(12), jittered_square(12), slitted(square_grid(12))}) {
    for (const Material& material : {soft_cloth(), orthotropic_cloth(), find_preset("wool").value()}) {
      const Model model(mesh, material);
      const double largest = largest_eigenvalue(model, rest_state(mesh).x, 2000);
      EXPECT_GE(model.stiffness_bound().value(), largest * (1.0 - 1e-6));
      EXPECT_LE(model.stiffness_bound().value(), 1.15 * largest);
    }
  }
}

TEST(StiffnessBound, FoldsAndMotionDoNotRaiseTheLargestEigenvalueAboveIt) {
  SeededRandom random(5);
  for (const mesh::TriangleMesh& mesh : {square_grid(10), jittered_square(10), slitted(square_grid(10))}) {
    const Model model(mesh, soft_cloth());
    const std::unique_ptr<Integrator> integrator = make_integrator({});
    integrator->rebuild(model);
    State state = rest_state(mesh);
    state.v = random_field(random, state.x.cols(), 4.0);
    double largest_strain = 0.0;
    for (int i = 0; i < 40; ++i) {
      largest_strain =
          std::max(largest_strain, integrator->step(model, no_loads(), 1.0 / 60.0, nullptr, state).max_strain);
      if (i % 8 == 7) {
        EXPECT_LE(largest_eigenvalue(model, state.x, 300), model.stiffness_bound().value());
      }
    }
    EXPECT_GT(largest_strain, 0.05);
  }
}

TEST(StiffnessBound, FollowsCutsToTheValueOfAFreshStart) {
  mesh::TriangleMesh mesh = jittered_square(14);
  Model model(mesh, find_preset("denim").value());
  for (const cut::Curve& curve : test::kirigami(2, 3)) {
    const Result<cut::CutPlan> plan = cut::plan(mesh, {curve, {}, {}});
    ASSERT_TRUE(plan.ok());
    Result<cut::CutOutcome> outcome = cut::apply(mesh, *plan);
    ASSERT_TRUE(outcome.ok());
    model.apply(mesh, outcome->edit);
    const Model fresh(mesh, find_preset("denim").value());
    EXPECT_EQ(model.stiffness_bound().value(), fresh.stiffness_bound().value());
    EXPECT_EQ(model.stiffness_bound().bending(), fresh.stiffness_bound().bending());
    EXPECT_EQ(model.elements().largest_gradient(), fresh.elements().largest_gradient());
  }
}

}  // namespace
}  // namespace kerf::fem
