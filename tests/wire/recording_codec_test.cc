#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "kerf/v1/run.pb.h"
#include "server/base/random.h"
#include "server/core/scene/mesh_source.h"
#include "server/service/wire/protobuf_log.h"
#include "server/service/wire/recording_codec.h"
#include "server/service/wire/recording_frames.h"
#include "tests/support/paths.h"
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

// Returns the message as formats 1 and 2 have it.
std::string plain_frame(const google::protobuf::MessageLite& message) {
  std::string bytes;
  for (std::size_t length = message.ByteSizeLong(); true; length >>= 7) {
    bytes.push_back(static_cast<char>((length & 0x7f) | (length >= 0x80 ? 0x80 : 0)));
    if (length < 0x80) break;
  }
  message.AppendToString(&bytes);
  return bytes;
}

v1::RecordingHeader small_header(std::int32_t format) {
  v1::RecordingHeader header;
  header.set_magic("kerf-recording");
  header.set_format_version(format);
  v1::GridMesh& grid = *header.mutable_scene()->mutable_grid();
  grid.set_columns(2);
  grid.set_rows(2);
  grid.set_width_m(1.0);
  grid.set_height_m(1.0);
  return header;
}

// Returns the header and each entry of a short recording.
std::vector<std::string> small_messages(std::int32_t format) {
  const bool is_plain = format < 3;
  const auto frame = [is_plain](const auto& message) {
    return is_plain ? plain_frame(message) : recording_frame(message);
  };
  std::vector<std::string> messages{(is_plain ? "" : std::string(kRecordingSignature)) + frame(small_header(format))};
  SeededRandom random(8);
  for (std::int64_t tick = 1; tick <= 5; ++tick) {
    v1::RecordedTick entry;
    entry.set_tick(100 * tick);
    entry.set_state_hash(random.next());
    if (tick % 2 == 0) entry.add_commands()->mutable_undo_cut();
    messages.push_back(frame(entry));
  }
  return messages;
}

std::string joined(const std::vector<std::string>& messages) {
  std::string file;
  for (const std::string& message : messages) file += message;
  return file;
}

TEST(RecordingCodec, ATornEndIsLeftOutAtEveryLength) {
  for (const std::int32_t format : {1, 2, 3}) {
    const std::vector<std::string> messages = small_messages(format);
    const std::string file = joined(messages);
    std::size_t num_entries = 0;
    std::size_t whole = messages[0].size();  // bytes of the header and the entries that are there
    for (std::size_t length = 0; length <= file.size(); ++length) {
      const Result<RecordingFile> read = decode_recording(std::string_view(file).substr(0, length));
      if (length < messages[0].size()) {
        ASSERT_FALSE(read.ok()) << length;
        EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
        EXPECT_EQ(read.error().reason, "RECORDING_TRUNCATED") << length;
        EXPECT_THAT(read.error().field, HasSubstr("offset ")) << length;
        continue;
      }
      if (num_entries + 1 < messages.size() && whole + messages[num_entries + 1].size() == length) {
        whole += messages[++num_entries].size();
      }
      ASSERT_TRUE(read.ok()) << "format " << format << ", " << length << ": " << read.error().message;
      EXPECT_EQ(read->recording.entries.size(), num_entries) << length;
      EXPECT_EQ(read->recording.torn_bytes, static_cast<std::int64_t>(length - whole)) << length;
    }
    EXPECT_EQ(num_entries, 5U);
  }
}

TEST(RecordingCodec, EveryFlippedBitIsDamage) {
  discard_protobuf_log();
  const std::vector<std::string> messages = small_messages(3);
  const std::string file = joined(messages);
  std::size_t start = 0;  // of the message that the bit is in
  std::size_t end = messages[0].size();
  std::size_t next = 1;
  for (std::size_t at = 0; at < file.size(); ++at) {
    if (at == kRecordingSignature.size()) start = at;
    if (at == end) {
      start = end;
      end += messages[next++].size();
    }
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = file;
      flipped[at] = static_cast<char>(flipped[at] ^ (1 << bit));
      const Result<RecordingFile> read = decode_recording(flipped);
      ASSERT_FALSE(read.ok()) << "byte " << at << ", bit " << bit;
      EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
      EXPECT_EQ(read.error().reason, "RECORDING_DAMAGED") << "byte " << at << ", bit " << bit;
      EXPECT_EQ(read.error().field, "offset " + std::to_string(start)) << "byte " << at << ", bit " << bit;
    }
  }
}

TEST(RecordingCodec, ABitOfEachByteOfALargerFile) {
  const std::string file = encode(sample_recording());
  SeededRandom random(31);
  for (std::size_t at = 0; at < file.size(); ++at) {
    std::string flipped = file;
    flipped[at] = static_cast<char>(flipped[at] ^ (1U << (random.next() % 8)));
    const Result<RecordingFile> read = decode_recording(flipped);
    ASSERT_FALSE(read.ok()) << "byte " << at;
    EXPECT_EQ(read.error().reason, "RECORDING_DAMAGED") << "byte " << at;
  }
}

TEST(RecordingCodec, OtherDamageIsFoundAsWell) {
  const std::vector<std::string> messages = small_messages(3);
  const std::string file = joined(messages);
  std::string zeroed = file;  // from the last entry's head on
  std::fill(zeroed.end() - static_cast<std::ptrdiff_t>(messages.back().size()), zeroed.end(), '\0');
  EXPECT_EQ(decode_recording(zeroed).error().reason, "RECORDING_DAMAGED");
  EXPECT_EQ(decode_recording(file + std::string(64, '\0')).error().reason, "RECORDING_DAMAGED");
  EXPECT_EQ(decode_recording(file + std::string(64, '\xff')).error().reason, "RECORDING_DAMAGED");
  for (std::size_t at = messages[0].size(); at < file.size(); ++at) {
    std::string shorter = file;
    shorter.erase(at, 1);
    const Result<RecordingFile> read = decode_recording(shorter);
    // A byte that is missing in the last entry's message looks like one that was never written.
    const bool is_last = at >= file.size() - messages.back().size() + kFrameHeadBytes;
    EXPECT_EQ(read.ok(), is_last) << at;
  }
}

std::string refusal_of(const std::string& file, const RecordingLimits& limits = {}) {
  const Result<RecordingFile> read = decode_recording(file, limits);
  if (read.ok()) return "none";
  EXPECT_EQ(read.error().code, ErrorCode::kDataLoss);
  EXPECT_THAT(read.error().field, HasSubstr("offset "));
  return read.error().reason;
}

// One entry of tick 1 with these commands.
sheet::Recording one_tick(std::vector<scene::Command> commands) {
  return {decoded(full_scene()), {{1, std::move(commands), 7}}};
}

TEST(RecordingCodec, EntriesThatTellNothingAreRefusedAtTheFirst) {
  const std::string header = encode_recording_header(sample_recording().config, "");
  std::string empty;
  for (int i = 0; i < 1000; ++i) empty += recording_frame(v1::RecordedTick());
  const Result<RecordingFile> read = decode_recording(header + empty);
  ASSERT_FALSE(read.ok()) << read->recording.entries.size() << " entries";
  EXPECT_EQ(read.error().reason, "RECORDING_ORDER");
  EXPECT_EQ(read.error().field, "offset " + std::to_string(header.size()));
  const std::string bare = encode_recorded_tick({5, {}, 1});
  EXPECT_EQ(refusal_of(header + bare), "none");
  EXPECT_EQ(refusal_of(header + bare + bare), "RECORDING_ORDER");
  EXPECT_EQ(refusal_of(header + bare + encode_recorded_tick({4, {}, 1})), "RECORDING_ORDER");
  EXPECT_EQ(refusal_of(header + bare + encode_recorded_tick({5, {scene::UndoCut{}}, 1})), "none");
}

TEST(RecordingCodec, NoMoreIsReadThanMayBe) {
  const std::string file = encode(sample_recording());
  EXPECT_EQ(refusal_of(file, {.max_entries = 20}), "none");
  EXPECT_EQ(refusal_of(file, {.max_entries = 19}), "RECORDING_TOO_LARGE");
  scene::Cut line;
  line.curve = cut::Polyline{{{0.0, 0.0}, {1.0, 0.0}}};
  const cut::Subpath subpath{{0.0, 0.0}, {cut::LineTo{{1.0, 0.0}}, cut::LineTo{{1.0, 1.0}}}};
  scene::Cut corner;
  corner.curve = cut::Path{{subpath}};
  // An undo; a batch with two cuts, one of them a subpath of two segments; pins in two regions: 1 + 6 + 3.
  const std::string parts = encode(one_tick({scene::UndoCut{}, scene::CutBatch{{line, corner}},
                                             scene::SetPins{{scene::RegionEdge::kTop, scene::RegionEdge::kLeft}}}));
  EXPECT_EQ(refusal_of(parts, {.max_parts = 10}), "none");
  EXPECT_EQ(refusal_of(parts, {.max_parts = 9}), "RECORDING_TOO_LARGE");
}

TEST(RecordingCodec, ATickHasNoMoreCommandsThanALiveOne) {
  std::vector<scene::Command> commands(sheet::kMaxTickCommands, scene::UndoCut{});
  EXPECT_EQ(refusal_of(encode(one_tick(commands))), "none");
  commands.emplace_back(scene::UndoCut{});
  EXPECT_EQ(refusal_of(encode(one_tick(commands))), "RECORDING_TICK");
}

TEST(RecordingCodec, WhatUnfoldsIsShort) {
  const std::string header = plain_frame(small_header(2));
  const std::string length("\x80\x80\x80\x04", 4);  // 8 MiB
  EXPECT_EQ(refusal_of(header + length + std::string(kMaxRecordedMessageBytes, '\0')), "RECORDING_DAMAGED");
  const std::string longer("\x81\x80\x80\x04", 4);
  EXPECT_EQ(refusal_of(header + longer + std::string(kMaxRecordedMessageBytes + 1, '\0')), "RECORDING_TOO_LARGE");

  v1::RecordingHeader with_mesh;
  with_mesh.set_magic("kerf-recording");
  with_mesh.set_format_version(3);
  const auto file = [&with_mesh] { return std::string(kRecordingSignature) + recording_frame(with_mesh); };
  with_mesh.mutable_scene()->mutable_obj()->set_text(std::string(kMaxRecordedMessageBytes + 1, '#'));
  EXPECT_EQ(refusal_of(file()), "none") << "a mesh may be as long as an upload";
  with_mesh.mutable_scene()->set_description(std::string(kMaxRecordedMessageBytes, 'x'));
  EXPECT_EQ(refusal_of(file()), "RECORDING_TOO_LARGE");
}

TEST(RecordingCodec, ADrawingIsNoRecordedCommand) {
  v1::Cut cut;
  cut.mutable_curve()->mutable_svg()->set_text(
      R"(<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0 L100 100"/></svg>)");
  v1::RecordedTick alone, in_batch;
  *alone.add_commands()->mutable_cut() = cut;
  *in_batch.add_commands()->mutable_cut_batch()->add_cuts() = cut;
  const std::string header = encode_recording_header(sample_recording().config, "");
  EXPECT_EQ(refusal_of(header + recording_frame(alone)), "RECORDING_DAMAGED");
  EXPECT_EQ(refusal_of(header + recording_frame(in_batch)), "RECORDING_DAMAGED");
}

TEST(RecordingCodec, OtherFilesAreNoRecordings) {
  EXPECT_EQ(decode_recording("").error().reason, "RECORDING_TRUNCATED");
  EXPECT_EQ(decode_recording(std::string("\x02\x7b\x7d", 3)).error().reason, "RECORDING_FORMAT");
  EXPECT_EQ(decode_recording(plain_frame(small_header(3))).error().reason, "RECORDING_FORMAT");
  for (const std::int32_t other : {0, 2, 5}) {
    const std::string file = std::string(kRecordingSignature) + recording_frame(small_header(other));
    EXPECT_EQ(decode_recording(file).error().reason, "RECORDING_FORMAT");
    EXPECT_THAT(decode_recording(file).error().message, HasSubstr("version " + std::to_string(other)));
  }
}

// The file was recorded before mesh files were mended: two lips at the same place, and a face of five corners.
TEST(RecordingCodec, MeshFilesOfOldRecordingsAreReadAsTheyWere) {
  std::ifstream in(test::source_path("tests/data/recordings/before_mesh_reading.kerfrec"), std::ios::binary);
  std::stringstream content;
  content << in.rdbuf();
  const Result<RecordingFile> read = decode_recording(content.str());
  ASSERT_TRUE(read.ok()) << read.error().message;
  const scene::SheetConfig& config = read->recording.config;
  EXPECT_EQ(std::get<scene::ObjSource>(config.mesh).reading.version, mesh::kFirstReader);
  const scene::BuiltMesh old = scene::build_mesh(config).value();
  EXPECT_EQ(old.mesh.num_pieces(), 3);
  EXPECT_EQ(old.mesh.vertices(4), (std::array<mesh::VertexId, 3>{6, 9, 10}));
  EXPECT_TRUE(old.notes.empty());
  // A copy in a scene that a server returns says so, and is still read alike.
  v1::Scene scene = encode_scene(config);
  EXPECT_EQ(scene.obj().reading().reader_version(), mesh::kFirstReader);
  EXPECT_EQ(scene::build_mesh(decoded(scene)).value().mesh.num_pieces(), 3);
  // The same file in a new scene is read by the newest reader, and its scene names that.
  scene.mutable_obj()->clear_reading();
  const scene::SheetConfig fresh = decoded(scene);
  const scene::BuiltMesh mended = scene::build_mesh(fresh).value();
  EXPECT_EQ(mended.mesh.num_pieces(), 2);
  EXPECT_EQ(mended.notes.size(), 1U);
  EXPECT_EQ(encode_scene(fresh).obj().reading().reader_version(), mesh::kNewestReader);
}

// A vertex lies within the side of another face; the second reader leaves it there.
TEST(RecordingCodec, ScenesNameTheReaderThatJoinsNoSides) {
  v1::Scene scene;
  scene.mutable_obj()->set_text("v 0 0 0\nv 1 0 0\nv .5 1 0\nv .5 0 0\nv .5 0 -1\nf 1 2 3\nf 1 5 4\nf 4 5 2\n");
  EXPECT_EQ(scene::build_mesh(decoded(scene)).value().mesh.num_pieces(), 1);
  scene.mutable_obj()->mutable_reading()->set_reader_version(mesh::kSecondReader);
  const scene::SheetConfig config = decoded(scene);
  EXPECT_EQ(scene::build_mesh(config).value().mesh.num_pieces(), 2);
  EXPECT_EQ(encode_scene(config).obj().reading().reader_version(), mesh::kSecondReader);
}

// Sheets that were recorded before the second choice of integrators keep the first, in copies of the recording, too.
TEST(RecordingCodec, NamesTheChoiceOfIntegrators) {
  const auto choice = [](const std::string& file) {
    return decode_recording(file)->recording.config.integrator.choice;
  };
  for (const std::int32_t format : {1, 2, 3}) EXPECT_EQ(choice(joined(small_messages(format))), scene::kFirstChoice);
  EXPECT_EQ(choice(joined(small_messages(4))), scene::kNewestChoice);
  scene::SheetConfig config = sample_recording().config;
  EXPECT_EQ(choice(encode_recording_header(config, "")), scene::kNewestChoice);
  config.integrator.choice = scene::kFirstChoice;
  EXPECT_EQ(choice(encode_recording_header(config, "")), scene::kFirstChoice);
}

TEST(RecordingCodec, FilesOfOlderFormatsAreReadAsWell) {
  const std::vector<sheet::RecordedTick> newest = decode_recording(joined(small_messages(3)))->recording.entries;
  for (const std::int32_t format : {1, 2, 4}) {
    const Result<RecordingFile> read = decode_recording(joined(small_messages(format)));
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->recording.entries.size(), newest.size());
    for (std::size_t i = 0; i < newest.size(); ++i) {
      EXPECT_EQ(read->recording.entries[i].tick, newest[i].tick);
      EXPECT_EQ(read->recording.entries[i].state_hash, newest[i].state_hash);
      EXPECT_EQ(read->recording.entries[i].commands.size(), newest[i].commands.size());
    }
  }
}

}  // namespace
}  // namespace kerf::wire
