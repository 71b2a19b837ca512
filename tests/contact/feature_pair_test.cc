#include "server/core/contact/feature_pair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/contact/pair_distance.h"
#include "tests/contact/random_vector.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using Kind = FeaturePair::Kind;

// `error`: m, that the distance may be too large; it cannot be too small, as a point of each side has it.
void expect_separation(Kind kind, const PairPositions& x, double error) {
  const Separation found = separation(kind, x);
  const double expected = wide_distance(kind, x);
  double extent = 0.0;
  for (const Vector3d& p : x) extent = std::max(extent, (p - x[3]).norm());
  ASSERT_LE(found.distance, expected + error);
  ASSERT_GE(found.distance, expected - 1e-12 * extent);
  const std::array<double, 4>& w = found.weights;
  const std::size_t num_a = kind == Kind::kVertexTriangle ? 1 : 2;
  double side_a = 0.0, side_b = 0.0;
  Vector3d way = Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_TRUE(i < num_a ? w[i] >= 0.0 : w[i] <= 0.0) << w[i];
    (i < num_a ? side_a : side_b) += w[i];
    way += w[i] * x[i];
  }
  ASSERT_NEAR(side_a, 1.0, 4e-16);
  ASSERT_NEAR(side_b, -1.0, 4e-16);
  ASSERT_NEAR(found.normal.norm(), 1.0, 1e-15);
  ASSERT_LE((way - found.distance * found.normal).norm(), 1e-15 * extent);
}

PairPositions random_positions(SeededRandom& random, double extent) {
  return {random_vector(random, extent), random_vector(random, extent), random_vector(random, extent),
          random_vector(random, extent)};
}

TEST(Separation, OfRandomPairsIsTheLeastDistance) {
  SeededRandom random(1);
  for (int k = 0; k < 20'000; ++k) {
    const PairPositions x = random_positions(random, 1.0);
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kVertexTriangle, x, 1e-12)) << k;
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 1e-12)) << k;
  }
}

TEST(Separation, OfSliversIsTheLeastDistance) {
  SeededRandom random(2);
  for (int k = 0; k < 20'000; ++k) {
    PairPositions x = random_positions(random, 1.0);
    const double height = std::pow(10.0, random.uniform(-7.0, -1.0));
    const double at = random.uniform(-0.2, 1.2);
    x[3] = (1.0 - at) * x[1] + at * x[2] + random_vector(random, height);
    if (k % 2 == 0) x[0] = x[1] + random.uniform(-0.2, 1.2) * (x[2] - x[1]) + random_vector(random, 3.0 * height);
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kVertexTriangle, x, 1e-9)) << k;
  }
}

TEST(Separation, OfNearlyParallelEdgesIsTheLeastDistance) {
  SeededRandom random(3);
  for (int k = 0; k < 40'000; ++k) {
    PairPositions x = random_positions(random, 1.0);
    const double tilt = std::pow(10.0, random.uniform(-9.0, -1.0));
    const double gap = random.below(2) == 0 ? 0.0 : tilt * random.uniform();
    const Vector3d along = x[1] - x[0];
    // Edges that cross, seen from aside, or lie one behind the other.
    const Vector3d across = along.cross(random_vector(random, 1.0)).normalized();
    const Vector3d aside = along.cross(across).normalized();
    const double begin = random.uniform(-0.6, 0.6), end = begin + random.uniform(-1.0, 1.0);
    x[2] = x[0] + begin * along + random.uniform(-tilt, tilt) * across + gap * aside;
    x[3] = x[0] + end * along + random.uniform(-tilt, tilt) * across + gap * aside;
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 5e-8)) << k;
  }
}

TEST(Separation, OfParallelEdgesAndOfFeaturesThatShrankToAPointIsTheLeastDistance) {
  SeededRandom random(4);
  for (int k = 0; k < 1000; ++k) {
    PairPositions x = random_positions(random, 1.0);
    x[2] = x[0] + random_vector(random, 1.0);
    x[3] = x[2] + random.uniform(-2.0, 2.0) * (x[1] - x[0]);
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 1e-12)) << k;
    x[3] = x[2];
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 1e-12)) << k;
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kVertexTriangle, x, 1e-12)) << k;
    x[1] = x[0];
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 1e-12)) << k;
    x = random_positions(random, 1.0);
    x[1] = x[0];
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kEdgeEdge, x, 1e-12)) << k;
    x[1] = x[2] = x[3];
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kVertexTriangle, x, 1e-12)) << k;
  }
}

// A quotient of two zeros once made tick after tick fail where a sheet had collapsed to a point.
TEST(Separation, OfTrianglesWithTwoCornersInOnePlaceIsTheLeastDistance) {
  SeededRandom random(5);
  for (int k = 0; k < 3000; ++k) {
    PairPositions x = random_positions(random, 1.0);
    const auto first = static_cast<std::size_t>(1 + k % 3);
    x[first] = x[1 + first % 3];
    ASSERT_NO_FATAL_FAILURE(expect_separation(Kind::kVertexTriangle, x, 1e-12)) << k;
    for (std::size_t i = 0; i < 4; ++i) x[i] = Vector3d(0.0, 0.0, i % 2 == 0 ? 1e-90 * k : 0.0);
    ASSERT_TRUE(std::isfinite(separation(Kind::kVertexTriangle, x).distance)) << k;
    ASSERT_TRUE(std::isfinite(separation(Kind::kEdgeEdge, x).distance)) << k;
  }
}

TEST(Separation, OfSidesThatTouchHasSomeUnitNormal) {
  const Separation on_face = separation(Kind::kVertexTriangle, {Vector3d(1, 1, 0), {0, 0, 0}, {4, 0, 0}, {0, 4, 0}});
  EXPECT_EQ(on_face.distance, 0.0);
  EXPECT_EQ(on_face.normal.norm(), 1.0);
  EXPECT_EQ(on_face.weights, (std::array<double, 4>{1.0, -0.5, -0.25, -0.25}));
  const Separation crossed = separation(Kind::kEdgeEdge, {Vector3d(-1, 0, 0), {1, 0, 0}, {0, -1, 0}, {0, 1, 0}});
  EXPECT_EQ(crossed.distance, 0.0);
  EXPECT_EQ(crossed.normal.norm(), 1.0);
}

TEST(GapAlong, IsBetweenTheHeightsOfBothSides) {
  SeededRandom random(5);
  int num_separated = 0;
  for (int k = 0; k < 2000; ++k) {
    const PairPositions x = random_positions(random, 1.0);
    const Vector3d normal = random_vector(random, 1.0).normalized();
    for (const std::size_t num_a : {1U, 2U}) {
      double least = 9.0, most = -9.0;
      for (std::size_t i = 0; i < 4; ++i) {
        const double height = normal.dot(x[i]);
        if (i < num_a) {
          least = std::min(least, height);
        } else {
          most = std::max(most, height);
        }
      }
      num_separated += least > most ? 1 : 0;
      ASSERT_NEAR(gap_along(num_a, normal, x), least - most, 1e-12);
    }
  }
  EXPECT_GT(num_separated, 300);
}

// A motion of a pair, and its least distance as sampled.
struct PairMotion {
  PairPositions from, to;

  [[nodiscard]] PairPositions at(double time) const {
    PairPositions x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = (1.0 - time) * from[i] + time * to[i];
    return x;
  }
  // m, bound of the change of the distance.
  [[nodiscard]] double length(Kind kind) const {
    const std::size_t num_a = kind == Kind::kVertexTriangle ? 1 : 2;
    double most = 0.0;
    for (std::size_t i = 0; i < num_a; ++i) {
      for (std::size_t j = num_a; j < 4; ++j) most = std::max(most, ((to[i] - from[i]) - (to[j] - from[j])).norm());
    }
    return most;
  }
  // m, too large by at most half of length() / samples.
  [[nodiscard]] double least(Kind kind, int samples) const {
    double found = wide_distance(kind, from);
    for (int k = 1; k <= samples; ++k) {
      found = std::min(found, wide_distance(kind, at(static_cast<double>(k) / samples)));
    }
    return found;
  }
};

TEST(StaysApart, IsNeverSaidOfPairsThatComeNearerThanTheGap) {
  constexpr int kSamples = 200;
  SeededRandom random(6);
  for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
    int num_apart = 0, num_near = 0, num_clear = 0;
    for (int k = 0; k < 3000; ++k) {
      PairMotion motion{random_positions(random, 1.0), {}};
      const double speed = std::pow(10.0, random.uniform(-2.0, 0.7));
      const Vector3d common = random_vector(random, 10.0);
      for (std::size_t i = 0; i < 4; ++i) motion.to[i] = motion.from[i] + common + random_vector(random, speed);
      const double start = wide_distance(kind, motion.from);
      const double gap = start * random.uniform(0.0, 0.9);
      const double least = motion.least(kind, kSamples), length = motion.length(kind);
      const bool apart = stays_apart(kind, motion.from, motion.to, gap);
      num_apart += apart ? 1 : 0;
      num_near += least < gap ? 1 : 0;
      ASSERT_TRUE(!apart || least > gap - 1e-12) << k;
      // Bounds of their motions in the frame of the pair add up to twice as much.
      if (least - length / kSamples > gap + 0.04 * length) {
        ++num_clear;
        ASSERT_TRUE(apart) << k;
      }
    }
    EXPECT_GT(num_apart, 500);
    EXPECT_GT(num_near, 200);
    EXPECT_GT(num_clear, 500);
  }
}

TEST(StaysApart, IsNotSaidOfPairsThatPassThrough) {
  SeededRandom random(7);
  for (int k = 0; k < 2000; ++k) {
    // Both sides meet at a random time in a random point of each. Speeds are up to 100 m a step.
    const double time = random.uniform(0.05, 0.95), speed = std::pow(10.0, random.uniform(-3.0, 2.0));
    for (const Kind kind : {Kind::kVertexTriangle, Kind::kEdgeEdge}) {
      PairPositions meeting = random_positions(random, 1.0);
      const double s = random.uniform(), r = random.uniform() * (1.0 - s);
      if (kind == Kind::kVertexTriangle) {
        meeting[0] = (1.0 - s - r) * meeting[1] + s * meeting[2] + r * meeting[3];
      } else {
        meeting[1] += (1.0 - s) * meeting[2] + s * meeting[3] - 0.5 * (meeting[0] + meeting[1]);
        meeting[0] = 2.0 * ((1.0 - s) * meeting[2] + s * meeting[3]) - meeting[1];
      }
      PairMotion motion;
      const Vector3d common = random_vector(random, 1e3);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vector3d way = common + random_vector(random, speed);
        motion.from[i] = meeting[i] - time * way;
        motion.to[i] = meeting[i] + (1.0 - time) * way;
      }
      const double start = wide_distance(kind, motion.from);
      if (start < 1e-6) continue;
      ASSERT_FALSE(stays_apart(kind, motion.from, motion.to, 0.01 * start)) << k;
      ASSERT_FALSE(stays_apart(kind, motion.from, motion.to, 1e-9)) << k;
    }
  }
}

TEST(StaysApart, IsSaidOfFastPairsThatMissEachOther) {
  const PairPositions start{Vector3d(0.1, 0.1, 5.0), {0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}};
  PairPositions end = start;
  end[0].z() = -5.0;
  EXPECT_FALSE(stays_apart(Kind::kVertexTriangle, start, end, 1e-5)) << "10 m through the triangle";
  for (const double far : {0.4, 1.0, 3.0}) {
    PairPositions from = start, to = end;
    from[0].x() = to[0].x() = 0.3 + far;
    from[0].y() = to[0].y() = 0.0;
    EXPECT_TRUE(stays_apart(Kind::kVertexTriangle, from, to, 1e-5)) << far << " m beside it";
    EXPECT_FALSE(stays_apart(Kind::kVertexTriangle, from, to, far + 1e-6)) << far << " m beside it";
  }
  const PairPositions edges{Vector3d(-0.1, 0, 5), {0.1, 0, 5}, {0, -0.1, 0}, {0, 0.1, 0}};
  PairPositions through = edges;
  through[0].z() = through[1].z() = -5.0;
  EXPECT_FALSE(stays_apart(Kind::kEdgeEdge, edges, through, 1e-5));
  PairPositions still = edges;
  for (Vector3d& p : still) p += Vector3d(100.0, 200.0, -300.0);
  EXPECT_TRUE(stays_apart(Kind::kEdgeEdge, edges, still, 4.9)) << "a motion of the whole";
}

}  // namespace
}  // namespace kerf::contact
