// Vector code of the bending matrix: fits of many patches, places of columns.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "server/core/fem/element/bending_lanes.h"
#include "server/core/linear/rank_ascending.h"
#include "tests/fem/fixture.h"
#include "tests/fem/instruction_sets.h"

namespace kerf::fem {
namespace {

// Makes patches with any kinds of edges: one of a regular hexagon, whose six points lie on a circle, the others
// jittered.
std::vector<PatchGeometry> patches(std::size_t count) {
  SeededRandom random(3);
  std::vector<PatchGeometry> made(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double jitter = i == 0 ? 0.0 : 0.3;
    const auto corner = [&](std::size_t k) {
      const double angle = std::numbers::pi / 3.0 * static_cast<double>(k);
      return Eigen::Vector2d(std::cos(angle) + random.uniform(-jitter, jitter),
                             std::sin(angle) + random.uniform(-jitter, jitter));
    };
    for (std::size_t k = 0; k < 3; ++k) {
      made[i].corners[k] = corner(2 * k);
      made[i].opposite[k] = corner(2 * k + 3);
      made[i].edges[k] = i < 2 ? PatchEdge::kNeighbour : static_cast<PatchEdge>(random.below(3));
    }
  }
  return made;
}

void append(std::vector<double>& numbers, const PatchLanes& lanes, std::size_t lane) {
  const std::array<double, 21> stiffness = lanes.stiffness_of(lane);
  numbers.insert(numbers.end(), stiffness.begin(), stiffness.end());
  for (std::size_t k = 0; k < 3; ++k) {
    const BendingSide side = lanes.side_of(lane, k);
    numbers.insert(numbers.end(), side.slope.begin(), side.slope.end());
    numbers.insert(numbers.end(), side.moment.begin(), side.moment.end());
    numbers.insert(numbers.end(), {side.length, side.penalty});
  }
}

TEST(BendingLanes, GiveTheSameBitsOnEveryInstructionSetAndInEveryLane) {
  const Eigen::Matrix3d D = bending_law(orthotropic_cloth());
  const std::vector<PatchGeometry> all = patches(linear::kBlockLanes);
  std::vector<double> expected;
  for (const PatchGeometry& patch : all) {
    PatchLanes alone;
    alone.set(0, patch, D, D.inverse());
    alone.fit(1);
    append(expected, alone, 0);
  }
  EXPECT_TRUE(std::all_of(expected.begin(), expected.end(), [](double x) { return std::isfinite(x); }));
  for_each_instruction_set([&] {
    PatchLanes lanes;
    for (std::size_t l = 0; l < all.size(); ++l) lanes.set(l, all[l], D, D.inverse());
    lanes.fit(all.size());
    std::vector<double> numbers;
    for (std::size_t l = 0; l < all.size(); ++l) append(numbers, lanes, l);
    EXPECT_EQ(numbers, expected);
  });
}

// The slope is that of the quadratic which the six values are of, the moment that of its curvature.
TEST(BendingLanes, SidesHaveSlopeAndMomentOfAQuadratic) {
  const Eigen::Matrix3d D = bending_law(orthotropic_cloth());
  const auto q = [](const Eigen::Vector2d& x) {
    return 0.3 - 0.7 * x.x() + 0.2 * x.y() + 0.9 * x.x() * x.x() - 1.1 * x.x() * x.y() + 0.4 * x.y() * x.y();
  };
  const auto gradient = [](const Eigen::Vector2d& x) {
    return Eigen::Vector2d(-0.7 + 1.8 * x.x() - 1.1 * x.y(), 0.2 - 1.1 * x.x() + 0.8 * x.y());
  };
  const Eigen::Vector3d moments = D * Eigen::Vector3d(1.8, 0.8, -2.2);
  const PatchGeometry patch = patches(2)[1];
  PatchLanes lanes;
  lanes.set(0, patch, D, D.inverse());
  lanes.fit(1);
  for (std::size_t k = 0; k < 3; ++k) {
    const BendingSide side = lanes.side_of(0, k);
    const Eigen::Vector2d& a = patch.corners[(k + 1) % 3];
    const Eigen::Vector2d& b = patch.corners[(k + 2) % 3];
    const Eigen::Vector2d along = (b - a).normalized();
    const Eigen::Vector2d n(along.y(), -along.x());
    double slope = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < 6; ++i) {
      const double value = q(i < 3 ? patch.corners[i] : patch.opposite[i - 3]);
      slope += side.slope[i] * value;
      moment += side.moment[i] * value;
    }
    const double expected = n.x() * n.x() * moments[0] + n.y() * n.y() * moments[1] + 2.0 * n.x() * n.y() * moments[2];
    EXPECT_NEAR(slope, n.dot(gradient(0.5 * (a + b))), 1e-12);
    EXPECT_NEAR(moment, expected, 1e-12 * D(0, 0));
    EXPECT_NEAR(side.length, (b - a).norm(), 1e-15);
  }
}

TEST(PlaceInOrder, IsThatOfASortForAnyNumberOfKeysOnEveryInstructionSet) {
  for_each_instruction_set([&] {
    SeededRandom random(5);
    for (std::size_t size = 0; size < 100; ++size) {
      std::vector<std::int32_t> keys(size);
      for (std::size_t i = 0; i < size; ++i) {
        keys[i] = static_cast<std::int32_t>(1000 * random.below(1000) + i);
      }
      std::vector<std::int32_t> places;
      linear::rank_ascending(keys, places);
      std::vector<std::int32_t> sorted(size, -1);
      for (std::size_t i = 0; i < size; ++i) sorted.at(static_cast<std::size_t>(places[i])) = keys[i];
      std::sort(keys.begin(), keys.end());
      EXPECT_EQ(sorted, keys);
    }
  });
}

}  // namespace
}  // namespace kerf::fem
