#include "client/load/stages.h"

#include <atomic>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/load/plan.h"
#include "client/load/ramp.h"

namespace kerf::load {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::vector<std::pair<Nanoseconds, std::int32_t>> steps_in(const std::string& text) {
  std::vector<std::pair<Nanoseconds, std::int32_t>> found;
  for (const Step& step : steps_of(*parse_stages(text))) found.emplace_back(step.time, step.count);
  return found;
}

std::string wrong_stages(const std::string& text) {
  const Result<std::vector<Stage>> stages = parse_stages(text);
  return stages.ok() ? "" : stages.error().reason + " " + stages.error().message;
}

TEST(Stages, ChangeEvenly) {
  using Steps = std::vector<std::pair<Nanoseconds, std::int32_t>>;
  EXPECT_EQ(steps_in("4s:2"), (Steps{{1s, 1}, {3s, 2}}));
  EXPECT_EQ(steps_in("4s:2, 10s:2,2s:0"), (Steps{{1s, 1}, {3s, 2}, {14500ms, 1}, {15500ms, 0}}));
  EXPECT_EQ(steps_in("0s:3,1s:3"), (Steps{{0s, 1}, {0s, 2}, {0s, 3}}));
  EXPECT_EQ(steps_in("500ms:1,1m:0"), (Steps{{250ms, 1}, {30500ms, 0}}));
  EXPECT_TRUE(steps_in("5s:0").empty());
}

TEST(Stages, HaveALengthALargestTargetAndAMean) {
  const std::vector<Stage> stages = *parse_stages("4s:2,10s:2,2s:0");
  EXPECT_EQ(length_s(stages), 16.0);
  EXPECT_EQ(largest_target(stages), 2);
  EXPECT_EQ(mean_count(stages, 4.0, 10.0), 2.0);
  EXPECT_EQ(mean_count(stages, 0.0, 4.0), 1.0);
  EXPECT_DOUBLE_EQ(mean_count(stages, 0.0, 16.0), (4.0 * 1.0 + 10.0 * 2.0 + 2.0 * 1.0) / 16.0);
  EXPECT_EQ(text_of(stages), "4s:2,10s:2,2s:0");
  EXPECT_EQ(text_of({}), "");
}

TEST(Stages, ThatAreMalformedAreRefused) {
  for (const char* text :
       {"", "10s", "10:4", "s:4", "10h:4", "10s:-1", "10s:10001", "10s:4x", "31m:1", "-1s:1", "10s:4,,1s:1"}) {
    EXPECT_THAT(wrong_stages(text), HasSubstr("BAD_STAGES --stages: ")) << text;
  }
  std::string many;
  for (int i = 0; i < 101; ++i) many += "1s:1,";
  many.pop_back();
  EXPECT_THAT(wrong_stages(many), HasSubstr("more than 100"));
}

TEST(Stages, SetThePlan) {
  Plan plan;
  set_stages(*parse_stages("4s:2,10s:7,2s:0"), Staged::kViewers, plan);
  EXPECT_EQ(plan.duration_s, 16.0);
  EXPECT_EQ(plan.viewers, 7);
  EXPECT_EQ(plan.sheets, 1);
  set_stages(*parse_stages("1s:3"), Staged::kSheets, plan);
  EXPECT_EQ(plan.sheets, 3);
  set_stages(*parse_stages("1s:0"), Staged::kSheets, plan);
  EXPECT_EQ(check(plan).error().field, "--sheets");
  set_stages(*parse_stages("1s:1001"), Staged::kViewers, plan);
  EXPECT_FALSE(check(plan).ok());
}

// Time passes as the ramp asks for it.
class Eager : public Waiter {
 public:
  [[nodiscard]] Nanoseconds now() const override { return now_; }
  bool wait_until(Nanoseconds time) override {
    if (time > end_) return false;
    now_ = std::max(now_.load(), time);
    return true;
  }
  std::atomic<Nanoseconds> now_{0s};
  Nanoseconds end_{1h};
};

TEST(Ramp, FollowsTheStages) {
  Eager waiter;
  std::vector<std::pair<Nanoseconds, std::int32_t>> seen;
  {
    const Ramp ramp(*parse_stages("4s:2,2s:0"), 100s, waiter,
                    [&](std::int32_t count) { seen.emplace_back(waiter.now(), count); });
  }
  EXPECT_EQ(seen,
            (std::vector<std::pair<Nanoseconds, std::int32_t>>{{101s, 1}, {103s, 2}, {104500ms, 1}, {105500ms, 0}}));
}

TEST(Ramp, EndsWithTheRun) {
  Eager waiter;
  waiter.end_ = 102s;
  std::vector<std::int32_t> seen;
  {
    const Ramp ramp(*parse_stages("4s:2,2s:0"), 100s, waiter, [&](std::int32_t count) { seen.push_back(count); });
  }
  EXPECT_EQ(seen, std::vector<std::int32_t>{1});
}

}  // namespace
}  // namespace kerf::load
