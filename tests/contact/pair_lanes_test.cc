#include "server/core/contact/pair_lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contact/random_pairs.h"

namespace kerf::contact {
namespace {

using Kind = FeaturePair::Kind;

BoxLanes random_boxes(SeededRandom& random, int count) {
  BoxLanes boxes;
  boxes.resize(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < 3; ++k) {
    // Padding behind the last box would overlap all of them.
    std::fill(boxes.low[k].begin(), boxes.low[k].end(), -9.0F);
    std::fill(boxes.high[k].begin(), boxes.high[k].end(), 9.0F);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      // Multiples of 1/8, so that some boxes only touch.
      const double low = std::round(random.uniform(-8.0, 8.0)) / 8.0;
      boxes.low[k][i] = static_cast<float>(low);
      boxes.high[k][i] = static_cast<float>(low + std::round(random.uniform(0.0, 8.0)) / 8.0);
    }
  }
  return boxes;
}

// Holds a box around some boxes.
struct Around {
  std::array<float, 3> low, high;

  operator BoxBounds() const { return {low.data(), high.data()}; }
};
Around bounds(const BoxLanes& boxes, BoxRange range) {
  Around around;
  around.low.fill(std::numeric_limits<float>::infinity());
  around.high.fill(-std::numeric_limits<float>::infinity());
  for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      around.low[k] = std::min(around.low[k], boxes.low[k][i]);
      around.high[k] = std::max(around.high[k], boxes.high[k][i]);
    }
  }
  return around;
}

using Way = std::array<float, 3>;
constexpr Way kNoWay{};

std::vector<std::array<std::int32_t, 2>> overlaps_by_comparison(const BoxLanes& boxes, BoxRange range, const Way& way,
                                                                const BoxLanes& others, BoxRange other_range,
                                                                bool after) {
  std::vector<std::array<std::int32_t, 2>> found;
  for (std::int32_t i = range.begin; i < range.end; ++i) {
    for (std::int32_t j = other_range.begin; j < other_range.end; ++j) {
      if (after && j <= i) continue;
      const auto p = static_cast<std::size_t>(i), q = static_cast<std::size_t>(j);
      bool overlaps = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const float low = std::min(boxes.low[k][p], boxes.low[k][p] + way[k]);
        const float high = std::max(boxes.high[k][p], boxes.high[k][p] + way[k]);
        overlaps = overlaps && low < others.high[k][q] && others.low[k][q] < high;
      }
      if (overlaps) found.push_back({i, j});
    }
  }
  return found;
}

TEST(FindOverlaps, FindsThoseOfRangesInAscendingOrder) {
  SeededRandom random(1);
  std::size_t total = 0;
  for (const int count : kCounts) {
    const BoxLanes boxes = random_boxes(random, 40), others = random_boxes(random, count);
    for (const std::int32_t begin : {0, 1, count / 3}) {
      for (const std::int32_t end : {count, count - 1}) {
        if (begin > end) continue;
        for (const BoxRange range : {BoxRange{0, 40}, BoxRange{7, 8}, BoxRange{5, 5}}) {
          for (const Way& way : {kNoWay, Way{0.25F, 0.0F, -0.5F}, Way{-3.0F, 2.0F, 1.0F}}) {
            std::vector<std::array<std::int32_t, 2>> found{{-1, -1}};
            find_overlaps(boxes, range, way.data(), others, {begin, end}, bounds(others, {begin, end}), false, found);
            auto expected = overlaps_by_comparison(boxes, range, way, others, {begin, end}, false);
            total += expected.size();
            expected.insert(expected.begin(), {-1, -1});
            EXPECT_EQ(found, expected) << count << ", " << begin << ", " << end << ", " << way[0];
          }
        }
      }
    }
  }
  EXPECT_GT(total, 1000U);
}

TEST(FindOverlaps, FindsThoseOfOneRangeOnce) {
  SeededRandom random(2);
  for (const int count : kCounts) {
    const BoxLanes boxes = random_boxes(random, count);
    for (const BoxRange range : {BoxRange{0, count}, BoxRange{count / 4, count - count / 3}}) {
      std::vector<std::array<std::int32_t, 2>> found;
      find_overlaps(boxes, range, kNoWay.data(), boxes, range, bounds(boxes, range), true, found);
      EXPECT_EQ(found, overlaps_by_comparison(boxes, range, kNoWay, boxes, range, true)) << count;
    }
    const BoxRange first{0, count / 2}, second{count / 4, count};
    std::vector<std::array<std::int32_t, 2>> found;
    find_overlaps(boxes, first, kNoWay.data(), boxes, second, bounds(boxes, second), true, found);
    EXPECT_EQ(found, overlaps_by_comparison(boxes, first, kNoWay, boxes, second, true)) << count;
  }
}

TEST(FindNear, FindsPairsThatMayComeNear) {
  SeededRandom random(3);
  int num_kept = 0, num_left = 0;
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    for (const int count : kCounts) {
      const RandomPairs of(kind, count, random);
      for (const float duration : {0.0F, 0.03F}) {
        std::vector<std::int32_t> kept{5, 6};
        std::vector<float> speeds{5.0F};
        find_near(kind, of.pairs, of.motion, duration, 0.2F, kept, speeds);
        ASSERT_EQ(speeds.size(), kept.size());
        for (std::size_t k = 0; k < kept.size(); ++k) {
          EXPECT_NEAR(static_cast<double>(speeds[k]), of.fastest(static_cast<std::size_t>(kept[k])), 1e-5);
        }
        EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
        for (std::size_t p = 0; p < of.pairs.size(); ++p) {
          const double least = of.least(p, static_cast<double>(duration));
          const auto found = std::count(kept.begin(), kept.end(), static_cast<std::int32_t>(p));
          if (of.shares_a_vertex(p)) {
            EXPECT_EQ(found, 0) << p;
          } else if (least < 0.2 - 1e-5) {
            EXPECT_EQ(found, 1) << p << ", " << count;
            ++num_kept;
          } else if (least > 0.2 + 1e-5) {
            EXPECT_EQ(found, 0) << p << ", " << count;
            ++num_left;
          }
        }
      }
    }
  }
  EXPECT_GT(num_kept, 200);
  EXPECT_GT(num_left, 200);
}

TEST(FindDue, FindsPairsWhoseSidesMovedFartherThanTheirLimit) {
  constexpr float kElapsed = 0.5F;  // s
  SeededRandom random(6);
  for (const int count : kCounts) {
    RandomPairs of(Kind::kVertexTriangle, count, random);
    std::vector<float> path(60);
    for (float& each : path) each = static_cast<float>(random.below(4));
    std::vector<float> limit, speed;
    for (int p = 0; p < count; ++p) {
      limit.push_back(static_cast<float>(random.below(15)));
      speed.push_back(static_cast<float>(random.below(4)));
    }
    std::vector<std::int32_t> expected;
    std::vector<float> expected_way;
    for (std::size_t p = 0; p < of.pairs.size(); ++p) {
      float sum = 0.0F;
      for (const std::size_t v : of.ids(p)) sum += path[v];
      sum += kElapsed * speed[p];
      if (sum < limit[p]) continue;
      expected.push_back(static_cast<std::int32_t>(p));
      expected_way.push_back(sum);
    }
    limit.resize(limit.size() + kLanePadding, -1.0F);
    speed.resize(speed.size() + kLanePadding, 0.0F);
    std::vector<std::int32_t> due{3, 4};
    std::vector<float> way{3.0F};
    find_due(of.pairs.vertices, {path, speed, kElapsed}, std::span(limit).first(static_cast<std::size_t>(count)), due,
             way);
    EXPECT_EQ(due, expected) << count;
    EXPECT_EQ(way, expected_way) << count;
  }
}

}  // namespace
}  // namespace kerf::contact
