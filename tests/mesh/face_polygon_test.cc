// Triangulation of polygons of any shape.

#include "server/core/mesh/build/face_polygon.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/elementary.h"
#include "server/base/random.h"

namespace kerf::mesh {
namespace {

using Points = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double area_of(const Points& corners) {
  double doubled = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) doubled += cross(corners[i], corners[(i + 1) % corners.size()]);
  return 0.5 * doubled;
}

// Checks that the triangles turn as the polygon does, use every corner, and cover its area once.
void expect_sound(const Points& corners, double least_height = 0.0) {
  const TriangulatedPolygon made = triangulate_polygon(corners);
  ASSERT_EQ(made.kind, PolygonKind::kSound);
  ASSERT_EQ(made.triangles.size(), corners.size() - 2);
  const double area = area_of(corners);
  double sum = 0.0;
  std::vector<bool> is_used(corners.size());
  for (const auto& [a, b, c] : made.triangles) {
    const double part = 0.5 * cross(corners[b] - corners[a], corners[c] - corners[a]);
    EXPECT_GT(part * area, 0.0);
    const double longest = std::max(
        {(corners[b] - corners[a]).norm(), (corners[c] - corners[b]).norm(), (corners[a] - corners[c]).norm()});
    EXPECT_GT(2.0 * std::abs(part) / longest, least_height);
    sum += part;
    is_used[a] = is_used[b] = is_used[c] = true;
  }
  EXPECT_NEAR(sum, area, 1e-9 * std::abs(area));
  EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
}

void expect_sound_both_ways(Points corners, double least_height = 0.0) {
  for (std::size_t turn = 0; turn < corners.size(); ++turn) {
    expect_sound(corners, least_height);
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
  }
  std::reverse(corners.begin(), corners.end());
  expect_sound(corners, least_height);
}

TEST(Polygon, TrianglesAndQuadsAreSplitAtTheirFirstCorner) {
  using Triangles = std::vector<std::array<std::int32_t, 3>>;
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 0}, {0, 1}}).triangles, (Triangles{{0, 1, 2}}));
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 0}, {1, 1}, {0, 1}}).triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  // An arrowhead with its notch at the second corner has one way only.
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 1}, {2, 0}, {1, 3}}).triangles.size(), 2U);
  expect_sound_both_ways({{0, 0}, {1, 1}, {2, 0}, {1, 3}});
}

TEST(Polygon, CornersMayBeReentrantOrStraight) {
  expect_sound_both_ways({{0, 0}, {.4, 0}, {.4, .1}, {.2, .1}, {.2, .3}, {0, .3}});
  expect_sound_both_ways({{0, 0}, {1, 0}, {4, 0}, {4, 3}, {0, 3}});
  expect_sound_both_ways({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {2, 1}, {1, 2}, {0, 3}, {0, 2}, {0, 1}});
  expect_sound_both_ways(
      {{0, 0}, {5, 0}, {5, 5}, {4, 5}, {4, 1}, {3, 1}, {3, 5}, {2, 5}, {2, 1}, {1, 1}, {1, 5}, {0, 5}});
}

TEST(Polygon, AHoleMayBeJoinedToTheBorder) {
  const TriangulatedPolygon made =
      triangulate_polygon(Points{{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}});
  ASSERT_EQ(made.kind, PolygonKind::kSound);
  EXPECT_EQ(made.triangles.size(), 8U);
}

// A corner within a side that rounding put a little off it makes no needle.
TEST(Polygon, AlmostStraightCornersMakeNoNeedles) {
  for (const double off : {-1e-6, -1e-16, 0.0, 1e-16, 1e-6}) {
    expect_sound_both_ways({{0, 0}, {1, off}, {4, 0}, {4, 3}, {0, 3}}, 0.1);
    expect_sound_both_ways({{0, 0}, {1, off}, {2, -off}, {3, off}, {4, 0}, {4, 3}, {2, 3 + off}, {0, 3}}, 0.1);
  }
}

TEST(Polygon, LinesAndCrossingsAreNamed) {
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 0}, {2, 0}}).kind, PolygonKind::kNoArea);
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 1}, {3, 3}, {2, 2}}).kind, PolygonKind::kNoArea);
  EXPECT_EQ(triangulate_polygon(Points{{1, 1}, {1, 1}, {1, 1}}).kind, PolygonKind::kNoArea);
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {1, 1}, {1, 0}, {0, 1}}).kind, PolygonKind::kCrossesItself);
  EXPECT_EQ(triangulate_polygon(Points{{0, 0}, {3, 3}, {3, 0}, {0, 2}}).kind, PolygonKind::kCrossesItself);
}

TEST(Polygon, LargeOnesAreDivided) {
  for (const int count : {128, 5000}) {
    Points disc;
    for (int i = 0; i < count; ++i) {
      const double angle = 6.283185307179586 * i / count;
      disc.emplace_back(cosine(angle), sine(angle));
    }
    expect_sound(disc);
  }
}

// Random star-shaped and comb-shaped polygons, some corners on a coarse grid so that many lie on lines.
TEST(Polygon, RandomOnesKeepTheirArea) {
  SeededRandom random(20);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto count = static_cast<std::size_t>(4 + random.below(60));
    Points star;
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(count);
      const double radius = 0.3 + 0.1 * static_cast<double>(random.below(8));
      star.emplace_back(radius * cosine(angle), radius * sine(angle));
    }
    expect_sound(star);
    Points comb{{0, -1}};
    const int teeth = 2 + static_cast<int>(random.below(20));
    for (int i = teeth; i >= 0; --i) comb.emplace_back(i, static_cast<double>(random.below(4)));
    std::reverse(comb.begin() + 1, comb.end());
    comb.emplace_back(teeth, -1);
    expect_sound(comb);
    if (testing::Test::HasFailure()) FAIL() << "trial " << trial;
  }
}

TEST(Polygon, ThePlaneOfAPolygonIsItsOwn) {
  const std::vector<Eigen::Vector3d> tilted{{1, 1, 1}, {4, 1, 1}, {4, 3.4, 4.2}, {1, 3.4, 4.2}};
  EXPECT_NEAR(area_of(in_own_plane(tilted)), 12.0, 1e-12);
  const std::vector<Eigen::Vector3d> crossed{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(triangulate_polygon(in_own_plane(crossed)).kind, PolygonKind::kCrossesItself);
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  EXPECT_EQ(triangulate_polygon(in_own_plane(line)).kind, PolygonKind::kNoArea);
}

}  // namespace
}  // namespace kerf::mesh
