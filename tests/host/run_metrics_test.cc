#include "server/service/host/run_metrics.h"

#include <vector>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

using namespace std::chrono_literals;

class RunMetricsTest : public testing::Test {
 protected:
  static constexpr std::int64_t kWhole = WorkerNeed::kWhole;

  // Records a step of 5 ms by the clock.
  void step(const RunMetrics::Totals& totals, std::vector<Result<CommandResult>> results = {}) {
    sheet::TickReport report;
    report.advanced = true;
    metrics_.tick_done({.wall = 5ms, .cpu = 4ms, .is_by_clock = true, .cost = {}, .totals = totals}, report, results);
  }
  [[nodiscard]] HostMetrics read() const { return board_.read(); }

  MetricsBoard board_;
  RunMetrics metrics_{board_, WorkerNeed(10ms, 5ms)};
};

TEST_F(RunMetricsTest, CountsTheSheetUnderOneState) {
  EXPECT_FALSE(metrics_.is_begun());
  EXPECT_TRUE(metrics_.set_state(RunState::kRunning));
  EXPECT_TRUE(metrics_.is_begun());
  EXPECT_FALSE(metrics_.set_state(RunState::kRunning));
  EXPECT_EQ(read().sheets, 1);
  EXPECT_EQ(read().running_sheets, 1);
  EXPECT_TRUE(metrics_.set_state(RunState::kSleeping));
  EXPECT_EQ(read().sheets, 1);
  EXPECT_EQ(read().running_sheets, 0);
  EXPECT_EQ(read().sleeping_sheets, 1);
  metrics_.end();
  EXPECT_EQ(read().sheets, 0);
  EXPECT_EQ(read().sleeping_sheets, 0);
  EXPECT_FALSE(metrics_.set_state(RunState::kPaused)) << "it has ended";
  EXPECT_EQ(read().paused_sheets, 0);
}

TEST_F(RunMetricsTest, ASheetThatNeverBeganIsOnNoGauge) {
  metrics_.end();
  EXPECT_EQ(read().sheets, 0);
  EXPECT_EQ(read().running_sheets, 0);
}

TEST_F(RunMetricsTest, TakesTheSinksAlongWhenItEnds) {
  metrics_.set_state(RunState::kRunning);
  for (int i = 0; i < 3; ++i) metrics_.sink_added();
  metrics_.sink_removed();
  EXPECT_EQ(read().sinks, 2);
  metrics_.end();
  EXPECT_EQ(read().sinks, 0);
}

TEST_F(RunMetricsTest, CountsTheGrowthOfTotals) {
  step({.contact_phases = 10, .cuts = 1, .overruns = 2, .slipped = 20ms});
  step({.contact_phases = 14, .cuts = 1, .overruns = 3, .slipped = 50ms});
  EXPECT_EQ(read().ticks, 2);
  EXPECT_EQ(read().contact_phases, 14);
  EXPECT_EQ(read().cuts, 1);
  EXPECT_EQ(read().overruns, 3);
  EXPECT_NEAR(read().slipped_s, 0.05, 1e-12);
  EXPECT_NEAR(read().tick_cpu_s, 0.008, 1e-12);
  EXPECT_EQ(read().tick_duration.total, 2U);
}

TEST_F(RunMetricsTest, NeedsAWorkerOnlyWhileItTicks) {
  EXPECT_EQ(read().worker_need, 0);
  metrics_.start_ticking();
  EXPECT_EQ(read().worker_need, kWhole / 2);
  metrics_.set_period(20ms);
  step({});
  EXPECT_EQ(read().worker_need, kWhole / 4);
  metrics_.stop_ticking();
  EXPECT_EQ(read().worker_need, 0);
  sheet::TickReport report;
  report.advanced = true;
  metrics_.tick_done({.wall = 9ms, .cpu = 9ms, .cost = {}, .totals = {}}, report, {});  // A step() by hand.
  EXPECT_EQ(read().worker_need, 0);
  metrics_.start_ticking();
  EXPECT_EQ(read().worker_need, kWhole / 4);
}

TEST_F(RunMetricsTest, TellsCommandsDoneFromThoseRefused) {
  CommandResult cut;
  cut.reply.cut.emplace();
  cut.timings.cut_us = 3000.0;
  step({}, {cut, CommandResult{}, Error{}});
  EXPECT_EQ(read().commands, 2);
  EXPECT_EQ(read().commands_refused, 1);
  EXPECT_EQ(read().cut_duration.total, 1U);
  EXPECT_NEAR(read().cut_duration.sum, 0.003, 1e-12);
  metrics_.commands_refused(4);
  EXPECT_EQ(read().commands_refused, 5);
}

TEST_F(RunMetricsTest, SharesTheTimeOfATickOutByItsCountedCost) {
  sheet::TickReport report;
  report.advanced = true;
  fem::TickCost cost;
  cost.ns[0] = 1.0;
  cost.ns[1] = 3.0;
  metrics_.tick_done({.wall = 5ms, .cpu = 4ms, .cost = cost, .totals = {}}, report, {});
  EXPECT_NEAR(read().tick_part_cpu_s[0], 0.001, 1e-12);
  EXPECT_NEAR(read().tick_part_cpu_s[1], 0.003, 1e-12);
}

TEST_F(RunMetricsTest, CountsFailedAndShortTicksThatDoNotAdvance) {
  sheet::TickReport report;
  report.step_failed = true;
  metrics_.tick_done({.is_short = true, .cost = {}, .totals = {}}, report, {});
  EXPECT_EQ(read().ticks, 0);
  EXPECT_EQ(read().failed_ticks, 1);
  EXPECT_EQ(read().short_ticks, 1);
  EXPECT_EQ(read().tick_duration.total, 0U);
}

}  // namespace
}  // namespace kerf::host
