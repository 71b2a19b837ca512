#include "server/core/contact/orient3d.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "server/base/random.h"
#include "tests/contact/exact_intersection.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;

Vector3d as_vector(const WholePoint& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

int sign_of(Wide value) {
  return value > 0 ? 1 : value < 0 ? -1 : 0;
}

int whole_side(const std::array<WholePoint, 4>& p) {
  return sign_of(dot(cross(from_to(p[0], p[1]), from_to(p[0], p[2])), from_to(p[0], p[3])));
}

// Three random points and one near their plane, or exactly in it.
std::array<WholePoint, 4> nearly_flat(SeededRandom& random, std::int64_t extent, std::int64_t off) {
  const auto whole = [&random](std::int64_t most) {
    return static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(2 * most + 1))) - most;
  };
  std::array<WholePoint, 4> p{};
  for (std::size_t k = 0; k < 3; ++k) p[k] = {whole(extent), whole(extent), whole(extent)};
  const std::int64_t s = whole(2), t = whole(2);
  for (std::size_t i = 0; i < 3; ++i) {
    p[3][i] = p[0][i] + s * (p[1][i] - p[0][i]) + t * (p[2][i] - p[0][i]) + whole(off);
  }
  return p;
}

TEST(Orient3d, TellsTheSideFromWhichAPlaneTurnsCounterClockwise) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(orient3d(a, b, c, {0.2, 0.2, 1.0}), 1);
  EXPECT_EQ(orient3d(a, b, c, {0.2, 0.2, -1.0}), -1);
  EXPECT_EQ(orient3d(a, b, c, {7.0, -3.0, 0.0}), 0);
  EXPECT_EQ(orient3d(a, b, {2, 0, 0}, {0.3, 0.2, 0.7}), 0) << "no plane";
  EXPECT_EQ(orient3d(a, b, c, b), 0);
}

TEST(Orient3d, AgreesWithIntegersBesideAPlane) {
  SeededRandom random(1);
  std::array<int, 3> seen{};
  for (int i = 0; i < 20'000; ++i) {
    const std::array<WholePoint, 4> p = nearly_flat(random, std::int64_t{1} << (4 + i % 34), i % 3);
    const int expected = whole_side(p);
    ++seen[static_cast<std::size_t>(expected + 1)];
    // Sides do not change if an axis is scaled: by powers of two, which round nothing.
    const double scale = std::ldexp(1.0, -static_cast<int>(random.below(200)));
    std::array<Vector3d, 4> q;
    for (std::size_t k = 0; k < 4; ++k) q[k] = as_vector(p[k]).cwiseProduct(Vector3d(1.0, 0x1.0p-40, scale));
    EXPECT_EQ(orient3d(q[0], q[1], q[2], q[3]), expected) << i;
    EXPECT_EQ(orient3d_exact(q[0], q[1], q[2], q[3]), expected) << i;
    EXPECT_EQ(orient3d(q[1], q[0], q[2], q[3]), -expected) << i;
    EXPECT_EQ(orient3d(q[3], q[1], q[2], q[0]), -expected) << i;
    EXPECT_EQ(orient3d(q[2], q[3], q[0], q[1]), expected) << i;
  }
  for (const int count : seen) EXPECT_GT(count, 1000);
}

// Differences that a double cannot hold: all four points are nearly in the plane x = y.
TEST(Orient3d, LosesNothingOfTinyCoordinates) {
  const double tiny = 0x1.0p-250;
  const Vector3d a(1, 1, 0), b(3, 3, 5), c(-2, -2, 1);
  for (const double off : {-tiny, 0.0, tiny}) {
    const Vector3d d(tiny, tiny + off, 0.1);
    const int expected = off > 0.0 ? 1 : off < 0.0 ? -1 : 0;
    const int sign = orient3d({0, 0, 0}, {1, 1, 0}, {0, 0, 1}, {0, 1, 0});
    EXPECT_EQ(orient3d({0, 0, 0}, {1, 1, 0}, {0, 0, 1}, d), sign * expected);
    EXPECT_EQ(orient3d(a, b, c, d), -orient3d(b, a, c, d));
    EXPECT_EQ(std::abs(orient3d(a, b, c, d)), std::abs(expected));
    EXPECT_EQ(orient3d(a, b, c, d), orient3d(a, b, c, {0.0, 1.0, 0.0}) * expected);
  }
}

TEST(FilteredPlane, IsUnsureRatherThanWrong) {
  SeededRandom random(2);
  int sure = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::array<WholePoint, 4> p = nearly_flat(random, std::int64_t{1} << 36, std::int64_t{1} << (i % 30));
    const int side = FilteredPlane(as_vector(p[0]), as_vector(p[1]), as_vector(p[2])).side(as_vector(p[3]));
    if (side == FilteredPlane::kUnsure) continue;
    ++sure;
    EXPECT_EQ(side, whole_side(p)) << i;
  }
  EXPECT_GT(sure, 5000);
  EXPECT_LT(sure, 20'000);
}

}  // namespace
}  // namespace kerf::contact
