// Sheets that pass through themselves, whose vertices are free: what contact leaves alone and what pulls them apart.
#include "server/core/contact/untangling.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/feature_tree.h"
#include "tests/contact/drift.h"

namespace kerf::contact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using mesh::VertexId;

constexpr int kPokedCells = 8;
constexpr double kPokedEdge = 0.02;  // m
constexpr double kPull = 0.05;       // m/s

// Two squares 1 mm apart; a vertex of the upper one is `depth` (m) below the lower one.
Drift poked(double depth) {
  mesh::TriangleMesh mesh = two_squares(kPokedCells, kPokedCells, kPokedEdge);
  linear::VertexField x(mesh.num_vertices());
  for (VertexId v = 0; v < mesh.num_vertices(); ++v) {
    const Vector2d p = mesh.rest_position(v);
    const Vector2d q(p.x() - (kPokedCells + 1) * kPokedEdge, p.y());
    const double away = (q - Vector2d(0.08, 0.08)).norm() / (1.2 * kPokedEdge);
    x.col(v) = is_second(mesh, v, kPokedCells, kPokedEdge)
                   ? Vector3d(q.x() + 3e-3, q.y() + 5e-3, 1e-3 - (1e-3 + depth) * std::max(0.0, 1.0 - away))
                   : Vector3d(p.x(), p.y(), 0.0);
  }
  return {std::move(mesh), std::move(x)};
}

TEST(Untangling, OpensThePairsAtTrianglesThatPassThroughEachOther) {
  const Drift sheets = poked(2e-3);
  FeatureTree tree;
  tree.set(sheets.mesh);
  Untangling untangling;
  untangling.set(tree.features());
  untangling.begin(tree.features(), sheets.x);
  ASSERT_FALSE(untangling.empty());
  std::vector<std::array<VertexId, 3>> triangles;
  for (const SheetFeatures::Triangle& triangle : tree.features().triangles) triangles.push_back(triangle.vertices);
  const auto pairs = IntersectionSearch().find(triangles, sheets.x, 1000).pairs;
  std::set<std::array<VertexId, 2>> open;
  for (const auto& [t, u] : pairs) {
    for (const VertexId v : triangles[static_cast<std::size_t>(t)]) {
      for (const VertexId w : triangles[static_cast<std::size_t>(u)]) open.insert({std::min(v, w), std::max(v, w)});
    }
  }
  std::vector<FeaturePair> found;
  const std::vector<float> slack(static_cast<std::size_t>(sheets.x.cols()), 1e-3F);
  tree.find_pairs({sheets.x, sheets.v, 1e-3}, 0.01, slack, kApart, found);
  std::size_t num_open = 0;
  for (const FeaturePair& pair : found) {
    bool expected = false;
    for (std::size_t i = 0; i < pair.num_a(); ++i) {
      for (std::size_t j = pair.num_a(); j < 4; ++j) {
        const VertexId v = pair.vertices[i], w = pair.vertices[j];
        expected = expected || open.contains({std::min(v, w), std::max(v, w)});
      }
    }
    ASSERT_EQ(untangling.is_open(pair), expected);
    num_open += expected ? 1 : 0;
  }
  EXPECT_GT(num_open, 20U);
  EXPECT_LT(num_open, found.size() / 2);
}

TEST(Untangling, CountsPairsWhereverTheVerticesAre) {
  Drift sheets = poked(2e-3);
  FeatureTree tree;
  tree.set(sheets.mesh);
  Untangling untangling;
  untangling.set(tree.features());
  const std::int64_t num_pairs = sheets.num_intersections();
  EXPECT_EQ(untangling.count(sheets.x), num_pairs);
  EXPECT_EQ(untangling.count(sheets.x), num_pairs);
  const linear::VertexField apart = poked(-5e-4).x;
  EXPECT_EQ(untangling.count(apart), 0);
  EXPECT_TRUE(untangling.empty());
  EXPECT_EQ(untangling.count(sheets.x), num_pairs);
  untangling.know_none(apart);
  EXPECT_EQ(untangling.count(apart), 0);
  EXPECT_EQ(untangling.count(sheets.x), num_pairs);
}

TEST(Untangling, PullsAVertexBackWithoutMomentumOrMuchEnergy) {
  Drift sheets = poked(2e-3);
  ASSERT_GT(sheets.num_intersections(), 4);
  double mass = 0.0;
  for (const double inverse : sheets.inverse_mass) mass += 1.0 / inverse;
  for (int step = 0; step < 10; ++step) {
    sheets.step(2.6e-4, 64, [&] {
      ASSERT_LT(sheets.momentum().norm(), 1e-15 * mass);
      ASSERT_LE(sheets.v.colwise().norm().maxCoeff(), 1.5 * kPull);
    });
  }
  EXPECT_EQ(sheets.num_intersections(), 0);
  EXPECT_LT(sheets.kinetic_energy(), 0.5 * mass * kPull * kPull);
}

TEST(Untangling, StopsWhatGoesDeeper) {
  Drift sheets = poked(2e-3);
  for (VertexId v = 0; v < sheets.mesh.num_vertices(); ++v) {
    if (is_second(sheets.mesh, v, kPokedCells, kPokedEdge)) sheets.v.col(v) = Vector3d(0.1, 0.0, -1.0);
  }
  double energy = sheets.kinetic_energy();
  for (int step = 0; step < 20; ++step) {
    sheets.step(2.6e-4, 64, [&] {
      ASSERT_LE(sheets.kinetic_energy(), energy * (1.0 + 1e-3));
      energy = sheets.kinetic_energy();
    });
  }
  EXPECT_EQ(sheets.num_intersections(), 0);
}

TEST(Untangling, LeavesHeldVerticesWhereTheyAre) {
  for (const bool holds_second : {false, true}) {
    Drift sheets = poked(2e-3);
    for (VertexId v = 0; v < sheets.mesh.num_vertices(); ++v) {
      if (is_second(sheets.mesh, v, kPokedCells, kPokedEdge) == holds_second) {
        sheets.inverse_mass[static_cast<std::size_t>(v)] = 0.0;
      }
    }
    const linear::VertexField before = sheets.x;
    for (int step = 0; step < 10; ++step) sheets.step(2.6e-4, 64, [] {});
    for (VertexId v = 0; v < sheets.mesh.num_vertices(); ++v) {
      if (sheets.inverse_mass[static_cast<std::size_t>(v)] == 0.0) {
        ASSERT_EQ(sheets.x.col(v), before.col(v));
      }
    }
    EXPECT_EQ(sheets.num_intersections(), 0);
  }
  // Both held: nothing moves, and nothing fails.
  Drift sheets = poked(2e-3);
  std::fill(sheets.inverse_mass.begin(), sheets.inverse_mass.end(), 0.0);
  const linear::VertexField before = sheets.x;
  sheets.step(2.6e-4, 64, [] {});
  EXPECT_EQ(sheets.x, before);
}

TEST(Untangling, KeepsNothingFromStepToStep) {
  Drift first = poked(4e-3), second = poked(4e-3);
  for (int step = 0; step < 6; ++step) {
    second.reset();
    first.step(2.6e-4, 32, [] {});
    second.step(2.6e-4, 32, [] {});
    ASSERT_EQ(first.x, second.x);
    ASSERT_EQ(first.v, second.v);
  }
  EXPECT_GT(first.kinetic_energy(), 0.0);
}

}  // namespace
}  // namespace kerf::contact
