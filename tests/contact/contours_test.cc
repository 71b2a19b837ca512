#include "server/core/contact/contours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/feature_tree.h"
#include "server/core/contact/intersections.h"
#include "tests/contact/drift.h"

namespace kerf::contact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using mesh::VertexId;

constexpr int kSquareCells = 8, kStripCells = 3;
constexpr double kSquareEdge = 0.02;  // m

// A square in the plane z = 0 and a second one at place(material position from its corner), m.
struct Crossing {
  template <typename Place>
  Crossing(int second, const Place& place)
      : mesh(two_squares(kSquareCells, second, kSquareEdge)), x(mesh.num_vertices()) {
    for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
      const Vector2d p = mesh.rest_position(v);
      x.col(v) = is_of_second(v) ? place(Vector2d(p.x() - (kSquareCells + 1) * kSquareEdge, p.y()))
                                 : Vector3d(p.x(), p.y(), 0.0);
    }
    tree.set(mesh);
    const SheetFeatures& features = tree.features();
    std::vector<std::array<VertexId, 3>> triangles;
    for (const SheetFeatures::Triangle& triangle : features.triangles) triangles.push_back(triangle.vertices);
    pairs = IntersectionSearch().find(triangles, x, std::numeric_limits<std::size_t>::max()).pairs;
    ContourFinder().find(features, pairs, x, piercings);
  }
  [[nodiscard]] bool is_of_second(VertexId v) const { return is_second(mesh, v, kSquareCells, kSquareEdge); }
  // Returns the way of the second square relative to the first one.
  [[nodiscard]] Vector3d way_of_second(const Piercing& of) const {
    const VertexId v = tree.features().edges[static_cast<std::size_t>(of.edge)].vertices[0];
    return is_of_second(v) ? of.way : Vector3d(-of.way);
  }

  mesh::TriangleMesh mesh;
  linear::VertexField x;
  FeatureTree tree;
  std::vector<std::array<std::int32_t, 2>> pairs;
  std::vector<Piercing> piercings;
};

// Stands on the square, 5 mm too deep.
Vector3d standing(const Vector2d& p, double x) {
  return {x + p.x(), 0.083 + 0.1 * p.x(), p.y() - 5e-3};
}

TEST(Contours, AreNoneWhereNothingPasses) {
  const Crossing apart(kSquareCells, [](const Vector2d& p) { return Vector3d(p.x(), p.y(), 1e-4); });
  EXPECT_TRUE(apart.pairs.empty());
  EXPECT_TRUE(apart.piercings.empty());
}

TEST(Contours, LeadAVertexThatPokesThroughBack) {
  const Crossing poked(kSquareCells, [](const Vector2d& p) {
    const double away = (p - Vector2d(0.08, 0.08)).norm() / (1.2 * kSquareEdge);
    return Vector3d(p.x() + 3e-3, p.y() + 5e-3, 1e-3 - 4e-3 * std::max(0.0, 1.0 - away));
  });
  ASSERT_GE(poked.pairs.size(), 4U);
  ASSERT_EQ(poked.piercings.size(), poked.pairs.size());  // one closed contour
  for (const Piercing& of : poked.piercings) {
    EXPECT_NEAR(of.way.norm(), 1.0, 1e-12);
    EXPECT_GT(poked.way_of_second(of).z(), 0.5);
  }
}

TEST(Contours, LeadTheSmallerSideOfAStripBack) {
  for (const double up : {1.0, -1.0}) {  // most of it is above the square, or below
    const Crossing through(kStripCells, [up](const Vector2d& p) {
      const Vector3d at = standing(p, 0.043);
      return Vector3d(at.x(), at.y(), up * at.z());
    });
    ASSERT_EQ(through.piercings.size(), through.pairs.size() + 1);  // one open contour
    for (const Piercing& of : through.piercings) EXPECT_NEAR(through.way_of_second(of).z(), up, 1e-9);
  }
}

TEST(Contours, BetweenTwoBordersBecomeShorter) {
  const Crossing beside(kStripCells, [](const Vector2d& p) { return standing(p, 0.131); });
  ASSERT_EQ(beside.piercings.size(), beside.pairs.size() + 1);
  for (const Piercing& of : beside.piercings) {
    EXPECT_NEAR(of.way.norm(), 1.0, 1e-12);
    EXPECT_GT(beside.way_of_second(of).x(), 0.9);  // out of the square
  }
}

TEST(Contours, DoNotDependOnWhatWasFoundBefore) {
  const Crossing first(kStripCells, [](const Vector2d& p) { return standing(p, 0.131); });
  const Crossing second(kStripCells, [](const Vector2d& p) { return standing(p, 0.043); });
  ContourFinder finder;
  std::vector<Piercing> found;
  for (const Crossing* each : {&first, &second, &first}) {
    finder.find(each->tree.features(), each->pairs, each->x, found);
    ASSERT_EQ(found.size(), each->piercings.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ(found[k].edge, each->piercings[k].edge);
      EXPECT_EQ(found[k].triangle, each->piercings[k].triangle);
      EXPECT_EQ(found[k].way, each->piercings[k].way);
    }
  }
}

}  // namespace
}  // namespace kerf::contact
