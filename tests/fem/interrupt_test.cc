// Steps that are ended early leave the state, and whatever steps it next, as if they had not begun.
#include <limits>

#include "tests/fem/integrator_cases.h"

namespace kerf::fem {
namespace {

// Ends what asks it for the nth time.
struct EndAt {
  explicit EndAt(int call) : last(call) {}
  bool operator()() { return ++calls >= last; }
  int calls = 0;
  int last;
};

class InterruptedSteps : public IntegratorTest {
 protected:
  InterruptedSteps() : mesh_(jittered_square(12)), model_(mesh_, soft_cloth()), state_(rest_state(mesh_)) {
    SeededRandom random(5);
    state_.x += random_field(random, state_.x.cols(), 2e-3);
    state_.v = random_field(random, state_.x.cols(), 0.5);
    loads_ = hang_by_corners(12, state_);
    loads_.wind = {{0.0, 3.0, 0.0}, 1.2, 1.0};
  }

  mesh::TriangleMesh mesh_;
  Model model_;
  State state_;
  Loads loads_;
};

TEST_P(InterruptedSteps, AskOftenAndAreAsIfNobodyWereAsked) {
  const std::unique_ptr<Integrator> alone = make(model_);
  State a = state_;
  State b = state_;
  int calls = 0;
  const auto stop = std::make_unique<StopCondition>([&] {
    ++calls;
    return false;
  });
  const std::unique_ptr<Integrator> asking = make(model_);
  asking->set_stop_condition(stop.get());
  for (int i = 0; i < 3; ++i) {
    calls = 0;
    const StepStats stats = asking->step(model_, loads_, kTick, nullptr, a);
    EXPECT_FALSE(stats.interrupted);
    EXPECT_GE(calls, is(IntegratorKind::kExplicit) ? stats.substeps : stats.newton_iterations);
    alone->step(model_, loads_, kTick, nullptr, b);
    EXPECT_TRUE(equal_bits(a, b));
  }
}

TEST_P(InterruptedSteps, LeaveNothingBehindWhereverTheyEnd) {
  const std::unique_ptr<Integrator> integrator = make(model_);
  int most = 0;  // times that a whole step asks
  {
    State state = state_;
    EndAt never(std::numeric_limits<int>::max());
    const StopCondition stop = std::ref(never);
    integrator->set_stop_condition(&stop);
    integrator->step(model_, loads_, kTick, nullptr, state);
    most = never.calls;
  }
  State expected = state_;
  make(model_)->step(model_, loads_, kTick, nullptr, expected);

  for (int call = 1; call <= most; call = call < 8 ? call + 1 : call * 3 / 2) {
    State state = state_;
    bool is_over = false;
    EndAt end(call);
    const StopCondition stop = [&] {
      is_over = is_over || end();
      return is_over;
    };
    integrator->set_stop_condition(&stop);
    const StepStats stats = integrator->step(model_, loads_, kTick, nullptr, state);
    ASSERT_TRUE(is_over);
    EXPECT_TRUE(stats.interrupted) << call << " of " << most;
    EXPECT_EQ(stats.simulated, 0.0);
    EXPECT_TRUE(equal_bits(state, state_)) << call;
    integrator->set_stop_condition(nullptr);
    EXPECT_FALSE(integrator->step(model_, loads_, kTick, nullptr, state).interrupted);
    EXPECT_TRUE(equal_bits(state, expected)) << call;
  }
}

INSTANTIATE_TEST_SUITE_P(All, InterruptedSteps, testing::ValuesIn(all_integrators()), case_name);
INSTANTIATE_TEST_SUITE_P(Undamped, InterruptedSteps, testing::ValuesIn(undamped_integrators()), case_name);

TEST(InterruptedAutomatic, HandsOnWhomToAsk) {
  const mesh::TriangleMesh mesh = square_grid(6);
  Material material = soft_cloth();
  for (const double E : {4.0e5, 4.0e14}) {  // chosen: explicit, implicit
    material = isotropic(E, 0.3, 5.0e-4, 400.0);
    const Model model(mesh, material);
    const std::unique_ptr<Integrator> integrator = make_integrator({});
    integrator->rebuild(model);
    EXPECT_EQ(integrator->kind() == IntegratorKind::kExplicit, E < 1.0e6) << integrator->explanation();
    const StopCondition stop = [] { return true; };
    integrator->set_stop_condition(&stop);
    State state = rest_state(mesh);
    const State before = state;
    EXPECT_TRUE(integrator->step(model, Loads{}, kTick, nullptr, state).interrupted);
    EXPECT_TRUE(equal_bits(state, before));
  }
}

}  // namespace
}  // namespace kerf::fem
