#include "server/core/mesh/edge_lengths.h"

#include <cmath>

#include <gtest/gtest.h>

#include "server/core/mesh/build/grid_mesh.h"
#include "server/core/mesh/build/mesh_import.h"

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

// Rectangles of height 1 and these widths side by side, two triangles each.
TriangleMesh strip(const std::vector<double>& widths) {
  IndexedMesh input;
  const auto count = static_cast<Eigen::Index>(widths.size());
  input.rest.resize(2, 2 * (count + 1));
  input.triangles.resize(3, 2 * count);
  double x = 0.0;
  for (Eigen::Index i = 0; i <= count; ++i) {
    input.rest.col(2 * i) = Vector2d(x, 0.0);
    input.rest.col(2 * i + 1) = Vector2d(x, 1.0);
    if (i == count) break;
    x += widths[static_cast<std::size_t>(i)];
    const int at = static_cast<int>(2 * i);
    input.triangles.col(2 * i) = Eigen::Vector3i(at, at + 2, at + 3);
    input.triangles.col(2 * i + 1) = Eigen::Vector3i(at, at + 3, at + 1);
  }
  return import_mesh(input).value();
}

TEST(EdgeLengths, OneLengthWhereTrianglesAreNearlyEqual) {
  for (const TriangleMesh& mesh :
       {make_grid({30, 20, 1.0, 0.7}).value(), make_jittered_grid({30, 30, 1.0, 1.0}, 3).value(),
        make_grid({2, 2, 5.0, 0.01}).value()}) {
    EXPECT_TRUE(mesh.edge_lengths().is_uniform());
    EXPECT_EQ(mesh.edge_lengths().at({0.3, 0.4}), mesh.base_edge_length());
    EXPECT_EQ(mesh.edge_lengths().least(), mesh.base_edge_length());
    EXPECT_TRUE(std::isinf(mesh.edge_lengths().resolution()));
  }
}

TEST(EdgeLengths, StepsOfTwoWhereTheyDiffer) {
  std::vector<double> widths(10, 1.0);
  widths.insert(widths.end(), 640, 1.0 / 64.0);  // edge length 1/8
  const TriangleMesh mesh = strip(widths);
  const EdgeLengths& lengths = mesh.edge_lengths();
  ASSERT_FALSE(lengths.is_uniform());
  const double mean = mesh.base_edge_length();
  EXPECT_NEAR(mean, (10 + 80) / 650.0, 1e-12);
  EXPECT_EQ(lengths.at({2.0, 0.5}), 8.0 * mean);    // 1 / 0.138 = 7.2, nearest to 8
  EXPECT_EQ(lengths.at({15.0, 0.5}), mean);         // 0.125 / 0.138
  EXPECT_EQ(lengths.at({-50.0, 0.5}), 8.0 * mean);  // outside: as at the rim
  EXPECT_EQ(lengths.at({150.0, 9.0}), mean);
  EXPECT_EQ(lengths.least(), mean);
  EXPECT_EQ(lengths.least_in({Vector2d(1.0, 0.2), Vector2d(3.0, 0.3)}), 8.0 * mean);
  EXPECT_EQ(lengths.least_in({Vector2d(1.0, 0.2), Vector2d(17.0, 0.3)}), mean);
  EXPECT_LE(lengths.resolution(), 2.0 * mean);
}

TEST(EdgeLengths, ArePartOfTheState) {
  std::vector<double> widths(10, 1.0);
  widths.insert(widths.end(), 640, 1.0 / 64.0);
  const TriangleMesh mesh = strip(widths);
  MeshData data = mesh.data();
  data.lengths.exponents[0] = 1;
  const TriangleMesh other(data);
  EXPECT_FALSE(mesh == other);
  EXPECT_NE(mesh.state_hash(), other.state_hash());
}

}  // namespace
}  // namespace kerf::mesh
