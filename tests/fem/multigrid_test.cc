// Tests the parts of multigrid: aggregates, and a preconditioner with which stiff and large sheets take few iterations.
#include "server/core/linear/multigrid_preconditioner.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/vertex_frames.h"
#include "server/core/fem/model/tangent_matrix.h"
#include "server/core/linear/conjugate_gradient.h"
#include "server/core/linear/linear_solver.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

constexpr double kTimeStep = 1.0 / 60.0;  // s

void cut(mesh::TriangleMesh& mesh, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  const Result<cut::CutPlan> plan = cut::plan(mesh, {cut::Polyline{{from, to}}, {}, {}});
  ASSERT_TRUE(plan.ok());
  ASSERT_TRUE(cut::apply(mesh, *plan).ok());
}

// A sheet of wool of 1 m x 1 m rolled to a radius of 0.4 m, and the matrix of a step; two corners of a side of `side`
// vertices pinned.
struct Rolled {
  explicit Rolled(const mesh::TriangleMesh& mesh, int side) : model(mesh, find_preset("wool").value()) {
    constexpr double kRadius = 0.4;  // m
    x.resize(mesh.num_vertices());
    for (int v = 0; v < mesh.num_vertices(); ++v) {
      const Eigen::Vector2d rest = mesh.rest_position(v);
      const double angle = (0.8 * rest.x() + 0.6 * rest.y()) / kRadius;
      const double along = 0.8 * rest.y() - 0.6 * rest.x();
      x.col(v) = Eigen::Vector3d(kRadius * std::sin(angle), along, kRadius * std::cos(angle));
    }
    turn(Eigen::Matrix3d::Identity(), side);
  }
  void turn(const Eigen::Matrix3d& rotation, int side) {
    x = rotation * x;
    tangent.rebuild(model);
    tangent.set_mass(model, 1.0);
    tangent.add_membrane(model, x, {}, {kTimeStep * kTimeStep, 0.0, {}}, kTimeStep * kTimeStep, true);
    tangent.add_bending(model, {kTimeStep * kTimeStep, 0.0, {}});
    std::vector<Pin> pins;
    for (const int v : {0, side - 1}) pins.push_back({v, x.col(v), Eigen::Vector3d::Zero()});
    b.resize(x.cols());
    SeededRandom random(4);
    for (Eigen::Index v = 0; v < x.cols(); ++v) {
      b.col(v) = rotation *
                 (model.mass()[static_cast<std::size_t>(v)] * (Eigen::Vector3d(0, 0, 1) + random_vector(random, 0.3)));
    }
    linear::VertexField step = Eigen::Matrix3Xd::Zero(3, x.cols());
    tangent.constrain(model, pins, 0.0, x, b, step);
  }

  Model model;
  linear::VertexField x;  // 3 x V, m
  TangentMatrix tangent;
  linear::VertexField b;  // 3 x V
};

Rolled rolled_grid(int side) {
  return Rolled(square_grid(side), side);
}

void set_places(const Rolled& sheet, linear::Preconditioner& preconditioner) {
  find_vertex_frames(sheet.model.element_blocks(), sheet.x, *preconditioner.frames());
  *preconditioner.positions() = sheet.x;
}

int iterations(const Rolled& sheet, bool knows_positions = true) {
  auto preconditioner = std::make_unique<linear::MultigridPreconditioner>();
  linear::MultigridPreconditioner& multigrid = *preconditioner;
  linear::ConjugateGradient solver(std::move(preconditioner), 5000);
  solver.analyse(sheet.tangent.blocks());
  set_places(sheet, multigrid);
  if (!knows_positions) multigrid.positions()->setZero();
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, sheet.b.cols());
  const linear::LinearStats stats = solver.solve(sheet.tangent.blocks(), sheet.b, 1e-6, x);
  EXPECT_TRUE(stats.converged);
  EXPECT_LT(stats.residual, 1.1e-6);
  return stats.iterations;
}

linear::VertexAggregates aggregates_of(const mesh::TriangleMesh& mesh) {
  const Model model(mesh, find_preset("wool").value());
  TangentMatrix tangent;
  tangent.rebuild(model);
  linear::VertexAggregates aggregates;
  aggregates.find(tangent.blocks());
  return aggregates;
}

TEST(VertexAggregates, HoldEachVertexOnceAndAreOfAboutNine) {
  const mesh::TriangleMesh mesh = jittered_square(40);
  const linear::VertexAggregates aggregates = aggregates_of(mesh);
  std::vector<int> times(static_cast<std::size_t>(mesh.num_vertices()), 0);
  for (int g = 0; g < aggregates.size(); ++g) {
    const std::span<const int> members = aggregates.members(g);
    EXPECT_TRUE(std::is_sorted(members.begin(), members.end()));
    EXPECT_EQ(aggregates.of(aggregates.root(g)), g);
    for (const int v : members) {
      EXPECT_EQ(aggregates.of(v), g);
      ++times[static_cast<std::size_t>(v)];
    }
  }
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), mesh.num_vertices());
  EXPECT_GT(mesh.num_vertices(), 6 * aggregates.size());
  EXPECT_LT(mesh.num_vertices(), 13 * aggregates.size());
}

// Lips of a cut lie on each other, and far from its tips no aggregate has vertices of both.
TEST(VertexAggregates, DoNotCrossCuts) {
  mesh::TriangleMesh mesh = square_grid(30);
  cut(mesh, {0.2, 0.51}, {0.8, 0.51});
  const linear::VertexAggregates aggregates = aggregates_of(mesh);
  const auto side_of = [&mesh](int v) {
    double height = 0.0;  // m, of the triangles around v above the cut
    std::vector<mesh::TriangleId> triangles;
    mesh.triangles_around(v, triangles);
    for (const mesh::TriangleId t : triangles) {
      for (const mesh::VertexId corner : mesh.vertices(t)) height += mesh.rest_position(corner).y() - 0.51;
    }
    return height > 0.0;
  };
  int beside = 0;
  for (int g = 0; g < aggregates.size(); ++g) {
    std::set<bool> sides;
    for (const int v : aggregates.members(g)) {
      const Eigen::Vector2d rest = mesh.rest_position(v);
      if (rest.x() > 0.35 && rest.x() < 0.65 && std::abs(rest.y() - 0.51) < 0.1) sides.insert(side_of(v));
    }
    EXPECT_LE(sides.size(), 1U) << g;
    beside += sides.empty() ? 0 : 1;
  }
  EXPECT_GT(beside, 4);
}

// Bodies follow a bend the better the less of it there is from one to the next.
TEST(Multigrid, TakesFewerIterationsOfFinerSheets) {
  const int coarse = iterations(rolled_grid(40));
  EXPECT_LT(coarse, 100);
  EXPECT_LT(iterations(rolled_grid(80)), coarse);
}

TEST(Multigrid, TakesAsManyAfterATurnOrACut) {
  Rolled sheet = rolled_grid(40);
  const int before = iterations(sheet);
  SeededRandom random(9);
  sheet.turn(random_rotation(random), 40);
  EXPECT_NEAR(iterations(sheet), before, 3);
  mesh::TriangleMesh mesh = square_grid(40);
  cut(mesh, {0.2, 0.51}, {0.8, 0.53});
  cut(mesh, {0.3, 0.2}, {0.7, 0.4});
  EXPECT_LT(iterations(Rolled(mesh, 40)), 2 * before);
}

TEST(Multigrid, NeedsToKnowWhereVerticesAreToTurnBodies) {
  const Rolled sheet = rolled_grid(40);
  EXPECT_GT(iterations(sheet, false), 4 * iterations(sheet));
}

TEST(Multigrid, IsSymmetricAndPositive) {
  const Rolled sheet = rolled_grid(12);
  linear::MultigridPreconditioner multigrid;
  multigrid.analyse(sheet.tangent.blocks());
  set_places(sheet, multigrid);
  ASSERT_TRUE(multigrid.prepare(sheet.tangent.blocks()));
  SeededRandom random(5);
  for (int i = 0; i < 5; ++i) {
    const linear::VertexField first = random_field(random, sheet.b.cols(), 1.0);
    const linear::VertexField second = random_field(random, sheet.b.cols(), 1.0);
    linear::VertexField of_first(sheet.b.cols());
    linear::VertexField of_second(sheet.b.cols());
    multigrid.apply(first, of_first);
    multigrid.apply(second, of_second);
    const double size = std::sqrt(first.cwiseProduct(of_first).sum() * second.cwiseProduct(of_second).sum());
    EXPECT_GT(first.cwiseProduct(of_first).sum(), 0.0);
    EXPECT_NEAR(first.cwiseProduct(of_second).sum(), second.cwiseProduct(of_first).sum(), 1e-4 * size);
  }
}

// A pinned vertex has a row of its own, whose entry says nothing about the others.
TEST(Multigrid, LeavesPinnedVerticesOutOfBodies) {
  Rolled sheet = rolled_grid(12);
  linear::BlockMatrix& A = sheet.tangent.blocks();
  linear::MultigridPreconditioner multigrid;
  multigrid.analyse(A);
  set_places(sheet, multigrid);
  SeededRandom random(6);
  linear::VertexField r = random_field(random, sheet.b.cols(), 1e-3);
  r.col(11).setZero();
  const auto applied = [&] {
    EXPECT_TRUE(multigrid.prepare(A));
    linear::VertexField z(sheet.b.cols());
    multigrid.apply(r, z);
    return z;
  };
  const linear::VertexField before = applied();
  A.block(A.diagonal(11)) *= 1e4;
  EXPECT_EQ(applied(), before);
  EXPECT_EQ(before.col(11).norm(), 0.0);
}

TEST(Multigrid, SolvesWhatHasNoBodies) {
  linear::BlockMatrix A;
  A.resize(2);
  for (const int i : {0, 1}) {
    A.set_row(i, std::array<int, 1>{i});
    A.block(A.diagonal(i)) = (i + 1.0) * Eigen::Matrix3d::Identity();
  }
  const std::unique_ptr<linear::LinearSolver> solver =
      linear::make_linear_solver(linear::LinearSolverKind::kMultigridCg, 10);
  solver->analyse(A);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, 2);
  const linear::VertexField b = Eigen::Matrix3Xd::Ones(3, 2);
  EXPECT_TRUE(solver->solve(A, b, 1e-12, x).converged);
  EXPECT_NEAR(x(0, 1), 0.5, 1e-12);
}

}  // namespace
}  // namespace kerf::fem
