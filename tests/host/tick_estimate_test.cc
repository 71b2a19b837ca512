// Tests estimates of a tick: by counts, and scaled by the time that ticks took.
#include "server/core/fem/step/explicit_integrator.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

// Its steps take twice what it counts, on a clock that it moves.
class Slow : public fem::Integrator {
 public:
  Slow(const fem::IntegratorOptions& options, test::ManualClock& clock)
      : inner_(fem::make_integrator(options)), clock_(clock) {}

  void rebuild(const fem::Model& model) override { inner_->rebuild(model); }
  fem::StepStats step(const fem::Model& model, const fem::Loads& loads, double dt, fem::ContactConstraint* contact,
                      fem::State& state) override {
    clock_.move_to(clock_.now() + Nanoseconds(std::llround(2.0 * expected_cost(model, dt, {}).total())));
    return inner_->step(model, loads, dt, contact, state);
  }
  [[nodiscard]] std::string_view explanation() const override { return inner_->explanation(); }
  [[nodiscard]] fem::IntegratorKind kind() const override { return inner_->kind(); }
  [[nodiscard]] fem::TickCost expected_cost(const fem::Model& model, double dt,
                                            const fem::TickCounts& last) const override {
    return inner_->expected_cost(model, dt, last);
  }

 private:
  std::unique_ptr<fem::Integrator> inner_;
  test::ManualClock& clock_;
};

class TickEstimateTest : public HostTest {
 protected:
  TickEstimateTest() : HostTest(slow_ticks(clock_)) {}

 private:
  static HostOptions slow_ticks(test::ManualClock& clock) {
    HostOptions options;
    options.make_integrator = [&clock](const fem::IntegratorOptions& wanted) {
      return std::make_unique<Slow>(wanted, clock);
    };
    return options;
  }
};

TEST_F(TickEstimateTest, IsCountedAtFirstAndFollowsWhatTicksTook) {
  const TickEstimate counted = create("a", small_sheet()).tick_estimate;
  EXPECT_EQ(counted.scale, 1.0);
  EXPECT_EQ(counted.budget, 20'000.0);
  EXPECT_GT(counted.total_us(), 0.0);
  EXPECT_TRUE(counted.fits());
  run_for(10 * kTick);
  const TickEstimate measured = status("a").tick_estimate;
  // The sheet that swings is counted a little dearer than at rest, which the integrator does not look at.
  EXPECT_NEAR(measured.scale, 2.0, 0.2);
  EXPECT_NEAR(measured.total_us(), 2.0 * counted.total_us(), 0.1 * counted.total_us());
}

TEST_F(TickEstimateTest, ACutSaysWhatTicksTakeBeforeItAndAfter) {
  create("a", small_sheet());
  run_for(10 * kTick);
  const double before = status("a").tick_estimate.total_us();
  scene::Cut cut;
  cut.curve = cut::Circle{{0.5, 0.5}, 0.21};
  const CommandResult result = submit("a", cut).value();
  EXPECT_NEAR(result.timings.tick_before_us, before, 1e-2 * before);
  EXPECT_GT(result.timings.tick_after_us, result.timings.tick_before_us);
  EXPECT_NEAR(result.timings.tick_after_us, status("a").tick_estimate.total_us(), 1e-2 * before);
  EXPECT_EQ(result.timings.budget_us, 20'000.0);
}

TEST_F(TickEstimateTest, MetricsHaveTheCpuTimeOfTicksByPart) {
  create("a", small_sheet());
  run_for(50 * kTick);
  const HostMetrics metrics = host_->metrics();
  double sum = 0.0;
  for (const double part : metrics.tick_part_cpu_s) sum += part;
  EXPECT_GT(sum, 0.0);
  EXPECT_NEAR(sum, metrics.tick_cpu_s, 1e-9);
}

}  // namespace
}  // namespace kerf::host
