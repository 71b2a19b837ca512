#include "server/core/mesh/refine/size_field.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "server/core/mesh/refine/box_tree.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

Vector2d random_point(SeededRandom& random) {
  const double x = random.uniform(-2.0, 2.0);
  return {x, random.uniform(-2.0, 2.0)};
}

double distance_by_steps(const Vector2d& p, const SizeSource& source) {
  double least = (p - source.a).norm();
  constexpr int kSteps = 2000;
  for (int i = 1; i <= kSteps; ++i) least = std::min(least, (p - source.a - i * (source.b - source.a) / kSteps).norm());
  return least;
}

TEST(SizeField, IsTheLeastThatAnySourceAsksFor) {
  SeededRandom random(7);
  for (const int count : {0, 1, 3, 40}) {
    std::vector<SizeSource> sources;
    for (int i = 0; i < count; ++i) {
      const Vector2d a = random_point(random);
      const Vector2d b = i % 3 == 0 ? a : Vector2d(a + 0.2 * random_point(random));
      const double length = random.uniform(0.01, 0.3);
      sources.push_back({a, b, length, random.uniform(0.05, 0.6)});
    }
    const SizeField field(0.5, sources);
    for (int k = 0; k < 50; ++k) {
      const Vector2d at = random_point(random);
      double expected = 0.5;
      for (const SizeSource& s : sources) expected = std::min(expected, s.length + s.growth * distance_by_steps(at, s));
      EXPECT_NEAR(field.at(at), expected, 1e-6);
    }
  }
}

TEST(SizeField, NoSteeperThanItsSteepestSource) {
  const SizeField field(10.0, {{{0, 0}, {0, 0}, 0.1, 0.25}, {{1, 0}, {1, 1}, 0.05, 0.4}});
  EXPECT_EQ(field.steepest_growth(), 0.4);
  EXPECT_EQ(field.at({0, 0}), 0.1);
  EXPECT_EQ(field.at({1, 0.5}), 0.05);
  SeededRandom random(3);
  for (int k = 0; k < 200; ++k) {
    const Vector2d a = random_point(random), b = random_point(random);
    EXPECT_LE(std::abs(field.at(a) - field.at(b)), 0.4 * (a - b).norm() + 1e-12);
  }
}

TEST(BoxTree, FindsAllThatMeetAndStopsWhenTold) {
  SeededRandom random(11);
  std::vector<Eigen::AlignedBox2d> boxes;
  for (int i = 0; i < 300; ++i) {
    const Vector2d low = random_point(random);
    boxes.emplace_back(low, Vector2d(low + Vector2d(random.uniform(0.0, 0.5), 0.1)));
  }
  const BoxTree tree(boxes);
  for (int k = 0; k < 50; ++k) {
    const Vector2d low = random_point(random);
    const Eigen::AlignedBox2d asked(low, Vector2d(low + Vector2d(0.3, 0.3)));
    std::vector<std::int32_t> expected, found;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].intersects(asked)) expected.push_back(static_cast<std::int32_t>(i));
    }
    EXPECT_TRUE(tree.visit_meeting(asked, [&](std::int32_t i) {
      found.push_back(i);
      return true;
    }));
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    int visits = 0;
    EXPECT_EQ(tree.visit_meeting(asked, [&](std::int32_t) { return ++visits < 0; }), expected.empty());
    EXPECT_LE(visits, 1);
  }
  EXPECT_TRUE(BoxTree({}).visit_meeting(boxes[0], [](std::int32_t) { return false; }));
}

}  // namespace
}  // namespace kerf::mesh
