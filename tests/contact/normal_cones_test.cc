// Which of the pairs with one separation counts: at faces, edges and vertices of flat, turned and folded sheets.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "server/core/contact/feature_pair.h"
#include "tests/contact/random_vector.h"
#include "tests/support/meshes.h"

namespace kerf::contact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Kind = FeaturePair::Kind;

// A probe and a sheet: the probe is a triangle that has shrunk to a point.
struct Probed {
  mesh::TriangleMesh mesh;
  SheetFeatures features;
  linear::VertexField x;
  std::int32_t probe = 0;  // triangle

  // `is_first`: ids of the probe come before those of the sheet.
  explicit Probed(bool is_first) {
    constexpr int kSide = 4;  // cells
    mesh::IndexedMesh sheet;
    const int num_sheet = (kSide + 1) * (kSide + 1), first = is_first ? 3 : 0, first_probe = is_first ? 0 : num_sheet;
    sheet.rest.resize(2, num_sheet + 3);
    sheet.triangles.resize(3, 2 * kSide * kSide + 1);
    sheet.rest.col(first_probe) = Vector2d(-2.0, 0.0);
    sheet.rest.col(first_probe + 1) = Vector2d(-1.0, 0.0);
    sheet.rest.col(first_probe + 2) = Vector2d(-1.0, 1.0);
    Eigen::Index next = 0;
    sheet.triangles.col(next++) = Eigen::Vector3i(first_probe, first_probe + 1, first_probe + 2);
    for (int j = 0; j <= kSide; ++j) {
      for (int i = 0; i <= kSide; ++i) {
        const int a = first + j * (kSide + 1) + i, b = a + 1, d = a + kSide + 1, c = d + 1;
        sheet.rest.col(a) = Vector2d(i, j);
        if (i == kSide || j == kSide) continue;
        sheet.triangles.col(next++) = Eigen::Vector3i(a, b, c);
        sheet.triangles.col(next++) = Eigen::Vector3i(a, c, d);
      }
    }
    mesh = test::must(mesh::import_mesh(sheet));
    std::vector<mesh::TriangleId> order(static_cast<std::size_t>(mesh.num_solid_triangles()));
    std::iota(order.begin(), order.end(), 0);
    std::rotate(order.begin(), order.begin() + 7, order.end());
    features.set(mesh, order);
    const auto found = std::find(order.begin(), order.end(), 0);
    probe = static_cast<std::int32_t>(found - order.begin());
    x.resize(mesh.num_vertices());
  }
  template <typename Place>
  void place_sheet(const Place& place) {
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) x.col(v) = place(mesh.rest_position(v));
  }
  [[nodiscard]] const SheetFeatures::Triangle& probe_triangle() const {
    return features.triangles[static_cast<std::size_t>(probe)];
  }
  [[nodiscard]] FeaturePair pair(mesh::VertexId v, std::int32_t t) const {
    const std::array<mesh::VertexId, 3>& corners = features.triangles[static_cast<std::size_t>(t)].vertices;
    return {Kind::kVertexTriangle, v, t, {v, corners[0], corners[1], corners[2]}, 0.0, 0.0};
  }
  [[nodiscard]] bool counts(const FeaturePair& pair) const {
    const Separation found = separation(pair.kind, positions_of(pair, x));
    return stands_for_separation(features, pair, found) && is_in_cones(features, pair, found, x);
  }
  // Puts the probe at p. Returns the number of pairs of it and the sheet that count.
  int count(const Vector3d& p) {
    const std::array<mesh::VertexId, 3>& corners = probe_triangle().vertices;
    for (const mesh::VertexId v : corners) x.col(v) = p;
    int number = 0;
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(features.triangles.size()); ++t) {
      if (t != probe && counts(pair(corners[0], t))) ++number;
    }
    for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
      if (std::find(corners.begin(), corners.end(), v) == corners.end() && counts(pair(v, probe))) ++number;
    }
    return number;
  }
  // Returns the number of places of the sheet that are nearer to p than all others around them; -1 where two triangles
  // have places so close to each other that rounding might decide.
  [[nodiscard]] int num_nearest_places(const Vector3d& p) const {
    const auto from_triangle = [this](std::size_t t, const Vector3d& at, Vector3d& place) {
      const std::array<mesh::VertexId, 3>& c = features.triangles[t].vertices;
      const Separation found = separation(Kind::kVertexTriangle, {at, x.col(c[0]), x.col(c[1]), x.col(c[2])});
      place = at - found.distance * found.normal;
      return found.distance;
    };
    std::vector<Vector3d> places, all;
    for (std::size_t t = 0; t < features.triangles.size(); ++t) {
      if (t == static_cast<std::size_t>(probe)) continue;
      Vector3d place;
      const double distance = from_triangle(t, p, place);
      bool is_nearest = std::none_of(places.begin(), places.end(),
                                     [&](const Vector3d& other) { return (other - place).norm() < 1e-9; });
      for (const Vector3d& other : all) {
        if ((other - place).norm() > 1e-9 && (other - place).norm() < 0.01) return -1;
      }
      all.push_back(place);
      // Looks at the sheet around the place, a little nearer to p.
      const Vector3d nearer = place + 1e-6 * (p - place);
      for (std::size_t u = 0; u < features.triangles.size() && is_nearest; ++u) {
        if (u == static_cast<std::size_t>(probe)) continue;
        Vector3d other;
        from_triangle(u, nearer, other);
        if ((other - place).norm() < 1e-5 && (other - p).norm() < distance - 1e-14) is_nearest = false;
      }
      if (is_nearest) places.push_back(place);
    }
    return static_cast<int>(places.size());
  }
};

TEST(IsInCones, CountsOnePairForAPointNearAFlatSheet) {
  for (const bool is_first : {true, false}) {
    Probed sheet(is_first);
    sheet.place_sheet([](const Vector2d& p) { return Vector3d(p.x(), p.y(), 0.0); });
    for (const double height : {0.3, -0.3}) {
      for (double u = -0.5; u <= 4.5; u += 0.25) {
        for (double v = -0.5; v <= 4.5; v += 0.25) {
          EXPECT_EQ(sheet.count(Vector3d(u, v, height)), 1) << u << ", " << v << ", " << height << ", " << is_first;
        }
      }
    }
  }
}

// The same points of a sheet that is turned: rounding decides what is nearest.
TEST(IsInCones, CountsAPairForAPointOverAnEdgeOrVertexOfATurnedSheet) {
  SeededRandom random(8);
  Probed sheet(true);
  int num_without = 0, num_points = 0;
  for (int k = 0; k < 100; ++k) {
    const Vector3d axis = random_vector(random, 1.0).normalized();
    const Eigen::AngleAxisd turn(random.uniform(0.0, 3.0), axis);
    const auto at = [&](double u, double v, double height) -> Vector3d { return turn * Vector3d(u, v, height); };
    sheet.place_sheet([&](const Vector2d& p) { return at(p.x(), p.y(), 0.0); });
    for (double u = 0.0; u <= 4.0; u += 0.5) {
      for (double v = 0.0; v <= 4.0; v += 0.5) {
        ++num_points;
        num_without += sheet.count(at(u, v, 0.01)) == 0 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(num_without, 0) << "of " << num_points;
}

TEST(IsInCones, CountsOnePairForEachNearestPlaceOfAFoldedSheet) {
  SeededRandom random(9);
  for (const bool is_first : {true, false}) {
    Probed sheet(is_first);
    for (const double fold : {0.3, 1.2, 2.0, 2.8}) {
      // Folded at u = 2, and bent a little at other columns so that no two triangles lie in one plane by chance.
      sheet.place_sheet([fold](const Vector2d& p) {
        const double along = std::abs(p.x() - 2.0);
        const double side = p.x() < 2.0 ? -1.0 : 1.0;
        return Vector3d(side * along * std::cos(0.5 * fold), p.y(),
                        -along * std::sin(0.5 * fold) + 0.02 * p.y() * p.y() + 0.01 * along * p.y());
      });
      std::array<int, 4> seen{};
      for (int k = 0; k < 800; ++k) {
        const Vector3d p(random.uniform(-2.5, 2.5), random.uniform(-0.5, 4.5), random.uniform(-2.5, 1.0));
        const int expected = sheet.num_nearest_places(p);
        if (expected < 0) continue;
        ++seen[static_cast<std::size_t>(std::min(expected, 3))];
        ASSERT_EQ(sheet.count(p), expected) << p.transpose() << ", fold " << fold << ", " << is_first;
      }
      EXPECT_EQ(seen[0], 0);
      EXPECT_GT(seen[1], 50);
      EXPECT_GT(seen[2], 20);
    }
  }
}

}  // namespace
}  // namespace kerf::contact
