#include "server/core/contact/pair_looks.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/contact/random_pairs.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using Kind = FeaturePair::Kind;

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

TEST(LookAt, FindsTheDistancesAndSpeedsOfDoubles) {
  SeededRandom random(4);
  int num_inside = 0, num_ends = 0;
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    const RandomPairs of(kind, 500, random);
    for (const int count : kCounts) {
      std::vector<std::int32_t> indices;
      for (int k = 0; k < count; ++k) indices.push_back(static_cast<std::int32_t>(random.below(500)));
      std::vector<float> distances(indices.size() + 1, 7.0F);
      std::vector<float> closing(indices.size() + 1, 7.0F);
      look_at({kind, of.pairs.vertices, indices}, of.motion.x, of.motion.v, std::span(distances).first(indices.size()),
              std::span(closing).first(indices.size()));
      EXPECT_EQ(distances.back(), 7.0F);
      EXPECT_EQ(closing.back(), 7.0F);
      for (std::size_t k = 0; k < indices.size(); ++k) {
        const auto p = static_cast<std::size_t>(indices[k]);
        const PairPositions x = of.positions(p);
        const double found = static_cast<double>(distances[k]);
        EXPECT_NEAR(std::abs(found), wide_distance(kind, x), 1e-5) << p;
        const Separation s = separation(kind, x);
        Vector3d u = Vector3d::Zero();
        for (std::size_t i = 0; i < 4; ++i) u += s.weights[i] * of.vector(of.motion.v, of.ids(p)[i]);
        if (s.distance > 1e-3) {
          EXPECT_NEAR(static_cast<double>(closing[k]), -s.normal.dot(u), 1e-3) << p;
        }
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
// distances for exact to 20 and 60 times the rounding of heights, and
// those to other triangles to 4 times.
TEST(LookAt, FindsGoodDistancesOfNearlyParallelEdgesAndSlivers) {
  constexpr double kEdge = 0.02;  // m
  SeededRandom random(5);
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    FloatLanes x;
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
    std::vector<float> distances(kPairs), closing(kPairs);
    look_at({kind, vertices, indices}, x, x, distances, closing);
    FloatPositions all;
    for (const auto& of : x) {
      for (const float value : of) all.extent = std::max(all.extent, std::abs(value));
    }
    const auto rounding = static_cast<double>(all.rounding());
    double of_edges = 0.0, of_slivers = 0.0, of_others = 0.0;
    for (std::size_t p = 0; p < kPairs; ++p) {
      const PairPositions& of = positions[p];
      const double error = std::abs(std::abs(static_cast<double>(distances[p])) - wide_distance(kind, of));
      const Vector3d ab = of[2] - of[1], ac = of[3] - of[1];
      const double altitude = ab.cross(ac).norm() / std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
      double& of_class = kind == Kind::kEdgeEdge ? of_edges : altitude < 2000.0 * rounding ? of_slivers : of_others;
      of_class = std::max(of_class, error);
    }
    EXPECT_LT(of_edges, 20.0 * rounding);
    EXPECT_LT(of_slivers, 60.0 * rounding);
    EXPECT_LT(of_others, 4.0 * rounding);
  }
}

// Pairs of random vertices, which move by up to `way` (m).
struct MovingPairs {
  RandomPairs pairs;
  linear::VertexField from, to;

  MovingPairs(Kind kind, int count, double way, SeededRandom& random) : pairs(kind, count, random) {
    const auto size = static_cast<Eigen::Index>(pairs.motion.slack.size());
    from.resize(size);
    to.resize(size);
    for (Eigen::Index v = 0; v < size; ++v) {
      from.col(v) = RandomPairs::vector(pairs.motion.x, static_cast<std::size_t>(v));
      to.col(v) = from.col(v) + random_vector(random, way);
    }
  }
  [[nodiscard]] PairPositions positions(const linear::VertexField& x, std::size_t p) const {
    const auto of = pairs.ids(p);
    PairPositions at;
    for (std::size_t i = 0; i < 4; ++i) at[i] = x.col(static_cast<Eigen::Index>(of[i]));
    return at;
  }
};

FloatPositions floats_of(const linear::VertexField& x) {
  std::vector<mesh::VertexId> all(static_cast<std::size_t>(x.cols()));
  for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<mesh::VertexId>(v);
  FloatPositions positions;
  positions.set(x, all);
  return positions;
}

TEST(KeepUnseparated, LeavesOutOnlyPairsThatStayApart) {
  SeededRandom random(8);
  int num_left = 0, num_kept = 0;
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    for (const double way : {0.01, 0.1, 1.0}) {
      for (const int count : kCounts) {
        const MovingPairs moving(kind, count, way, random);
        std::vector<std::int32_t> indices;
        std::vector<float> least;
        for (int p = 0; p < count; ++p) {
          least.push_back(static_cast<float>(random.uniform(0.0, 0.05)));
          if (random.below(4) > 0) indices.push_back(p);
        }
        std::vector<std::int32_t> kept;
        keep_unseparated({kind, moving.pairs.pairs.vertices, indices}, least, floats_of(moving.from),
                         floats_of(moving.to), kept);
        EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
        for (const std::int32_t index : indices) {
          const auto p = static_cast<std::size_t>(index);
          if (std::binary_search(kept.begin(), kept.end(), index)) {
            ++num_kept;
            continue;
          }
          ++num_left;
          const PairPositions from = moving.positions(moving.from, p), to = moving.positions(moving.to, p);
          const double gap = std::max(0.1 * wide_distance(kind, from),
                                      std::min(static_cast<double>(least[p]), 0.999 * wide_distance(kind, from)));
          for (const double time : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0}) {
            PairPositions x;
            for (std::size_t i = 0; i < 4; ++i) x[i] = from[i] + time * (to[i] - from[i]);
            EXPECT_GT(wide_distance(kind, x), gap) << p << ", " << time;
          }
        }
      }
    }
  }
  EXPECT_GT(num_left, 500);
  EXPECT_GT(num_kept, 500);
}

TEST(KeepUnseparated, KeepsPairsThatTouch) {
  SeededRandom random(9);
  MovingPairs moving(Kind::kVertexTriangle, 1, 0.0, random);
  const auto of = moving.pairs.ids(0);
  const auto at = [&](std::size_t i) { return moving.from.col(static_cast<Eigen::Index>(of[i])); };
  at(0) = (at(1) + at(2) + at(3)) / 3.0;
  const std::vector<std::int32_t> indices{0};
  const std::vector<float> least{0.0F};
  std::vector<std::int32_t> kept;
  keep_unseparated({Kind::kVertexTriangle, moving.pairs.pairs.vertices, indices}, least, floats_of(moving.from),
                   floats_of(moving.from), kept);
  EXPECT_EQ(kept, indices);
}

TEST(FloatPositions, AreRelativeToTheMeanAndFollowVerticesThatMove) {
  linear::VertexField x;
  x.resize(3);
  x << 100.0, 102.0, 104.0, 5.0, 5.0, 5.0, -1.0, 0.0, 1.0;
  FloatPositions positions = floats_of(x);
  EXPECT_EQ(positions.middle, Vector3d(102.0, 5.0, 0.0));
  EXPECT_EQ(positions.x[0], (std::vector<float>{-2.0F, 0.0F, 2.0F}));
  EXPECT_EQ(positions.extent, 2.0F);
  x.col(1) = Vector3d(102.0, 8.0, 0.0);
  const std::vector<mesh::VertexId> moved{1};
  positions.update(x, moved);
  EXPECT_EQ(positions.middle, Vector3d(102.0, 5.0, 0.0));
  EXPECT_EQ(positions.x[1], (std::vector<float>{0.0F, 3.0F, 0.0F}));
  EXPECT_EQ(positions.extent, 3.0F);
}

}  // namespace
}  // namespace kerf::contact
