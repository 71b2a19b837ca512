// Names of saved states, and how many there may be.
#include "server/service/host/saved_states.h"

#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include "tests/host/states_fixture.h"

namespace kerf::host {
namespace {

TEST_F(StatesTest, NamesAndLimits) {
  create("a", small_sheet());
  create("b", small_sheet());
  EXPECT_EQ(save("a", "Before").error().reason, "STATE_ID");
  EXPECT_EQ(save("nobody", "one").error().reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(restore("nobody", "one").error().reason, "SHEET_NOT_FOUND");
  EXPECT_EQ(restore("a", "one").error().reason, "STATE_NOT_FOUND");
  EXPECT_EQ(forget("a", "one"), "STATE_NOT_FOUND");
  EXPECT_EQ(forget("nobody", "one"), "SHEET_NOT_FOUND");
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(save("a", "s" + std::to_string(i)).ok());
  EXPECT_EQ(save("a", "s16").error().reason, "TOO_MANY_STATES");
  EXPECT_EQ(save("a", "s3").error().reason, "STATE_EXISTS");
  const std::int64_t tick = status("a").tick;
  run_for(3 * kTick);
  EXPECT_EQ(save("a", "s3", true).value().tick, tick + 3);
  ASSERT_EQ(states("a").size(), 16U);
  EXPECT_EQ(states("a")[15].id, "s3") << "the latest one is last";
  EXPECT_TRUE(save("b", "s16").ok()) << "each sheet has its own";
  EXPECT_EQ(forget("a", "s0"), "done");
  EXPECT_TRUE(save("a", "s16").ok());
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback());
  host_->wait_idle();
  create("a", small_sheet());
  EXPECT_TRUE(states("a").empty()) << "a sheet takes its states with it";
}

class FullStatesTest : public StatesTest {
 protected:
  static constexpr std::int64_t kMaxStateBytes = 50'000;
  static HostOptions small() {
    HostOptions options;
    options.max_state_bytes = kMaxStateBytes;
    return options;
  }
  FullStatesTest() : StatesTest(small()) {}
};

TEST_F(FullStatesTest, AllStatesOfAServerShareItsBytes) {
  create("a", small_sheet(), true);
  create("b", small_sheet(), true);
  const std::int64_t each = save("a", "s0").value().num_bytes;
  const std::int64_t room = kMaxStateBytes / each;
  ASSERT_GT(room, 2);
  ASSERT_LT(room, 16) << "else another limit is met first";
  for (std::int64_t i = 1; i < room; ++i) ASSERT_TRUE(save("a", "s" + std::to_string(i)).ok());
  const Result<SavedStateStatus> refused = save("b", "one");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "STATES_TOO_LARGE");
  EXPECT_TRUE(save("a", "s0", true).ok()) << "what is overwritten makes room";
  EXPECT_EQ(forget("a", "s1"), "done");
  EXPECT_TRUE(save("b", "one").ok());
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback());
  host_->wait_idle();
  for (std::int64_t i = 1; i < room; ++i) EXPECT_TRUE(save("b", "s" + std::to_string(i)).ok());
}

// Builders wait in the integrators that they make until the gate is opened.
class GatedStatesTest : public StatesTest {
 protected:
  GatedStatesTest() : GatedStatesTest(std::make_shared<std::promise<void>>()) {}
  std::shared_ptr<std::promise<void>> gate_;
  std::shared_ptr<std::atomic<bool>> is_shut_ = std::make_shared<std::atomic<bool>>(false);

 private:
  explicit GatedStatesTest(std::shared_ptr<std::promise<void>> gate) : gate_(std::move(gate)) {
    HostOptions options;
    options.make_integrator = [opened = std::shared_future<void>(gate_->get_future()),
                               is_shut = is_shut_](const fem::IntegratorOptions& wanted) {
      if (*is_shut) opened.wait();
      return fem::make_integrator(wanted);
    };
    host_ = std::make_unique<Host>(std::move(options), clock_, entropy_);
  }
};

TEST_F(GatedStatesTest, SixteenStatesAreLoadedAtOnce) {
  create("a", small_sheet(), true);
  ASSERT_TRUE(save("a", "one").ok());
  *is_shut_ = true;
  Answers<SheetStatus> answers;
  for (int i = 0; i < 17; ++i) host_->restore_state("a", "one", answers.callback());
  ASSERT_EQ(answers.count(), 1U) << "the last one, at once";
  EXPECT_EQ(answers.reason(0), "TOO_MANY_RESTORES");
  gate_->set_value();
  host_->wait_idle();
  ASSERT_EQ(answers.count(), 17U);
  for (std::size_t i = 1; i < 17; ++i) EXPECT_EQ(answers.reason(i), "done");
  EXPECT_TRUE(restore("a", "one").ok()) << "there is room again";
}

}  // namespace
}  // namespace kerf::host
