#include "server/service/codec/position_code.h"

#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"

namespace kerf::codec {
namespace {

using Triangles = std::vector<std::array<std::int32_t, 3>>;

// n x n cells of two triangles, rows of vertices one behind the other.
Triangles grid(std::int32_t n) {
  Triangles triangles;
  for (std::int32_t y = 0; y < n; ++y) {
    for (std::int32_t x = 0; x < n; ++x) {
      const std::int32_t v = y * (n + 1) + x;
      triangles.push_back({v, v + 1, v + n + 2});
      triangles.push_back({v, v + n + 2, v + n + 1});
    }
  }
  return triangles;
}

std::vector<std::uint16_t> random_positions(SeededRandom& random, std::size_t num_vertices) {
  std::vector<std::uint16_t> positions(3 * num_vertices);
  for (std::uint16_t& q : positions) q = static_cast<std::uint16_t>(random.below(65536));
  return positions;
}

TEST(VertexPredictors, AreTheFirstTriangleAndTheOneAcross) {
  //  3 - 4 - 5
  //  | / | / |      cells (0 1 4), (0 4 3), (1 2 5), (1 5 4)
  //  0 - 1 - 2
  const Triangles triangles{{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  const std::vector<VertexPredictor> predictors = vertex_predictors(triangles, 6);
  EXPECT_EQ(predictors[0], (VertexPredictor{kNoVertex, kNoVertex, kNoVertex}));
  EXPECT_EQ(predictors[1], (VertexPredictor{0, kNoVertex, kNoVertex})) << "the highest in no slot";
  EXPECT_EQ(predictors[3], (VertexPredictor{0, kNoVertex, kNoVertex})) << "likewise: 4 is higher";
  EXPECT_EQ(predictors[4], (VertexPredictor{0, 1, kNoVertex})) << "nothing lies across (0, 1)";
  EXPECT_EQ(predictors[5], (VertexPredictor{1, 2, kNoVertex}));
  EXPECT_EQ(vertex_predictors({}, 2)[1], (VertexPredictor{0, kNoVertex, kNoVertex})) << "in no slot";
  const std::vector<VertexPredictor> larger = vertex_predictors(grid(2), 9);
  EXPECT_EQ(larger[8], (VertexPredictor{4, 5, 1}));
}

TEST(VertexPredictors, NameEarlierVerticesOnlyWhateverTheTriangles) {
  SeededRandom random(1);
  for (int round = 0; round < 100; ++round) {
    const std::size_t num_vertices = 1 + random.below(30);
    Triangles triangles(random.below(50));
    for (auto& triangle : triangles) {
      const bool is_void = random.uniform() < 0.1;
      for (auto& vertex : triangle)
        vertex = is_void ? kNoVertex : static_cast<std::int32_t>(random.below(num_vertices));
    }
    const std::vector<VertexPredictor> predictors = vertex_predictors(triangles, num_vertices);
    ASSERT_EQ(predictors.size(), num_vertices);
    for (std::size_t v = 0; v < num_vertices; ++v) {
      const auto vertex = static_cast<std::int32_t>(v);
      for (const std::int32_t from : {predictors[v].near_a, predictors[v].near_b, predictors[v].across}) {
        EXPECT_GE(from, kNoVertex);
        EXPECT_LT(from, vertex);
      }
      EXPECT_TRUE(vertex == 0 || predictors[v].near_a != kNoVertex);
    }
  }
}

TEST(PositionCode, KeyframesAndDeltasComeBackAsTheyWere) {
  SeededRandom random(2);
  for (int round = 0; round < 60; ++round) {
    const auto n = static_cast<std::int32_t>(1 + random.below(8));
    const auto num_vertices = static_cast<std::size_t>((n + 1) * (n + 1));
    const auto predictors = vertex_predictors(grid(n), num_vertices);
    const auto positions = random_positions(random, num_vertices);
    EXPECT_EQ(unpack_positions(pack_positions(positions, predictors), predictors), positions);
    // A base with all vertices, and ones that lack the last.
    const auto base = random_positions(random, num_vertices - random.below(3));
    EXPECT_EQ(unpack_position_delta(pack_position_delta(positions, base, predictors), base, predictors), positions);
  }
}

TEST(PositionCode, FlatGridsAndRigidMotionsTakeNextToNothing) {
  const std::int32_t n = 50;
  const auto num_vertices = static_cast<std::size_t>((n + 1) * (n + 1));
  const auto predictors = vertex_predictors(grid(n), num_vertices);
  std::vector<std::uint16_t> positions;
  for (std::int32_t y = 0; y <= n; ++y) {
    for (std::int32_t x = 0; x <= n; ++x) {
      const std::array<std::int32_t, 3> q{5000 + 1000 * x + 3 * y, 6000 + 900 * y, 30000 + 7 * x};
      for (const std::int32_t each : q) positions.push_back(static_cast<std::uint16_t>(each));
    }
  }
  EXPECT_LT(pack_positions(positions, predictors).size(), num_vertices * 2 / 3);
  std::vector<std::uint16_t> moved = positions;
  for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = static_cast<std::uint16_t>(moved[i] + 1234);
  EXPECT_LT(pack_position_delta(moved, positions, predictors).size(), num_vertices / 4);
}

TEST(PositionCode, MalformedBytesAreRefusedAndAnyOthersStayInRange) {
  const auto predictors = vertex_predictors(grid(3), 16);
  SeededRandom random(3);
  const auto positions = random_positions(random, 16);
  const std::string bytes = pack_positions(positions, predictors);
  EXPECT_EQ(unpack_positions(bytes.substr(1), predictors), std::nullopt);
  EXPECT_EQ(unpack_positions(bytes + "x", predictors), std::nullopt);
  EXPECT_EQ(unpack_positions("", predictors), std::nullopt);
  for (int round = 0; round < 500; ++round) {
    std::string spoilt = bytes;
    spoilt[random.below(spoilt.size())] ^= static_cast<char>(1 + random.below(255));
    const auto read = unpack_positions(spoilt, predictors);
    if (read) {
      EXPECT_EQ(read->size(), 48U);
    }
  }
}

TEST(PositionCode, BytesComeBackAsTheyWere) {
  SeededRandom random(4);
  const auto predictors = vertex_predictors(grid(6), 49);
  std::vector<std::int8_t> values(49);
  for (std::int8_t& value : values) value = static_cast<std::int8_t>(random.below(256));
  EXPECT_EQ(unpack_bytes(pack_bytes(values, predictors), predictors), values);
  EXPECT_EQ(unpack_bytes("", predictors), std::nullopt);
}

}  // namespace
}  // namespace kerf::codec
