// VertexField and IdMap.
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/linear/vertex_field.h"
#include "server/core/mesh/id_map.h"

namespace kerf::mesh {
namespace {

TEST(VertexField, GrowsWithinItsRoomWithoutMovingAndKeepsItsColumns) {
  linear::VertexField field(Eigen::Matrix3Xd::Random(3, 100));
  const Eigen::Matrix3Xd before = field;
  EXPECT_EQ(field.capacity(), 100);
  field.resize(101);
  EXPECT_EQ(field.cols(), 101);
  EXPECT_EQ(field.capacity(), 150);
  EXPECT_EQ(Eigen::Matrix3Xd(field.leftCols(100)), before);
  const double* const place = field.data();
  field.resize(150);
  field.resize(20);
  field.resize(149);
  EXPECT_EQ(field.data(), place);
  EXPECT_EQ(field.capacity(), 150);
}

TEST(VertexField, CopiesValuesAndMovesStorage) {
  const linear::VertexField field(Eigen::Matrix3Xd::Random(3, 7));
  linear::VertexField copy = field;
  EXPECT_NE(copy.data(), field.data());
  EXPECT_EQ(copy, field);
  copy = copy + 2.0 * field;  // coefficient by coefficient
  EXPECT_EQ(copy, Eigen::Matrix3Xd(field + 2.0 * field));
  const double* const place = copy.data();
  linear::VertexField moved = std::move(copy);
  EXPECT_EQ(moved.data(), place);
  moved = linear::VertexField();
  EXPECT_EQ(moved.cols(), 0);
  moved = field;
  EXPECT_EQ(moved, field);
}

TEST(IdMap, AgreesWithAMap) {
  SeededRandom random(5);
  IdMap ids;
  std::map<std::int32_t, std::int32_t> map;
  for (std::int32_t i = 0; i < 20'000; ++i) {
    const auto id = static_cast<std::int32_t>(random.below(i % 2 == 0 ? 1'000 : 100'000'000));
    EXPECT_EQ(ids.add(id, i), map.emplace(id, i).second);
  }
  for (std::int32_t id = 0; id < 2'000; ++id) {
    EXPECT_EQ(ids.has(id), map.contains(id));
    EXPECT_EQ(ids.find(id), map.contains(id) ? map[id] : -1);
  }
  for (const auto& [id, number] : map) EXPECT_EQ(ids.get(id), number);
}

TEST(IdMap, KeepsIdsInTheOrderTheyWereAddedIn) {
  IdMap ids;
  for (const std::int32_t id : {7, 3, 7, 900, 3, 0}) ids.add(id);
  EXPECT_EQ(ids.ids(), (std::vector<std::int32_t>{7, 3, 900, 0}));
  EXPECT_EQ(ids.get(900), 2) << "its index among them";
}

}  // namespace
}  // namespace kerf::mesh
