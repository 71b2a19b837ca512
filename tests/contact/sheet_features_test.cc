#include "server/core/contact/sheet_features.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/core/contact/feature_tree.h"
#include "tests/contact/lattice_sheet.h"
#include "tests/support/meshes.h"
#include "tests/support/solid_triangles.h"

namespace kerf::contact {
namespace {

using mesh::kNone;
using mesh::VertexId;

void expect_features(const mesh::TriangleMesh& mesh, const std::string& what) {
  FeatureTree tree;
  tree.set(mesh);
  const SheetFeatures& of = tree.features();
  using Sorted = std::array<VertexId, 2>;
  std::map<Sorted, std::vector<VertexId>> thirds;  // by edge
  std::map<VertexId, std::set<std::array<VertexId, 3>>> at;
  std::set<std::array<VertexId, 3>> triangles;
  const auto sorted = [](VertexId p, VertexId q) { return Sorted{std::min(p, q), std::max(p, q)}; };
  const auto in_order = [](std::array<VertexId, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  for (const std::array<VertexId, 3>& t : test::solid_triangles(mesh)) {
    for (std::size_t k = 0; k < 3; ++k) {
      thirds[sorted(t[(k + 1) % 3], t[(k + 2) % 3])].push_back(t[k]);
      at[t[k]].insert(in_order(t));
    }
    triangles.insert(in_order(t));
  }
  // Triangles, what is across their edges, and the edges and vertices that each owns.
  ASSERT_EQ(of.triangles.size(), triangles.size()) << what;
  ASSERT_EQ(of.first_edge.size(), triangles.size() + 1) << what;
  ASSERT_EQ(of.first_vertex.size(), triangles.size() + 1) << what;
  EXPECT_EQ(of.first_edge.front(), 0) << what;
  EXPECT_EQ(static_cast<std::size_t>(of.first_edge.back()), of.edges.size()) << what;
  EXPECT_EQ(static_cast<std::size_t>(of.first_vertex.back()), of.vertices.size()) << what;
  std::set<std::array<VertexId, 3>> seen;
  std::set<Sorted> owned_edges;
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    const SheetFeatures::Triangle& triangle = of.triangles[t];
    const auto& v = triangle.vertices;
    EXPECT_TRUE(seen.insert(in_order(v)).second) << what;
    std::set<Sorted> owned;
    for (std::size_t k = 0; k < 3; ++k) {
      const Sorted edge = sorted(v[(k + 1) % 3], v[(k + 2) % 3]);
      const std::vector<VertexId>& both = thirds[edge];
      const VertexId across = both.size() == 1 ? kNone : both[0] == v[k] ? both[1] : both[0];
      EXPECT_EQ(triangle.across[k], across) << what;
      if (triangle.owns_edge[k]) owned.insert(edge);
    }
    std::set<Sorted> listed;
    for (std::int32_t e = of.first_edge[t]; e < of.first_edge[t + 1]; ++e) {
      const SheetFeatures::Edge& edge = of.edges[static_cast<std::size_t>(e)];
      const Sorted ends = sorted(edge.vertices[0], edge.vertices[1]);
      listed.insert(ends);
      EXPECT_TRUE(owned_edges.insert(ends).second) << what << ": an edge with two owners";
    }
    EXPECT_EQ(listed, owned) << what;
    for (std::int32_t i = of.first_vertex[t]; i < of.first_vertex[t + 1]; ++i) {
      EXPECT_EQ(std::count(v.begin(), v.end(), of.vertices[static_cast<std::size_t>(i)]), 1) << what;
    }
    Eigen::Matrix2d sides;
    sides << mesh.rest_position(v[1]) - mesh.rest_position(v[0]), mesh.rest_position(v[2]) - mesh.rest_position(v[0]);
    EXPECT_LT((triangle.inverse_edges * sides - Eigen::Matrix2d::Identity()).norm(), 1e-6) << what;
    double altitude = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = (mesh.rest_position(v[(k + 1) % 3]) - mesh.rest_position(v[k])).norm();
      altitude = std::min(altitude, std::abs(sides.determinant()) / length);
    }
    EXPECT_NEAR(triangle.altitude, altitude, 1e-12) << what;
  }
  EXPECT_EQ(owned_edges.size(), thirds.size()) << what << ": edges with an owner";
  const std::set<VertexId> vertices(of.vertices.begin(), of.vertices.end());
  EXPECT_EQ(vertices.size(), of.vertices.size()) << what << ": a vertex with two owners";
  ASSERT_EQ(vertices.size(), at.size()) << what;
  std::set<Sorted> borders;
  for (const auto& [p, q] : of.borders) EXPECT_TRUE(borders.insert(sorted(p, q)).second) << what;
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    const auto& corners = of.triangles[t].vertices;
    for (std::int32_t k = of.first_border[t]; k < of.first_border[t + 1]; ++k) {
      for (const mesh::VertexId v : of.borders[static_cast<std::size_t>(k)]) {
        EXPECT_EQ(std::count(corners.begin(), corners.end(), v), 1) << what << ", " << t;
      }
    }
  }
  EXPECT_EQ(of.first_border.back(), static_cast<std::int32_t>(of.borders.size())) << what;
  for (const auto& [edge, both] : thirds) EXPECT_EQ(borders.contains(edge), both.size() == 1) << what;
  for (const VertexId v : vertices) {
    EXPECT_EQ(of.material[static_cast<std::size_t>(v)], mesh.rest_position(v)) << what;
    std::multiset<VertexId> neighbours(of.neighbours_of(v).begin(), of.neighbours_of(v).end()), expected;
    for (const auto& [edge, both] : thirds) {
      if (edge[0] == v) expected.insert(edge[1]);
      if (edge[1] == v) expected.insert(edge[0]);
    }
    EXPECT_EQ(neighbours, expected) << what;
    ASSERT_EQ(of.edges_of(v).size(), of.neighbours_of(v).size()) << what;
    for (std::size_t k = 0; k < of.edges_of(v).size(); ++k) {
      const auto& ends = of.edges[static_cast<std::size_t>(of.edges_of(v)[k])].vertices;
      EXPECT_EQ(sorted(ends[0], ends[1]), sorted(v, of.neighbours_of(v)[k])) << what;
    }
    std::set<std::array<VertexId, 3>> around;
    double altitude = 1e9;
    for (const std::int32_t t : of.triangles_of(v)) {
      around.insert(in_order(of.triangles[static_cast<std::size_t>(t)].vertices));
      altitude = std::min(altitude, of.triangles[static_cast<std::size_t>(t)].altitude);
    }
    EXPECT_EQ(around, at[v]) << what;
    EXPECT_EQ(of.altitude_at[static_cast<std::size_t>(v)], altitude) << what;
  }
}

TEST(SheetFeatures, AreThoseOfTheMesh) {
  for (const test::ZooMesh& each : test::zoo()) expect_features(test::must(mesh::import_mesh(each.sheet)), each.name);
  expect_features(test::grid(7), "grid");
  expect_features(test::union_jack(6), "union jack");
  expect_features(test::jittered_grid(9, 3), "jittered");
  expect_features(with_slit(), "slit");
  expect_features(in_two_pieces(), "two pieces");
  expect_features(with_arms_and_a_hole(), "arms and a hole");
}

}  // namespace
}  // namespace kerf::contact
