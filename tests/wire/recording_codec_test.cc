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

std::string framed(const google::protobuf::MessageLite& message) {
  std::string bytes;
  for (std::size_t length = message.ByteSizeLong(); true; length >>= 7) {
    bytes.push_back(static_cast<char>((length & 0x7f) | (length >= 0x80 ? 0x80 : 0)));
    if (length < 0x80) break;
  }
  message.AppendToString(&bytes);
  return bytes;
}

std::string refusal_of(const std::string& file, const RecordingLimits& limits = {}) {
  const Result<RecordingFile> read = decode_recording(file, limits);
  if (read.ok()) return "none";
  EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
  EXPECT_THAT(read.error().field, HasSubstr("offset "));
  return read.error().reason;
}

// One entry of tick 1 with these commands.
sheet::Recording one_tick(std::vector<sheet::Command> commands) {
  return {decoded(full_scene()), {{1, std::move(commands), 7}}};
}

TEST(RecordingCodec, EntriesThatTellNothingAreRefusedAtTheFirst) {
  const std::string header = encode_recording_header(sample_recording().config, "");
  const Result<RecordingFile> read = decode_recording(header + std::string(1 << 20, '\0'));
  ASSERT_FALSE(read.ok()) << read->recording.entries.size() << " entries";
  EXPECT_EQ(read.error().reason, "RECORDING_ORDER");
  EXPECT_EQ(read.error().field, "offset " + std::to_string(header.size()));
  const std::string bare = encode_recorded_tick({5, {}, 1});
  EXPECT_EQ(refusal_of(header + bare), "none");
  EXPECT_EQ(refusal_of(header + bare + bare), "RECORDING_ORDER");
  EXPECT_EQ(refusal_of(header + bare + encode_recorded_tick({4, {}, 1})), "RECORDING_ORDER");
  EXPECT_EQ(refusal_of(header + bare + encode_recorded_tick({5, {sheet::UndoCut{}}, 1})), "none");
}

TEST(RecordingCodec, NoMoreIsReadThanMayBe) {
  const std::string file = encode(sample_recording());
  EXPECT_EQ(refusal_of(file, {.max_entries = 20}), "none");
  EXPECT_EQ(refusal_of(file, {.max_entries = 19}), "RECORDING_TOO_LARGE");
  sheet::Cut line;
  line.curve = cut::Polyline{{{0.0, 0.0}, {1.0, 0.0}}};
  const cut::Subpath subpath{{0.0, 0.0}, {cut::LineTo{{1.0, 0.0}}, cut::LineTo{{1.0, 1.0}}}};
  sheet::Cut corner;
  corner.curve = cut::Path{{subpath}};
  // An undo; a batch with two cuts, one of them a subpath of two segments; pins in two regions: 1 + 6 + 3.
  const std::string parts = encode(one_tick({sheet::UndoCut{}, sheet::CutBatch{{line, corner}},
                                             sheet::SetPins{{sheet::RegionEdge::kTop, sheet::RegionEdge::kLeft}}}));
  EXPECT_EQ(refusal_of(parts, {.max_parts = 10}), "none");
  EXPECT_EQ(refusal_of(parts, {.max_parts = 9}), "RECORDING_TOO_LARGE");
}

TEST(RecordingCodec, ATickHasNoMoreCommandsThanALiveOne) {
  std::vector<sheet::Command> commands(sheet::kMaxTickCommands, sheet::UndoCut{});
  EXPECT_EQ(refusal_of(encode(one_tick(commands))), "none");
  commands.emplace_back(sheet::UndoCut{});
  EXPECT_EQ(refusal_of(encode(one_tick(commands))), "RECORDING_TICK");
}

TEST(RecordingCodec, WhatUnfoldsIsShort) {
  const std::string header = encode_recording_header(sample_recording().config, "");
  const std::string length("\x80\x80\x80\x04", 4);  // 8 MiB
  EXPECT_EQ(refusal_of(header + length + std::string(kMaxRecordedMessageBytes, '\0')), "RECORDING_DAMAGED");
  const std::string longer("\x81\x80\x80\x04", 4);
  EXPECT_EQ(refusal_of(header + longer + std::string(kMaxRecordedMessageBytes + 1, '\0')), "RECORDING_TOO_LARGE");

  v1::RecordingHeader with_mesh;
  with_mesh.set_magic("kerf-recording");
  with_mesh.set_format_version(2);
  with_mesh.mutable_scene()->mutable_obj()->set_text(std::string(kMaxRecordedMessageBytes + 1, '#'));
  EXPECT_EQ(refusal_of(framed(with_mesh)), "none") << "a mesh may be as long as an upload";
  with_mesh.mutable_scene()->set_description(std::string(kMaxRecordedMessageBytes, 'x'));
  EXPECT_EQ(refusal_of(framed(with_mesh)), "RECORDING_TOO_LARGE");
}

TEST(RecordingCodec, ADrawingIsNoRecordedCommand) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_svg()->set_text(
      R"(<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 L100 100"/></svg>)");
  v1::RecordedTick alone, in_batch;
  *alone.add_commands()->mutable_cut() = cut;
  *in_batch.add_commands()->mutable_cut_batch()->add_cuts() = cut;
  const std::string header = encode_recording_header(sample_recording().config, "");
  EXPECT_EQ(refusal_of(header + framed(alone)), "RECORDING_DAMAGED");
  EXPECT_EQ(refusal_of(header + framed(in_batch)), "RECORDING_DAMAGED");
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
