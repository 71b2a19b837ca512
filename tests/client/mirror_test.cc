#include "client/cpp/mirror.h"

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/codec/position_code.h"
#include "server/service/codec/topology_code.h"

namespace kerf::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Optional;

std::string words(const std::vector<std::int32_t>& values) {
  std::string bytes;
  for (const std::int32_t value : values) {
    for (int shift = 0; shift < 32; shift += 8) {
      bytes += static_cast<char>((static_cast<std::uint32_t>(value) >> shift) & 0xffU);
    }
  }
  return bytes;
}
std::string floats(const std::vector<float>& values) {
  std::vector<std::int32_t> bits;
  for (const float value : values) bits.push_back(std::bit_cast<std::int32_t>(value));
  return words(bits);
}
std::string shorts(const std::vector<int>& values) {
  std::string bytes;
  for (const int value : values) {
    bytes += static_cast<char>(value & 0xff);
    bytes += static_cast<char>((value >> 8) & 0xff);
  }
  return bytes;
}

std::string pack_patch(const std::vector<std::array<std::int32_t, 3>>& triangles) {
  return codec::pack_triangles(triangles, false);
}

// A unit square of two triangles, tick 5, raw.
v1::Frame keyframe() {
  v1::Frame frame;
  frame.set_sequence(1);
  frame.set_tick(5);
  frame.set_base_tick(-1);
  frame.set_topology_version(1);
  frame.set_num_vertices(4);
  frame.mutable_box()->mutable_min()->set_x(-1.0);
  frame.mutable_box()->mutable_max()->set_x(1.0);
  frame.mutable_box()->mutable_max()->set_y(2.0);
  frame.mutable_box()->mutable_max()->set_z(4.0);
  frame.set_encoding(v1::RAW);
  frame.set_positions(shorts({0, 1, 2, 65535, 4, 5, 6, 7, 8, 9, 10, 11}));
  v1::TopologyPatch& topology = *frame.mutable_topology();
  topology.set_base_version(-1);
  topology.set_num_slots(3);
  topology.set_num_listed_slots(3);
  topology.set_num_listed_vertices(4);
  topology.set_triangles(words({0, 1, 2, 0, 2, 3, -1, -1, -1}));
  topology.set_pieces(words({0, 0, -1}));
  topology.set_material_positions(floats({0, 0, 1, 0, 1, 1, 0, 1}));
  topology.set_num_pieces(1);
  return frame;
}

const std::vector<std::array<std::int32_t, 3>> kTriangles{{0, 1, 2}, {0, 2, 3}, {-1, -1, -1}};
const std::vector<std::array<std::int32_t, 3>> kCutTriangles{{0, 1, 2}, {4, 2, 3}, {0, 1, 4}};
const std::vector<std::uint16_t> kMoved{1, 0, 302, 65535, 4, 5, 6, 7, 8, 9, 10, 11};

// The next frame: vertex 0 moves by (+1, -1, +300), the rest stays.
v1::Frame delta() {
  v1::Frame frame;
  frame.set_sequence(2);
  frame.set_tick(6);
  frame.set_base_tick(5);
  frame.set_topology_version(1);
  frame.set_num_vertices(4);
  frame.set_encoding(v1::COMPACT);
  frame.set_positions(codec::pack_position_delta(kMoved,
                                                 std::vector<std::uint16_t>{0, 1, 2, 65535, 4, 5, 6, 7, 8, 9, 10, 11},
                                                 codec::vertex_predictors(kTriangles, 4)));
  return frame;
}

// The next: slot 1 gets a new vertex 4 (a copy of vertex 0), slot 2 becomes material, in a second piece.
v1::Frame cut() {
  v1::Frame frame = delta();
  frame.set_sequence(3);
  frame.set_tick(7);
  frame.set_base_tick(6);
  frame.set_topology_version(2);
  frame.set_num_vertices(5);
  std::vector<std::uint16_t> positions = kMoved;
  positions.insert(positions.end(), {2, 3, 4});
  const auto predictors = codec::vertex_predictors(kCutTriangles, 5);
  frame.set_positions(codec::pack_position_delta(positions, kMoved, predictors));
  v1::TopologyPatch& topology = *frame.mutable_topology();
  topology.set_base_version(1);
  topology.set_num_slots(3);
  topology.set_num_listed_slots(2);
  topology.set_num_listed_vertices(1);
  topology.set_slots(codec::pack_ascending(std::vector<std::uint32_t>{1, 2}));
  topology.set_triangles(pack_patch({{4, 2, 3}, {0, 1, 4}}));
  topology.set_pieces(codec::pack_labels(std::vector<std::int32_t>{0, 1}));
  topology.set_vertices(codec::pack_ascending(std::vector<std::uint32_t>{4}));
  topology.set_material_positions(codec::pack_material_positions(
      std::vector<float>{0, 0, 1, 0, 1, 1, 0, 1, 0.5F, 0.25F}, std::vector<std::uint32_t>{4}, predictors));
  topology.set_num_pieces(2);
  return frame;
}

TEST(Mirror, AppliesAKeyframe) {
  Mirror mirror;
  ASSERT_EQ(mirror.apply(keyframe()), std::nullopt);
  EXPECT_EQ(mirror.tick(), 5);
  EXPECT_EQ(mirror.num_vertices(), 4);
  EXPECT_EQ(mirror.num_pieces(), 1);
  EXPECT_THAT(mirror.quantised_positions(), ElementsAre(0, 1, 2, 65535, 4, 5, 6, 7, 8, 9, 10, 11));
  EXPECT_THAT(mirror.triangles(), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 2, 3), ElementsAre(-1, -1, -1)));
  EXPECT_THAT(mirror.material_positions(), ElementsAre(0, 0, 1, 0, 1, 1, 0, 1));
  EXPECT_EQ(mirror.position(1)[0], 1.0);
  EXPECT_DOUBLE_EQ(mirror.position(1)[2], 5 * 4.0 / 65535);
}

TEST(Mirror, BeginsAgainAtAnyTickWithAnEpoch) {
  Mirror mirror;
  v1::Frame first = keyframe();
  first.set_epoch("one");
  ASSERT_EQ(mirror.apply(first), std::nullopt);
  EXPECT_EQ(mirror.epoch(), "one");
  ASSERT_EQ(mirror.apply(delta()), std::nullopt);
  EXPECT_EQ(mirror.epoch(), "one");
  v1::Frame again = keyframe();
  again.set_sequence(3);
  again.set_tick(2);
  again.set_epoch("two");
  ASSERT_EQ(mirror.apply(again), std::nullopt);
  EXPECT_EQ(mirror.tick(), 2);
  EXPECT_EQ(mirror.epoch(), "two");
  EXPECT_THAT(mirror.quantised_positions(), ElementsAre(0, 1, 2, 65535, 4, 5, 6, 7, 8, 9, 10, 11));
}

TEST(Mirror, KeepsTheNamesOfProbesAndTheNewestValues) {
  Mirror mirror;
  v1::Frame first = keyframe();
  first.add_probe_columns("tip.x");
  first.add_probe_values(0.25);
  ASSERT_EQ(mirror.apply(first), std::nullopt);
  EXPECT_THAT(mirror.probe_columns(), ElementsAre("tip.x"));
  EXPECT_THAT(mirror.probe_values(), ElementsAre(0.25));
  v1::Frame next = keyframe();
  next.set_sequence(2);
  next.set_tick(6);
  next.add_probe_values(0.5);
  ASSERT_EQ(mirror.apply(next), std::nullopt);
  EXPECT_THAT(mirror.probe_columns(), ElementsAre("tip.x"));
  EXPECT_THAT(mirror.probe_values(), ElementsAre(0.5));
  next.set_sequence(3);
  next.clear_probe_values();
  EXPECT_THAT(mirror.apply(next), Optional(HasSubstr("0 values of probes for 1 columns")));
}

TEST(Mirror, AppliesDeltasAndPatches) {
  Mirror mirror;
  ASSERT_EQ(mirror.apply(keyframe()), std::nullopt);
  ASSERT_EQ(mirror.apply(delta()), std::nullopt);
  EXPECT_THAT(mirror.quantised_positions(), ElementsAre(1, 0, 302, 65535, 4, 5, 6, 7, 8, 9, 10, 11));
  ASSERT_EQ(mirror.apply(cut()), std::nullopt);
  EXPECT_EQ(mirror.topology_version(), 2);
  EXPECT_EQ(mirror.num_pieces(), 2);
  EXPECT_THAT(mirror.triangles(), ElementsAre(ElementsAre(0, 1, 2), ElementsAre(4, 2, 3), ElementsAre(0, 1, 4)));
  EXPECT_THAT(mirror.pieces(), ElementsAre(0, 0, 1));
  EXPECT_THAT(mirror.quantised_positions(), ElementsAre(1, 0, 302, 65535, 4, 5, 6, 7, 8, 9, 10, 11, 2, 3, 4));
}

// Each way in which a frame cannot follow what is there.
struct Refusal {
  const char* name;
  const char* message;
  void (*spoil)(v1::Frame&);
};

class MirrorRefuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(MirrorRefuses, AFrameThatDoesNotFit) {
  Mirror mirror;
  ASSERT_EQ(mirror.apply(keyframe()), std::nullopt);
  ASSERT_EQ(mirror.apply(delta()), std::nullopt);
  v1::Frame frame = cut();
  GetParam().spoil(frame);
  EXPECT_THAT(mirror.apply(frame), Optional(HasSubstr(GetParam().message)));
}

INSTANTIATE_TEST_SUITE_P(
    Spoilt, MirrorRefuses,
    ::testing::Values(
        Refusal{"SequenceGap", "frame 4 follows frame 2", [](v1::Frame& f) { f.set_sequence(4); }},
        Refusal{"OlderTick", "after tick", [](v1::Frame& f) { f.set_tick(3); }},
        Refusal{"WrongBase", "delta against tick 5 at tick 6", [](v1::Frame& f) { f.set_base_tick(5); }},
        Refusal{"ShortPositions", "positions are malformed", [](v1::Frame& f) { f.mutable_positions()->pop_back(); }},
        Refusal{"LongPositions", "positions are malformed",
                [](v1::Frame& f) { f.mutable_positions()->push_back('\0'); }},
        Refusal{"UnknownEncoding", "unknown encoding", [](v1::Frame& f) { f.set_encoding(v1::ENCODING_UNSPECIFIED); }},
        Refusal{"RawDelta", "not compact",
                [](v1::Frame& f) {
                  f.clear_topology();
                  f.set_topology_version(1);
                  f.set_num_vertices(4);
                  f.set_encoding(v1::RAW);
                }},
        Refusal{"MissingPatch", "without its patch", [](v1::Frame& f) { f.clear_topology(); }},
        Refusal{"PatchOfOtherBase", "from version 0 at version 1",
                [](v1::Frame& f) { f.mutable_topology()->set_base_version(0); }},
        Refusal{"VertexOutOfRange", "vertex 5 is out of range",
                [](v1::Frame& f) {
                  f.mutable_topology()->set_triangles(pack_patch({{5, 2, 3}, {0, 1, 4}}));
                }},
        Refusal{"SlotOutOfRange", "slot 3 is out of range",
                [](v1::Frame& f) {
                  f.mutable_topology()->set_slots(codec::pack_ascending(std::vector<std::uint32_t>{1, 3}));
                }},
        Refusal{"FewerSlots", "remove slots", [](v1::Frame& f) { f.mutable_topology()->set_num_slots(1); }},
        Refusal{"ShortTriangles", "triangles is malformed",
                [](v1::Frame& f) { f.mutable_topology()->mutable_triangles()->pop_back(); }},
        Refusal{"ShortPieces", "pieces is malformed", [](v1::Frame& f) { f.mutable_topology()->clear_pieces(); }},
        Refusal{"NewVertexWithoutMaterial", "without material",
                [](v1::Frame& f) {
                  f.mutable_topology()->set_num_listed_vertices(0);
                  f.mutable_topology()->clear_vertices();
                  f.mutable_topology()->clear_material_positions();
                }}),
    [](const auto& refusal) { return std::string(refusal.param.name); });

TEST(Mirror, StartsOnlyWithAKeyframe) {
  Mirror mirror;
  v1::Frame frame = delta();
  frame.set_sequence(1);
  EXPECT_NE(mirror.apply(frame), std::nullopt);
}

}  // namespace
}  // namespace kerf::client
