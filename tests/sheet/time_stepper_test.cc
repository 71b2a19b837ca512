#include "server/core/sheet/time_stepper.h"

#include <gtest/gtest.h>

#include "tests/sheet/moving_parts.h"
#include "tests/support/failing_integrator.h"

namespace kerf::sheet {
namespace {

class TimeStepperTest : public testing::Test {
 protected:
  StepOutcome step(double gravity) {
    loads_.gravity.z() = gravity;
    return stepper_.step(model_, loads_, {}, state_);
  }

  void SetUp() override {
    stepper_.contact().set_vertices(initial_->built.mesh.num_vertices(), {}, {});
    stepper_.rebuild(model_, {}, state_.x.cols());
  }

  std::shared_ptr<const InitialState> initial_ = initial_state_of(scenes::flat(5));
  fem::Model model_ = initial_->materials.make_model(*initial_->config, initial_->built.mesh);
  fem::State state_{initial_->built.positions, initial_->velocities};
  fem::Loads loads_;
  TimeStepper stepper_{
      *initial_->config,
      [](const fem::IntegratorOptions& options) { return std::make_unique<scenes::FailingIntegrator>(options); }, 1.0};
};

TEST_F(TimeStepperTest, FreezesAfterFailuresInARow) {
  for (int i = 1; i < Sheet::kMaxFailedSteps; ++i) EXPECT_TRUE(step(scenes::kGivesUp).failed);
  EXPECT_FALSE(step(-9.81).failed);
  EXPECT_EQ(stepper_.failed_steps(), 0);
  for (int i = 1; i <= Sheet::kMaxFailedSteps; ++i) {
    EXPECT_FALSE(stepper_.is_frozen());
    EXPECT_TRUE(step(scenes::kGivesUp).failed);
  }
  EXPECT_TRUE(stepper_.is_frozen());
  stepper_.restore(0, false);
  EXPECT_FALSE(stepper_.is_frozen());
}

TEST_F(TimeStepperTest, LeavesTheStateOfAFailedStepAsItWas) {
  ASSERT_FALSE(step(-9.81).failed);
  const fem::State before = state_;
  EXPECT_TRUE(step(scenes::kWritesNonsense).failed);
  EXPECT_EQ(state_.x, before.x);
  EXPECT_EQ(state_.v, before.v);
}

TEST_F(TimeStepperTest, GivesUpAndFreezesWithoutMemory) {
  const fem::State before = state_;
  const StepOutcome outcome = step(scenes::kRunsShort);
  EXPECT_TRUE(outcome.gave_up);
  EXPECT_TRUE(outcome.stats.interrupted);
  EXPECT_TRUE(stepper_.is_frozen());
  EXPECT_EQ(state_.x, before.x);
}

}  // namespace
}  // namespace kerf::sheet
