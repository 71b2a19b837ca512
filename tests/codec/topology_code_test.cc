#include "server/service/codec/topology_code.h"

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"

namespace kerf::codec {
namespace {

TEST(TopologyCode, AscendingIdsComeBackAndOverflowIsRefused) {
  const std::vector<std::uint32_t> ids{0, 1, 5, 6, 1000000, 0xfffffffeU, 0xffffffffU};
  const std::string bytes = pack_ascending(ids);
  EXPECT_EQ(unpack_ascending(bytes, ids.size()), ids);
  EXPECT_EQ(unpack_ascending(bytes, ids.size() + 1), std::nullopt);
  // The same gaps once more lead past the last id.
  const std::string beyond = pack_ascending(std::vector<std::uint32_t>{0xf0000000U});
  EXPECT_TRUE(unpack_ascending(beyond, 1).has_value());
  std::vector<std::uint32_t> dense(1000);
  for (std::uint32_t i = 0; i < 1000; ++i) dense[i] = 70 + i;
  EXPECT_LT(pack_ascending(dense).size(), 80U);
}

TEST(TopologyCode, TrianglesComeBackInEitherForm) {
  SeededRandom random(1);
  for (const bool whole : {false, true}) {
    for (int round = 0; round < 50; ++round) {
      std::vector<std::array<std::int32_t, 3>> triangles(random.below(60));
      for (auto& triangle : triangles) {
        const bool is_void = random.uniform() < 0.2;
        for (auto& vertex : triangle) vertex = is_void ? -1 : static_cast<std::int32_t>(random.below(500000));
      }
      EXPECT_EQ(unpack_triangles(pack_triangles(triangles, whole), triangles.size(), whole), triangles);
    }
  }
}

TEST(TopologyCode, AGridTakesAFractionOfAByteATriangle) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (std::int32_t y = 0; y < 60; ++y) {
    for (std::int32_t x = 0; x < 60; ++x) {
      const std::int32_t v = 61 * y + x;
      triangles.push_back({v, v + 1, v + 62});
      triangles.push_back({v, v + 62, v + 61});
    }
  }
  EXPECT_LT(pack_triangles(triangles, true).size(), triangles.size() / 3);
}

TEST(TopologyCode, LabelsComeBack) {
  const std::vector<std::int32_t> labels{0, 0, 0, -1, 7, 7, std::numeric_limits<std::int32_t>::max(), -1, 0};
  EXPECT_EQ(unpack_labels(pack_labels(labels), labels.size()), labels);
  EXPECT_EQ(unpack_labels("", 3), std::nullopt);
  EXPECT_LT(pack_labels(std::vector<std::int32_t>(1600, 0)).size(), 70U);
}

TEST(TopologyCode, MaterialPositionsComeBackToTheBit) {
  SeededRandom random(2);
  const std::vector<std::array<std::int32_t, 3>> triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}};
  const auto predictors = vertex_predictors(triangles, 6);
  for (int round = 0; round < 200; ++round) {
    std::vector<float> material(12);
    for (float& x : material) x = static_cast<float>(random.uniform(-1.0e4, 1.0e4));
    material[random.below(12)] = -0.0F;
    material[random.below(12)] = std::numeric_limits<float>::denorm_min();
    const std::vector<std::uint32_t> listed{1, 2, 4, 5};
    std::vector<float> copy = material;
    for (const std::uint32_t vertex : listed) copy[2 * vertex] = copy[2 * vertex + 1] = 99.0F;
    ASSERT_TRUE(
        unpack_material_positions(pack_material_positions(material, listed, predictors), listed, predictors, copy));
    for (std::size_t i = 0; i < material.size(); ++i) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(copy[i]), std::bit_cast<std::uint32_t>(material[i])) << i;
    }
    EXPECT_FALSE(unpack_material_positions("", listed, predictors, copy));
  }
}

}  // namespace
}  // namespace kerf::codec
