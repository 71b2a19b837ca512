#include "server/core/contact/box_tree.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

Pairs found_by(BoxTree& tree, const std::vector<Box>& boxes) {
  tree.build(boxes);
  Pairs pairs;
  tree.for_each_overlap(
      [&pairs](std::int32_t i, std::int32_t j) { pairs.emplace_back(std::min(i, j), std::max(i, j)); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

Pairs by_comparison(const std::vector<Box>& boxes) {
  Pairs pairs;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size(); ++j) {
      if (boxes[i].overlaps(boxes[j])) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

TEST(BoxTree, FindsEachPairOnceWhateverItHeldBefore) {
  SeededRandom random(1);
  BoxTree tree;
  for (const int count : {0, 1, 2, 5, 300, 40, 600}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) {
      const Vector3d centre = random_vector(random, 1.0);
      const Vector3d half = random_vector(random, 0.2).cwiseAbs();
      boxes.push_back({centre - half, centre + half});
    }
    // One far away, which leaves hardly a cell of the curve for all others.
    if (count > 100) boxes.push_back({Vector3d::Constant(1e9), Vector3d::Constant(2e9)});
    EXPECT_EQ(found_by(tree, boxes), by_comparison(boxes)) << count;
  }
}

TEST(BoxTree, LeavesOutBoxesThatOnlyTouch) {
  BoxTree tree;
  const std::vector<Box> boxes{{{0, 0, 0}, {1, 1, 1}}, {{1, 0, 0}, {2, 1, 1}}, {{0.5, 0.2, 0.5}, {0.7, 0.4, 0.5}}};
  EXPECT_EQ(found_by(tree, boxes), (Pairs{{0, 2}})) << "a flat box inside another overlaps it";
  const std::vector<Box> flat{{{0, 0, 3}, {1, 1, 3}}, {{0, 0, 3}, {1, 1, 3}}};
  EXPECT_TRUE(found_by(tree, flat).empty());
}

TEST(BoxTree, LeavesOutBoxesWithANaN) {
  BoxTree tree;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Box> boxes{{{nan, 0, 0}, {nan, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
  EXPECT_EQ(found_by(tree, boxes), (Pairs{{1, 2}}));
}

}  // namespace
}  // namespace kerf::contact
