#include "server/core/contact/pair_lanes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/contact/pair_distance.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using Kind = FeaturePair::Kind;
using FloatField = std::array<std::vector<float>, 3>;

constexpr std::array<int, 9> kCounts{0, 1, 2, 15, 16, 17, 31, 48, 333};

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
            find_overlaps(boxes, range, way.data(), others, {begin, end}, false, found);
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
      find_overlaps(boxes, range, kNoWay.data(), boxes, range, true, found);
      EXPECT_EQ(found, overlaps_by_comparison(boxes, range, kNoWay, boxes, range, true)) << count;
    }
    const BoxRange first{0, count / 2}, second{count / 4, count};
    std::vector<std::array<std::int32_t, 2>> found;
    find_overlaps(boxes, first, kNoWay.data(), boxes, second, true, found);
    EXPECT_EQ(found, overlaps_by_comparison(boxes, first, kNoWay, boxes, second, true)) << count;
  }
}

// Pairs of random vertices in motion, some of which share a vertex.
struct RandomPairs {
  Kind kind = Kind::kVertexTriangle;
  MotionLanes motion;
  PairLanes pairs;

  RandomPairs(Kind of, int count, SeededRandom& random) : kind(of) {
    constexpr std::size_t kVertices = 60;
    motion.resize(kVertices);
    for (std::size_t v = 0; v < kVertices; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        motion.x[k][v] = static_cast<float>(random.uniform(-1.0, 1.0));
        motion.v[k][v] = static_cast<float>(random.uniform(-3.0, 3.0));
      }
      motion.slack[v] = static_cast<float>(random.uniform(0.0, 0.1));
    }
    for (int p = 0; p < count; ++p) {
      std::array<mesh::VertexId, 4> ids{};
      for (mesh::VertexId& id : ids) id = static_cast<mesh::VertexId>(random.below(kVertices));
      const std::size_t n = num_a();
      // Vertices of one side differ.
      while (n == 2 && ids[1] == ids[0]) ids[1] = (ids[1] + 1) % static_cast<mesh::VertexId>(kVertices);
      while (ids[3] == ids[2] || (n == 1 && (ids[3] == ids[1] || ids[2] == ids[1]))) {
        ids[2] = static_cast<mesh::VertexId>(random.below(kVertices));
        ids[3] = static_cast<mesh::VertexId>(random.below(kVertices));
      }
      if (random.below(8) == 0) ids[n + random.below(4 - n)] = ids[random.below(n)];
      pairs.add(2 * p, 3 * p + 1, ids);
    }
    pairs.pad();
  }
  [[nodiscard]] std::size_t num_a() const { return kind == Kind::kVertexTriangle ? 1 : 2; }
  [[nodiscard]] std::array<std::size_t, 4> ids(std::size_t p) const {
    std::array<std::size_t, 4> of{};
    for (std::size_t i = 0; i < 4; ++i) of[i] = static_cast<std::size_t>(pairs.vertices[i][p]);
    return of;
  }
  [[nodiscard]] PairPositions positions(std::size_t p) const {
    PairPositions x;
    const auto of = ids(p);
    for (std::size_t i = 0; i < 4; ++i) x[i] = vector(motion.x, of[i]);
    return x;
  }
  [[nodiscard]] static Vector3d vector(const FloatField& field, std::size_t v) {
    return {static_cast<double>(field[0][v]), static_cast<double>(field[1][v]), static_cast<double>(field[2][v])};
  }
  [[nodiscard]] bool shares_a_vertex(std::size_t p) const {
    const auto of = ids(p);
    for (std::size_t i = 0; i < num_a(); ++i) {
      if (std::find(of.begin() + static_cast<std::ptrdiff_t>(num_a()), of.end(), of[i]) != of.end()) return true;
    }
    return false;
  }
  // m, distance less what both sides can come nearer by.
  [[nodiscard]] double least(std::size_t p, double duration) const {
    const auto of = ids(p);
    double fastest = 0.0, slack_a = 0.0, slack_b = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      double& slack = i < num_a() ? slack_a : slack_b;
      slack = std::max(slack, static_cast<double>(motion.slack[of[i]]));
    }
    for (std::size_t i = 0; i < num_a(); ++i) {
      for (std::size_t j = num_a(); j < 4; ++j) {
        fastest = std::max(fastest, (vector(motion.v, of[i]) - vector(motion.v, of[j])).norm());
      }
    }
    return wide_distance(kind, positions(p)) - slack_a - slack_b - duration * fastest;
  }
};

TEST(FindNear, FindsPairsThatMayComeNear) {
  SeededRandom random(3);
  int num_kept = 0, num_left = 0;
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    for (const int count : kCounts) {
      const RandomPairs of(kind, count, random);
      for (const float duration : {0.0F, 0.03F}) {
        std::vector<std::int32_t> kept{5, 6};
        find_near(kind, of.pairs, of.motion, duration, 0.2F, kept);
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

// Returns true if the nearest points of two edges lie inside both, by some margin; false if one is an end.
enum class Place { kInside, kEnd, kUncertain };
Place place_of_nearest(const PairPositions& x) {
  const Separation s = separation(Kind::kEdgeEdge, x);
  const auto [low, high] = std::minmax({s.weights[0], s.weights[1], -s.weights[2], -s.weights[3]});
  static_cast<void>(high);
  if (low > 1e-3) return Place::kInside;
  const double ends = std::min(std::min(wide_distance(Kind::kEdgeEdge, {x[0], x[0], x[2], x[3]}),
                                        wide_distance(Kind::kEdgeEdge, {x[1], x[1], x[2], x[3]})),
                               std::min(wide_distance(Kind::kEdgeEdge, {x[0], x[1], x[2], x[2]}),
                                        wide_distance(Kind::kEdgeEdge, {x[0], x[1], x[3], x[3]})));
  return low == 0.0 && ends == s.distance ? Place::kEnd : Place::kUncertain;
}

TEST(FindDistances, AreThoseOfDoubles) {
  SeededRandom random(4);
  int num_inside = 0, num_ends = 0;
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    const RandomPairs of(kind, 500, random);
    for (const int count : kCounts) {
      std::vector<std::int32_t> indices;
      for (int k = 0; k < count; ++k) indices.push_back(static_cast<std::int32_t>(random.below(500)));
      std::vector<float> distances(indices.size() + 1, 7.0F);
      find_distances(kind, of.pairs.vertices, indices, of.motion.x, std::span(distances).first(indices.size()));
      EXPECT_EQ(distances.back(), 7.0F);
      for (std::size_t k = 0; k < indices.size(); ++k) {
        const PairPositions x = of.positions(static_cast<std::size_t>(indices[k]));
        const double found = static_cast<double>(distances[k]);
        EXPECT_NEAR(std::abs(found), wide_distance(kind, x), 1e-5) << indices[k];
        if (kind == Kind::kVertexTriangle) {
          EXPECT_GE(found, 0.0);
          continue;
        }
        const Place place = place_of_nearest(x);
        num_inside += place == Place::kInside ? 1 : 0;
        num_ends += place == Place::kEnd ? 1 : 0;
        EXPECT_TRUE(place != Place::kInside || found >= 0.0) << indices[k];
        EXPECT_TRUE(place != Place::kEnd || found <= 0.0) << indices[k];
      }
    }
  }
  EXPECT_GT(num_inside, 20);
  EXPECT_GT(num_ends, 20);
}

// Edges of 20 mm that are nearly parallel, and triangles as flat as cuts leave them: 16 um high. SelfContact takes
// distances for exact to 10 um. Those to a sliver may be too large by its height.
TEST(FindDistances, OfNearlyParallelEdgesAndSliversAreGood) {
  constexpr double kEdge = 0.02;  // m
  SeededRandom random(5);
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    FloatField x;
    std::array<std::vector<std::int32_t>, 4> vertices;
    std::vector<std::int32_t> indices;
    std::vector<PairPositions> positions;
    constexpr int kPairs = 20'000;
    for (int p = 0; p < kPairs; ++p) {
      const Vector3d at = random_vector(random, 0.5);
      const Vector3d along = kEdge * random_vector(random, 1.0).normalized();
      const double flatness = std::pow(10.0, random.uniform(-3.1, -0.3));
      const auto nearly_on = [&](double place) -> Vector3d {
        return at + place * along + kEdge * random_vector(random, flatness);
      };
      PairPositions of{nearly_on(random.uniform(-0.5, 1.0)), at, at + along, nearly_on(random.uniform(-0.5, 1.5))};
      if (kind == Kind::kEdgeEdge) of = {at, at + along, of[0], of[3]};
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          const auto value = static_cast<float>(of[i][static_cast<Eigen::Index>(k)]);
          x[k].push_back(value);
          of[i][static_cast<Eigen::Index>(k)] = static_cast<double>(value);
        }
        vertices[i].push_back(4 * p + static_cast<std::int32_t>(i));
      }
      positions.push_back(of);
      indices.push_back(p);
    }
    for (auto& of : vertices) of.resize(kPairs + kLanePadding, 0);
    std::vector<float> distances(kPairs);
    find_distances(kind, vertices, indices, x, distances);
    double worst = 0.0;
    for (std::size_t p = 0; p < kPairs; ++p) {
      const PairPositions& of = positions[p];
      const double error = std::abs(static_cast<double>(distances[p])) - wide_distance(kind, of);
      const Vector3d ab = of[2] - of[1], ac = of[3] - of[1];
      const double height = kind == Kind::kEdgeEdge ? 0.0 : ab.cross(ac).norm() / std::max(ab.norm(), ac.norm());
      worst = std::max({worst, error - height, -error});
    }
    EXPECT_LT(worst, 1e-5) << static_cast<int>(kind);
  }
}

TEST(FindDue, FindsPairsWhoseVerticesMovedFartherThanTheirLimit) {
  SeededRandom random(6);
  for (const int count : kCounts) {
    RandomPairs of(Kind::kVertexTriangle, count, random);
    std::vector<float> path(60);
    for (float& each : path) each = static_cast<float>(random.below(4));
    std::vector<float> limit;
    for (int p = 0; p < count; ++p) limit.push_back(static_cast<float>(random.below(13)));
    std::vector<std::int32_t> expected;
    for (std::size_t p = 0; p < of.pairs.size(); ++p) {
      float sum = 0.0F;
      for (const std::size_t v : of.ids(p)) sum += path[v];
      if (!(sum < limit[p])) expected.push_back(static_cast<std::int32_t>(p));
    }
    limit.resize(limit.size() + kLanePadding, -1.0F);
    std::vector<std::int32_t> due{3, 4};
    find_due(of.pairs.vertices, path, std::span(limit).first(static_cast<std::size_t>(count)), due);
    EXPECT_EQ(due, expected) << count;
  }
}

}  // namespace
}  // namespace kerf::contact
