// Recordings to disk (kerfd --record), on disks that run full.
#include "server/app/file_recording.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/base/disk.h"
#include "server/core/sheet/recording.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/recording_codec.h"
#include "tests/support/manual_clock.h"
#include "tests/support/memory_disk.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace kerf::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::size_t kRoom = std::size_t{1} << 26;

class FileRecordingTest : public ::testing::Test {
 protected:
  FileRecordingTest() { open("a.kerf"); }

  void open(const std::string& path) { open(disk_, path); }
  void open(Disk& disk, const std::string& path) {
    recording_ = std::make_unique<FileRecording>(disk, clock_, board_, path,
                                                 [this](const std::string& line) { lines_.push_back(line); });
  }
  // Starts the recording, with room for the header and `num_entries` entries.
  void start_with_room_for(std::size_t num_entries) {
    const std::size_t header = wire::encode_recording_header(config_, wire::build_name()).size();
    disk_.set_capacity(header + num_entries * wire::encode_recorded_tick({1, {}, 1}).size());
    recording_->start(config_);
  }
  // Appends entries of the next ticks; the clock moves by `apart` before each.
  void append(int count, host::Nanoseconds apart = {}) {
    for (int i = 0; i < count; ++i) {
      clock_.move_to(clock_.now() + apart);
      expected_.push_back({++tick_, {}, 1000U + static_cast<std::uint64_t>(tick_)});
      recording_->append(expected_.back());
    }
  }
  // Appends an entry of some 100 kB.
  void append_long() {
    scene::Cut cut;
    cut.curve = cut::Polyline{std::vector<Eigen::Vector2d>(4096, Eigen::Vector2d(0.25, 0.75))};
    expected_.push_back({++tick_, {cut}, 1});
    recording_->append(expected_.back());
  }
  void wait_a_second() { clock_.move_to(clock_.now() + FileRecording::kRetryInterval); }
  [[nodiscard]] std::string file() { return disk_.read_file("a.kerf", kRoom).value(); }
  // Returns the file that a disk with room would have.
  [[nodiscard]] std::string whole() const {
    std::string bytes = wire::encode_recording_header(config_, wire::build_name());
    for (const sheet::RecordedTick& entry : expected_) bytes += wire::encode_recorded_tick(entry);
    return bytes;
  }
  // Returns how many entries the file has, and expects them to be whole.
  [[nodiscard]] std::size_t num_whole_entries() {
    const Result<wire::RecordingFile> read = wire::decode_recording(file());
    EXPECT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->recording.torn_bytes, 0);
    return read->recording.entries.size();
  }

  const scene::SheetConfig config_ = scenes::hanging(3);
  test::MemoryDisk disk_{kRoom};
  test::ManualClock clock_;
  RecordingBoard board_;
  std::vector<std::string> lines_;
  std::unique_ptr<FileRecording> recording_;
  std::vector<sheet::RecordedTick> expected_;
  std::int64_t tick_ = 0;
};

TEST_F(FileRecordingTest, AFullDiskLosesNothingOnceThereIsRoomAgain) {
  start_with_room_for(3);
  append(10);
  EXPECT_EQ(num_whole_entries(), 3U);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("recording a.kerf pauses: ")));
  EXPECT_EQ(board_.open, 1);
  EXPECT_EQ(board_.stopped, 1);
  EXPECT_EQ(board_.errors, 1);
  EXPECT_EQ(board_.bytes, static_cast<std::int64_t>(file().size()));
  EXPECT_EQ(board_.waiting_bytes, static_cast<std::int64_t>(whole().size() - file().size()));

  disk_.set_capacity(kRoom);
  append(1);
  EXPECT_EQ(num_whole_entries(), 3U) << "a second has not passed";
  wait_a_second();
  append(1);
  EXPECT_EQ(file(), whole());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: "), HasSubstr("recording a.kerf resumes")));
  EXPECT_EQ(board_.stopped, 0);
  EXPECT_EQ(board_.waiting_bytes, 0);
  append(5);
  EXPECT_EQ(file(), whole());
  EXPECT_EQ(board_.errors, 1);
}

TEST_F(FileRecordingTest, EndsEarlyWithALineAndAWholeFile) {
  recording_->start(config_);
  append(3);
  recording_->end_early("the sheet went back");
  const std::string file_then = file();
  EXPECT_EQ(file_then, whole());
  append(3);
  recording_->end_early("again");
  EXPECT_EQ(file(), file_then);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr("a.kerf has ended: the sheet went back; the file replays up to its last")));
  EXPECT_EQ(board_.stopped, 1);
  recording_.reset();
  EXPECT_EQ(board_.stopped, 0);
  EXPECT_EQ(board_.open, 0);
}

TEST_F(FileRecordingTest, EndingEarlyOnAFullDiskTriesALastTime) {
  start_with_room_for(1);
  append(3);
  disk_.set_capacity(kRoom);
  recording_->end_early("the sheet went back");
  EXPECT_EQ(file(), whole());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: "), HasSubstr(" resumes"), HasSubstr(" has ended: ")));
  EXPECT_EQ(board_.waiting_bytes, 0);
}

TEST_F(FileRecordingTest, TriesOnceASecond) {
  start_with_room_for(0);
  append(600, FileRecording::kRetryInterval / 60);
  EXPECT_EQ(board_.errors, 10);
  EXPECT_EQ(lines_.size(), 1U);
}

TEST_F(FileRecordingTest, ASheetOfAFullDiskIsRecordedFromItsBeginning) {
  disk_.set_capacity(0);
  recording_->start(config_);
  append(200);
  EXPECT_EQ(file(), "");
  disk_.set_capacity(kRoom);
  wait_a_second();
  append(1);
  EXPECT_EQ(file(), whole());
}

TEST_F(FileRecordingTest, WithRoomForSomeOfWhatWaitsItWritesThat) {
  start_with_room_for(0);
  append(2000);
  disk_.set_capacity(whole().size() - 10'000);
  wait_a_second();
  append(1);
  const std::size_t written = num_whole_entries();
  EXPECT_GT(written, 1000U);
  EXPECT_LT(written, 2000U);
  EXPECT_EQ(board_.stopped, 1);
  disk_.set_capacity(kRoom);
  wait_a_second();
  append(1);
  EXPECT_EQ(file(), whole());
}

TEST_F(FileRecordingTest, WhereMoreWaitsThanMayItEndsWithAWholeFile) {
  start_with_room_for(2);
  append(2);
  std::int64_t most = 0;
  for (int i = 0; i < 30 && lines_.size() < 2; ++i) {
    append_long();
    most = std::max<std::int64_t>(most, board_.waiting_bytes);
  }
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: "), HasSubstr("recording a.kerf has ended")));
  EXPECT_GT(most, FileRecording::kMaxWaitingBytes / 2);
  EXPECT_LE(most, FileRecording::kMaxWaitingBytes);
  EXPECT_EQ(board_.waiting_bytes, 0);
  disk_.set_capacity(kRoom);
  wait_a_second();
  append(1);
  EXPECT_EQ(num_whole_entries(), 2U);
  EXPECT_EQ(board_.stopped, 1);
  EXPECT_EQ(lines_.size(), 2U);
  recording_.reset();
  EXPECT_EQ(board_.stopped, 0);
  EXPECT_EQ(board_.open, 0);
}

TEST_F(FileRecordingTest, AllRecordingsTogetherHaveALimit) {
  start_with_room_for(1);
  append(1);
  board_.waiting_bytes = FileRecording::kMaxAllWaitingBytes;  // of others
  append(1);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: "), HasSubstr(" has ended")));
  EXPECT_EQ(board_.waiting_bytes, FileRecording::kMaxAllWaitingBytes);
}

TEST_F(FileRecordingTest, TheLastTryIsAtTheEnd) {
  start_with_room_for(1);
  append(4);
  disk_.set_capacity(kRoom);
  recording_.reset();
  EXPECT_EQ(file(), whole());
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: "), HasSubstr(" resumes")));
  EXPECT_EQ(board_.open, 0);
  EXPECT_EQ(board_.stopped, 0);
}

TEST_F(FileRecordingTest, WhatIsNeverWrittenIsCountedInALine) {
  start_with_room_for(1);
  append(4);
  const std::string missing = std::to_string(board_.waiting_bytes);
  recording_.reset();
  EXPECT_EQ(num_whole_entries(), 1U);
  EXPECT_THAT(lines_,
              ElementsAre(HasSubstr(" pauses: "), HasSubstr("ends with its sheet, " + missing + " bytes short")));
  EXPECT_EQ(board_.waiting_bytes, 0);
  EXPECT_EQ(board_.errors, 2);
}

TEST_F(FileRecordingTest, AFileThatCannotBeMadeIsMadeLater) {
  const test::TemporaryFolder folder;
  RealDisk disk;
  const std::string path = folder / "later/a.kerf";
  open(disk, path);
  recording_->start(config_);
  append(3);
  EXPECT_THAT(lines_, ElementsAre(HasSubstr(" pauses: cannot create ")));
  std::filesystem::create_directory(folder / "later");
  wait_a_second();
  append(1);
  EXPECT_EQ(disk.read_file(path, kRoom).value(), whole());
}

TEST_F(FileRecordingTest, ARunWithAFullDiskInItIsReplayedBitForBit) {
  Result<sheet::Sheet> sheet = sheet::Sheet::create(config_);
  ASSERT_TRUE(sheet.ok());
  start_with_room_for(5);
  for (int i = 0; i < 20; ++i) {
    if (i == 10) {
      disk_.set_capacity(kRoom);
      wait_a_second();
    }
    const sheet::TickReport report = sheet->step({});
    recording_->append({report.tick, {}, sheet->state_hash()});
  }
  const Result<wire::RecordingFile> read = wire::decode_recording(file());
  ASSERT_TRUE(read.ok()) << read.error().message;
  const Result<sheet::ReplayReport> replayed = sheet::replay(read->recording);
  ASSERT_TRUE(replayed.ok());
  EXPECT_FALSE(replayed->divergence);
  EXPECT_EQ(replayed->ticks, 20);
}

}  // namespace
}  // namespace kerf::app
