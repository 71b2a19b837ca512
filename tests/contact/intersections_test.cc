// Pairs of triangles that pass through each other: by hand, against integers, and of whole sheets.
#include "server/core/contact/intersections.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contact/exact_intersection.h"
#include "tests/contact/random_vector.h"
#include "tests/support/allocation_counter.h"

namespace kerf::contact {
namespace {

using Eigen::Vector3d;
using Ids = std::array<mesh::VertexId, 3>;

struct Sheet {
  std::vector<Ids> triangles;
  linear::VertexField x;
};

std::int64_t count_of(const Sheet& sheet) {
  return IntersectionSearch().count(sheet.triangles, sheet.x);
}

// Six points: two triangles that share no vertex.
std::int64_t count_of(const std::array<Vector3d, 6>& points) {
  Sheet pair{{{0, 1, 2}, {3, 4, 5}}, linear::VertexField(6)};
  for (std::size_t k = 0; k < 6; ++k) pair.x.col(static_cast<Eigen::Index>(k)) = points[k];
  return count_of(pair);
}

// With the triangle (0, 0), (4, 0), (0, 4) of the plane z = 0.
std::int64_t count_with(const std::array<Vector3d, 3>& other) {
  return count_of({Vector3d(0, 0, 0), Vector3d(4, 0, 0), Vector3d(0, 4, 0), other[0], other[1], other[2]});
}

// n x n vertices of the unit square, mapped.
Sheet grid(int n, const std::function<Vector3d(double, double)>& place) {
  Sheet sheet{{}, linear::VertexField(Eigen::Index{n} * n)};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int a = i * n + j;
      sheet.x.col(a) = place(static_cast<double>(j) / (n - 1), static_cast<double>(i) / (n - 1));
      if (i + 1 == n || j + 1 == n) continue;
      sheet.triangles.push_back({a, a + 1, a + n + 1});
      sheet.triangles.push_back({a, a + n + 1, a + n});
    }
  }
  return sheet;
}

// A crumpled sheet whose coordinates are multiples of 1/256.
Sheet crumpled(int n, std::uint64_t seed) {
  SeededRandom random(seed);
  return grid(n, [&random](double u, double v) {
    const Vector3d noise = random_vector(random, 0.1);
    const Vector3d wave(std::sin(7 * u + 2 * v), std::sin(5 * v - 3 * u * v), std::cos(9 * u * v));
    return Vector3d((256.0 * (0.6 * wave + noise)).array().round() / 256.0);
  });
}

WholeTriangle whole(const Sheet& sheet, std::size_t t) {
  WholeTriangle corners{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      corners[k][i] = std::lround(256.0 * sheet.x(static_cast<Eigen::Index>(i), sheet.triangles[t][k]));
    }
  }
  return corners;
}

TEST(Intersections, CountATriangleThatPassesThroughAnother) {
  EXPECT_EQ(count_with({Vector3d(1, 1, -1), {1, 1, 1}, {9, 9, 0.5}}), 1) << "one edge of each through the other";
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {0.8, 1, -1}, {1.2, 1, -1}}), 1) << "two edges of one";
  EXPECT_EQ(count_with({Vector3d(1, -9, 1), {1, 9, 1}, {1, 0, -9}}), 1) << "two edges of the other";
  EXPECT_EQ(count_with({Vector3d(9, 9, 1), {9, 9, -1}, {8, 8, 0.1}}), 0) << "its plane only";
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {2, 1, 2}, {1, 2, 3}}), 0) << "above it";
}

TEST(Intersections, CountWhereTheyPassThroughCornersAndEdges) {
  EXPECT_EQ(count_with({Vector3d(1, 1, 0), {0.5, 1, 1}, {0.5, 1, -1}}), 1) << "a corner in the plane, others beside it";
  EXPECT_EQ(count_with({Vector3d(0, 1, -1), {3, 1, -1}, {1.5, 1, 1}}), 1);
  EXPECT_EQ(count_with({Vector3d(-1, 1, -1), {7, 1, -1}, {1.5, 1, 1.5}}), 1) << "each end on an edge of both";
  EXPECT_EQ(count_with({Vector3d(0, 0, -1), {0, 0, 1}, {4, 4, 0}}), 1) << "through a corner and across";
}

TEST(Intersections, DoNotCountTouching) {
  EXPECT_EQ(count_with({Vector3d(1, 1, 0), {0, 1, 1}, {2, 1, 1}}), 0) << "a corner on the face";
  EXPECT_EQ(count_with({Vector3d(2, 0, 0), {0, 1, 1}, {2, 1, 1}}), 0) << "a corner on an edge";
  EXPECT_EQ(count_with({Vector3d(4, 0, 0), {5, 1, 1}, {5, -1, -1}}), 0) << "a corner on a corner";
  EXPECT_EQ(count_with({Vector3d(1, 1, 0), {2, 1, 0}, {2, 1, 1}}), 0) << "an edge on the face";
  EXPECT_EQ(count_with({Vector3d(0, 0, 0), {4, 0, 0}, {2, 1, 1}}), 0) << "an edge on an edge";
  EXPECT_EQ(count_with({Vector3d(1, 0, 0), {3, 0, 0}, {2, 1, -1}}), 0) << "part of an edge on an edge";
  EXPECT_EQ(count_with({Vector3d(2, 0, 1), {2, 0, -1}, {2, -1, 0}}), 0) << "two edges that cross";
}

TEST(Intersections, DoNotCountTrianglesInOnePlane) {
  EXPECT_EQ(count_with({Vector3d(1, 1, 0), {9, 1, 0}, {1, 9, 0}}), 0);
  EXPECT_EQ(count_with({Vector3d(0, 0, 0), {4, 0, 0}, {0, 4, 0}}), 0) << "the same twice";
  // In an inclined plane, and beside it by the last bit of a corner.
  EXPECT_EQ(count_of({Vector3d(0, 0, 0), {4, 0, 12}, {0, 4, 20}, {1, 1, 8}, {9, 1, 32}, {1, 9, 48}}), 0);
  EXPECT_EQ(count_of({Vector3d(0, 0, 0), {4, 0, 12}, {0, 4, 20}, {1, 1, 8 - 0x1.0p-49}, {9, 1, 32}, {1, 9, 48}}), 0)
      << "below it, except for an edge outside";
  EXPECT_EQ(
      count_of({Vector3d(0, 0, 0), {4, 0, 12}, {0, 4, 20}, {1, 1, 8 - 0x1.0p-49}, {2, 1, 11 + 0x1.0p-49}, {1, 2, 13}}),
      1)
      << "through it by the last bit";
}

TEST(Intersections, DoNotCountTrianglesWithoutAreaOrWithANumberOutOfRange) {
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, -1}, {1, 1, -1}}), 0);
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, 0}, {1, 1, -1}}), 0);
  for (const double x : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, -1}, {1, x, 0}}), 0) << x;
  }
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, -1}, {1, 1e80, 0}}), 1);
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, -1e-80}, {1, 2, 0.5}}), 1);
  EXPECT_EQ(count_with({Vector3d(1, 1, 1), {1, 1, -1e-100}, {1, 2, 0.5}}), 0) << "taken for 0";
}

TEST(Intersections, DoNotCountTrianglesThatShareAVertex) {
  Sheet fan{{{0, 1, 2}, {0, 3, 4}}, linear::VertexField(5)};
  fan.x << 0, 4, 0, 2, 2,  //
      0, 0, 4, 2, 2,       //
      0, 0, 0, -1, 1;
  EXPECT_EQ(count_of(fan), 0);
  EXPECT_EQ(count_of({Vector3d(0, 0, 0), {4, 0, 0}, {0, 4, 0}, {0, 0, 0}, {2, 2, -1}, {2, 2, 1}}), 1)
      << "two vertices at one place are not one";
}

// Small numbers, so that all kinds of touching are among the pairs, and large ones.
TEST(Intersections, OfRandomPairsAreThoseOfIntegers) {
  SeededRandom random(3);
  for (const std::uint64_t most : {2, 3, 5, 400}) {
    int crossing = 0;
    for (int i = 0; i < 30'000; ++i) {
      WholeTriangle t{}, u{};
      std::array<Vector3d, 6> points;
      for (std::size_t k = 0; k < 6; ++k) {
        WholePoint& corner = k < 3 ? t[k] : u[k - 3];
        for (std::size_t c = 0; c < 3; ++c) {
          corner[c] = static_cast<std::int64_t>(random.below(2 * most + 1)) - static_cast<std::int64_t>(most);
          points[k][static_cast<Eigen::Index>(c)] = static_cast<double>(corner[c]);
        }
      }
      const bool expected = interiors_cross(t, u);
      crossing += expected ? 1 : 0;
      ASSERT_EQ(count_of(points), expected ? 1 : 0) << most << ", pair " << i;
      std::swap(points[0], points[1]);
      std::swap(points[4], points[5]);
      ASSERT_EQ(count_of(points), expected ? 1 : 0) << most << ", pair " << i << ", turned over";
      std::rotate(points.begin(), points.begin() + 3, points.end());
      ASSERT_EQ(count_of(points), expected ? 1 : 0) << most << ", pair " << i << ", exchanged";
    }
    EXPECT_GT(crossing, 2000);
  }
}

TEST(Intersections, OfACrumpledSheetAreThoseOfAllPairs) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Sheet sheet = crumpled(12, seed);
    std::vector<std::array<std::int32_t, 2>> expected;
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      for (std::size_t u = t + 1; u < sheet.triangles.size(); ++u) {
        const Ids &a = sheet.triangles[t], &b = sheet.triangles[u];
        if (std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end()) continue;
        if (interiors_cross(whole(sheet, t), whole(sheet, u))) {
          expected.push_back({static_cast<std::int32_t>(t), static_cast<std::int32_t>(u)});
        }
      }
    }
    ASSERT_GT(expected.size(), 100U);
    IntersectionSearch search;
    const Intersections found = search.find(sheet.triangles, sheet.x, expected.size());
    EXPECT_EQ(found.pairs, expected);
    EXPECT_EQ(found.count, static_cast<std::int64_t>(expected.size()));
    EXPECT_EQ(search.count(sheet.triangles, sheet.x), found.count);
    const Intersections some = search.find(sheet.triangles, sheet.x, 7);
    EXPECT_EQ(some.count, found.count);
    expected.resize(7);
    EXPECT_EQ(some.pairs, expected) << "the first ones";
    EXPECT_EQ(search.find(sheet.triangles, sheet.x, 0).count, found.count);
  }
}

TEST(Intersections, DependOnPositionsAlone) {
  const Sheet sheet = crumpled(20, 4);
  const std::int64_t count = count_of(sheet);
  ASSERT_GT(count, 100);
  SeededRandom random(5);
  Sheet shuffled = sheet;
  for (std::size_t i = shuffled.triangles.size(); i > 1; --i) {
    std::swap(shuffled.triangles[i - 1], shuffled.triangles[random.below(i)]);
    Ids& ids = shuffled.triangles[i - 1];
    std::rotate(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(random.below(3)), ids.end());
    if (random.below(2) == 0) std::swap(ids[0], ids[1]);
  }
  EXPECT_EQ(count_of(shuffled), count) << "order of triangles and corners";
  for (const double scale : {0x1.0p-60, 0x1.0p+50, -1.0}) {
    Sheet scaled = sheet;
    scaled.x *= scale;
    EXPECT_EQ(count_of(scaled), count) << scale;
  }
  for (const double far : {0x1.0p+10, -0x1.0p+40}) {
    Sheet moved = sheet;
    moved.x.colwise() += Vector3d(far, -2.0 * far, 0.5 * far);
    EXPECT_EQ(count_of(moved), count) << far;
  }
  Sheet turned = sheet;
  turned.x.row(0).swap(turned.x.row(2));
  EXPECT_EQ(count_of(turned), count) << "axes exchanged";
}

TEST(Intersections, OfSmoothSheetsAreNone) {
  EXPECT_EQ(count_of(grid(30, [](double u, double v) { return Vector3d(u, v, 0.3); })), 0);
  EXPECT_EQ(count_of(grid(30,
                          [](double u, double v) {
                            return Vector3d(0.8 * u - 0.3 * v, 0.7 * v + 0.1 * u, 0.3 * v + 0.45 * u + 0.1);
                          })),
            0)
      << "inclined";
  EXPECT_EQ(count_of(grid(30, [](double u, double v) { return Vector3d(u, 0.9 * v, 0.1 * std::sin(5 * u + 3 * v)); })),
            0);
  EXPECT_EQ(count_of(grid(40,
                          [](double u, double v) {
                            return Vector3d((1.0 + u) * std::cos(20 * u), (1.0 + u) * std::sin(20 * u), v);
                          })),
            0)
      << "wound up";
}

TEST(Intersections, OfASheetFoldedThroughItselfAreThere) {
  EXPECT_GT(count_of(grid(30,
                          [](double u, double v) {
                            const double angle = 2.0 * std::numbers::pi * u;
                            return Vector3d(std::cos(angle), std::sin(2.0 * angle), v);
                          })),
            50)
      << "an eight";
}

// Two halves of a waved sheet whose lips have vertices of their own at the same places.
TEST(Intersections, OfLipsThatCoincideAreNone) {
  constexpr int kSide = 21;
  for (const double bend : {0.0, 0.3}) {
    Sheet sheet = grid(kSide, [bend](double u, double v) {
      return Vector3d(0.8 * u - 0.3 * v, 0.7 * v + 0.1 * u, 0.3 * v + 0.45 * u + bend * std::sin(7 * u + 4 * v));
    });
    const Eigen::Index before = sheet.x.cols();
    sheet.x.resize(before + kSide);
    sheet.x.rightCols(kSide) = sheet.x.middleCols(10 * kSide, kSide).eval();
    for (std::size_t t = 20 * 20; t < sheet.triangles.size(); ++t) {
      for (mesh::VertexId& v : sheet.triangles[t]) {
        if (v / kSide == 10) v = static_cast<mesh::VertexId>(before) + v % kSide;
      }
    }
    EXPECT_EQ(count_of(sheet), 0) << bend;
  }
}

TEST(IntersectionSearch, KeepsItsMemory) {
  const Sheet sheet = crumpled(20, 6);
  IntersectionSearch search;
  const std::int64_t count = search.count(sheet.triangles, sheet.x);
  const std::size_t before = test::num_allocations();
  EXPECT_EQ(search.count(sheet.triangles, sheet.x), count);
  EXPECT_EQ(test::num_allocations(), before);
}

}  // namespace
}  // namespace kerf::contact
