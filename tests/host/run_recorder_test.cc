#include "server/service/host/run_recorder.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

// Writes an entry as its tick, one "!" a command, and a blank.
std::string encode(const sheet::RecordedTick& entry) {
  return std::to_string(entry.tick) + std::string(entry.commands.size(), '!') + " ";
}

class RunRecorderTest : public testing::Test {
 protected:
  void begin(bool with_sink) { recorder_.begin(with_sink ? sink_ : nullptr, {}); }
  void append(std::int64_t tick, std::size_t num_commands) {
    sheet::RecordedTick entry{tick, std::vector<scene::Command>(num_commands, scene::SetGravity{}), 0};
    recorder_.append(entry, [this] { return hash(); });
  }
  void prepare(std::int64_t tick) {
    recorder_.prepare(tick, [this] { return hash(); });
  }
  std::uint64_t hash() { return static_cast<std::uint64_t>(++hashes_); }

  RunRecorder recorder_{KeptRecording(encode, 1000)};
  std::shared_ptr<sheet::Recorder> sink_ = std::make_shared<sheet::Recorder>();
  int hashes_ = 0;
};

TEST_F(RunRecorderTest, HashesOnlyWhatIsRecorded) {
  begin(false);
  append(1, 0);
  EXPECT_EQ(hashes_, 0);
  append(2, 1);
  EXPECT_EQ(hashes_, 1);
  append(KeptRecording::kHashInterval, 0);
  EXPECT_EQ(hashes_, 2);
  EXPECT_EQ(recorder_.until(KeptRecording::kHashInterval, 0).value(), "2! 64 ");
}

TEST_F(RunRecorderTest, ASinkGetsEveryTick) {
  begin(true);
  append(1, 0);
  append(2, 1);
  ASSERT_EQ(sink_->recording().entries.size(), 2U);
  EXPECT_EQ(sink_->recording().entries[1].state_hash, 2U);
  EXPECT_EQ(recorder_.until(2, 0).value(), "2! ");
  recorder_.end();
  append(3, 1);
  EXPECT_EQ(sink_->recording().entries.size(), 2U);
  EXPECT_EQ(sink_.use_count(), 1);
}

TEST_F(RunRecorderTest, AnApplyIsPrecededByTheTickItStandsAt) {
  begin(false);
  prepare(5);
  recorder_.settle(true);
  append(5, 1);
  EXPECT_EQ(recorder_.until(5, 0).value(), "5 5! ");
  prepare(5);  // An entry of that tick is there already.
  recorder_.settle(true);
  append(5, 1);
  EXPECT_EQ(recorder_.until(5, 0).value(), "5 5! 5! ");
}

TEST_F(RunRecorderTest, ContinuesAfterEntriesOfEarlierAndEndsTheOneOfTheSink) {
  begin(true);
  append(2, 1);
  const KeptEntries earlier = recorder_.kept();
  append(3, 1);
  prepare(4);
  recorder_.replace(earlier, "it went back");
  recorder_.settle(true);
  append(3, 2);
  EXPECT_EQ(recorder_.until(3, 0).value(), "2! 3!! ");
  EXPECT_EQ(sink_->recording().entries.size(), 2U);
  EXPECT_EQ(sink_.use_count(), 1);
  recorder_.replace({"", 0, 9}, "");
  EXPECT_EQ(recorder_.until(9, 0).error().reason, "RECORDING_TOO_LONG") << "as it was dropped then";
}

TEST_F(RunRecorderTest, AStepForgetsTheStatePrepared) {
  begin(false);
  prepare(5);
  recorder_.settle(false);
  append(6, 1);
  recorder_.settle(true);
  EXPECT_EQ(recorder_.until(6, 0).value(), "6! ");
}

}  // namespace
}  // namespace kerf::host
