// Tests that cuts of a bent sheet leave it where it is in space, if asked to.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/base/random.h"
#include "server/core/cut/bent_edges.h"
#include "server/core/fem/model/transfer.h"
#include "tests/cut/calls.h"

namespace kerf::cut {
namespace {

linear::VertexField flat_positions(const mesh::TriangleMesh& mesh) {
  linear::VertexField x = linear::VertexField::Zero(3, mesh.num_vertices());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) x.col(v).head<2>() = mesh.rest_position(v);
  return x;
}

linear::VertexField crumpled_positions(const mesh::TriangleMesh& mesh, std::uint64_t seed) {
  SeededRandom random(seed);
  linear::VertexField x = flat_positions(mesh);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) x(2, v) = random.uniform(-0.05, 0.05);
  return x;
}

double area(const mesh::TriangleMesh& mesh, const linear::VertexField& x) {
  double sum = 0.0;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& [a, b, c] = mesh.vertices(t);
    const Eigen::Vector3d first = x.col(b) - x.col(a);
    const Eigen::Vector3d second = x.col(c) - x.col(a);
    sum += 0.5 * first.cross(second).norm();
  }
  return sum;
}

// Cuts a crumpled sheet and returns the ratio by which its area in space changes.
double change_of_area(std::uint64_t seed, const std::optional<ShiftLimit>& most_shift) {
  mesh::TriangleMesh mesh = jittered(12);
  linear::VertexField x = crumpled_positions(mesh, seed);
  const double before = area(mesh, x);
  CutRequest request{s_curve(), {}, {}};
  request.positions = &x;
  request.most_shift = most_shift;
  const CutOutcome outcome = cut(mesh, request);
  EXPECT_EQ(outcome.status, CutStatus::kApplied);
  EXPECT_FALSE(outcome.report.refinement_stopped);
  fem::carry_over(outcome.edit, x);
  return area(mesh, x) / before - 1.0;
}

TEST(BentEdges, ACutThatKeepsThemLeavesTheSheetWhereItIs) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_NEAR(change_of_area(seed, ShiftLimit{}), 0.0, 1e-9) << seed;
    EXPECT_GT(std::abs(change_of_area(seed, std::nullopt)), 1e-4) << seed;
  }
}

// A bend that is too sharp beside something else is not where nothing is near. Vertices without a flag are not apart.
TEST(BentEdges, AreFewerWhereNothingIsNear) {
  const mesh::TriangleMesh mesh = grid(21);
  linear::VertexField x = flat_positions(mesh);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) x(2, v) = 0.5 * x(0, v) * x(0, v);
  const std::vector<Stroke> strokes{{{{0.01, 0.52}, {0.99, 0.52}}}};
  std::vector<std::uint8_t> is_apart(static_cast<std::size_t>(mesh.num_vertices()), 1);
  const ShiftLimit limit{1e-5, 1e-2, is_apart};
  const std::size_t most = bent_edges(mesh, strokes, x, ShiftLimit{.near = limit.near}).size();
  EXPECT_GT(most, 20U);
  EXPECT_EQ(bent_edges(mesh, strokes, x, {limit.near, limit.apart, {}}).size(), most);
  EXPECT_TRUE(bent_edges(mesh, strokes, x, limit).empty());
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (x(0, v) < 0.5) is_apart[static_cast<std::size_t>(v)] = 0;
  }
  const std::size_t some = bent_edges(mesh, strokes, x, limit).size();
  EXPECT_GT(some, most / 4);
  EXPECT_LT(some, most);
}

TEST(BentEdges, AFlatSheetHasNone) {
  const mesh::TriangleMesh mesh = jittered(12);
  linear::VertexField x = flat_positions(mesh);
  x.row(2) = 0.3 * x.row(0) - 0.2 * x.row(1);
  const std::vector<Stroke> strokes{{{{0.1, 0.1}, {0.9, 0.8}}}};
  EXPECT_TRUE(bent_edges(mesh, strokes, x, ShiftLimit{.near = 1e-12}).empty());
  CutRequest request{s_curve(), {}, {}};
  request.positions = &x;
  request.most_shift = ShiftLimit{.near = 1e-9};
  mesh::TriangleMesh kept = mesh;
  mesh::TriangleMesh plain = mesh;
  cut(kept, request);
  cut(plain, {s_curve(), {}, {}});
  EXPECT_EQ(kept.num_triangle_slots(), plain.num_triangle_slots());
}

// A sheet that is folded flat lies in one plane, but its folded edges are bent.
TEST(BentEdges, AreThoseOfASheetFoldedFlat) {
  const mesh::TriangleMesh mesh = grid(21);
  linear::VertexField x = flat_positions(mesh);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) x(0, v) = std::min(x(0, v), 1.0 - x(0, v));
  const auto edges = bent_edges(mesh, std::vector<Stroke>{{{{0.01, 0.52}, {0.99, 0.52}}}}, x, ShiftLimit{.near = 1e-3});
  EXPECT_GE(edges.size(), 7U);
  for (const auto& [p, q] : edges) {
    EXPECT_DOUBLE_EQ(mesh.point_position(p).x(), 0.5);
    EXPECT_DOUBLE_EQ(mesh.point_position(q).x(), 0.5);
  }
}

// The grid is folded along its middle column by a right angle, so only edges there are bent, and only if near.
TEST(BentEdges, AreThoseOfAFoldNearTheStrokes) {
  const mesh::TriangleMesh mesh = grid(21);
  linear::VertexField x = flat_positions(mesh);
  for (mesh::VertexId v = 0; v < mesh.num_vertices(); ++v) {
    if (x(0, v) <= 0.5) continue;
    x(2, v) = x(0, v) - 0.5;
    x(0, v) = 0.5;
  }
  const std::vector<Stroke> across{{{{0.31, 0.52}, {0.72, 0.52}}}};
  const auto edges = bent_edges(mesh, across, x, ShiftLimit{.near = 1e-3});
  EXPECT_EQ(edges.size(), 7U);  // the edge crossed and three rings to both sides
  for (const auto& [p, q] : edges) {
    EXPECT_DOUBLE_EQ(mesh.point_position(p).x(), 0.5);
    EXPECT_DOUBLE_EQ(mesh.point_position(q).x(), 0.5);
  }
  // The diagonals of the quadrilateral across the fold are h / sqrt(2) from each other.
  EXPECT_EQ(bent_edges(mesh, across, x, ShiftLimit{.near = 0.999 * 0.05 / std::sqrt(2.0)}).size(), 7U);
  EXPECT_TRUE(bent_edges(mesh, across, x, ShiftLimit{.near = 1.001 * 0.05 / std::sqrt(2.0)}).empty());
  EXPECT_TRUE(
      bent_edges(mesh, std::vector<Stroke>{{{{0.01, 0.52}, {0.12, 0.52}}}}, x, ShiftLimit{.near = 1e-3}).empty());
}

}  // namespace
}  // namespace kerf::cut
