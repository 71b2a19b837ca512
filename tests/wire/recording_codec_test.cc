#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "kerf/v1/run.pb.h"
#include "server/base/random.h"
#include "server/wire/protobuf_log.h"
#include "server/wire/recording_codec.h"
#include "tests/wire/codec_checks.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;
using ::testing::HasSubstr;

sheet::Recording sample_recording() {
  sheet::Recording recording;
  recording.config = decoded(full_scene());
  SeededRandom random(8);
  for (std::int64_t tick = 1; tick <= 20; ++tick) {
    sheet::RecordedTick entry{tick, {}, random.next()};
    if (tick % 5 == 0) entry.commands.push_back(recording.config.commands[static_cast<std::size_t>(tick / 5)].command);
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

std::string encode(const sheet::Recording& recording) {
  std::string file = encode_recording_header(recording.config, "0.1.0 g++");
  for (const sheet::RecordedTick& entry : recording.entries) file += encode_recorded_tick(entry);
  return file;
}

TEST(RecordingCodec, ComesBackUnchanged) {
  const sheet::Recording recording = sample_recording();
  const std::string file = encode(recording);
  const Result<RecordingFile> read = decode_recording(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->build, "0.1.0 g++");
  ASSERT_EQ(read->recording.entries.size(), 20U);
  EXPECT_EQ(read->recording.entries[3].state_hash, recording.entries[3].state_hash);
  EXPECT_EQ(read->recording.entries[4].commands.size(), 1U);
  EXPECT_EQ(encode(read->recording), file);
}

TEST(RecordingCodec, EveryTruncationIsRefusedWithItsOffset) {
  const sheet::Recording recording = sample_recording();
  const std::string file = encode(recording);
  std::size_t boundary = encode_recording_header(recording.config, "0.1.0 g++").size();
  std::vector<std::size_t> boundaries{boundary};
  for (const sheet::RecordedTick& entry : recording.entries) {
    boundaries.push_back(boundary += encode_recorded_tick(entry).size());
  }
  std::size_t start = 0;  // of the message that the cut goes through
  for (std::size_t length = 0; length < file.size(); ++length) {
    const Result<RecordingFile> read = decode_recording(std::string_view(file).substr(0, length));
    if (std::find(boundaries.begin(), boundaries.end(), length) != boundaries.end()) {
      ASSERT_TRUE(read.ok()) << length << ": a recording that was stopped between two ticks is whole";
      start = length;
      continue;
    }
    ASSERT_FALSE(read.ok()) << length;
    EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
    EXPECT_EQ(read.error().reason, "RECORDING_TRUNCATED");
    EXPECT_EQ(read.error().field, "offset " + std::to_string(start)) << length;
  }
}

TEST(RecordingCodec, DamageIsRefusedOrChangesOnlyWhatItHits) {
  discard_protobuf_log();
  const std::string file = encode(sample_recording());
  int refused = 0;
  for (std::size_t at = 0; at < file.size(); ++at) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x80);
    const Result<RecordingFile> read = decode_recording(damaged);
    if (read.ok()) continue;  // a number or text that still is one: replay finds it by its hash
    ++refused;
    EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
    EXPECT_THAT(read.error().field, HasSubstr("offset "));
  }
  EXPECT_GT(refused, 50);
}

TEST(RecordingCodec, OtherFilesAreNoRecordings) {
  EXPECT_EQ(decode_recording("").error().reason, "RECORDING_TRUNCATED");
  EXPECT_EQ(decode_recording(std::string("\x02\x7b\x7d", 3)).error().reason, "RECORDING_FORMAT");
  v1::RecordingHeader header;
  header.set_magic("kerf-recording");
  header.set_format_version(3);
  std::string file(1, static_cast<char>(header.ByteSizeLong()));
  header.AppendToString(&file);
  EXPECT_EQ(decode_recording(file).error().reason, "RECORDING_FORMAT");
  EXPECT_THAT(decode_recording(file).error().message, HasSubstr("version 3"));
}

TEST(RecordingCodec, FilesOfVersionOneAreReadAsWell) {
  v1::RecordingHeader header;
  header.set_magic("kerf-recording");
  header.set_format_version(1);
  header.mutable_scene()->mutable_grid()->set_columns(2);
  header.mutable_scene()->mutable_grid()->set_rows(2);
  header.mutable_scene()->mutable_grid()->set_width_m(1.0);
  header.mutable_scene()->mutable_grid()->set_height_m(1.0);
  ASSERT_LT(header.ByteSizeLong(), 128U);
  std::string file(1, static_cast<char>(header.ByteSizeLong()));
  header.AppendToString(&file);
  const Result<RecordingFile> read = decode_recording(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->recording.entries.empty());
}

}  // namespace
}  // namespace kerf::wire
