#include "server/core/fem/statics/modes.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {
namespace {

// Squashed, a sheet has many shapes in which it would buckle, far below the eigenvalues next to 0.
TEST(Modes, AreTheLowestOfAnUnstableStateToo) {
  const mesh::TriangleMesh mesh = jittered_square(8);
  const Model model(mesh, isotropic(1.0e6, 0.3, 1.0e-3, 300.0));
  Loads loads;
  loads.gravity.setZero();
  const linear::VertexField x = 0.8 * rest_state(mesh).x;
  const Modes few = find_modes(model, loads, x, 3);
  const Modes many = find_modes(model, loads, x, 60);
  ASSERT_TRUE(few.converged && many.converged);
  EXPECT_LT(many.eigenvalues[10], 0.0);
  for (Eigen::Index i = 0; i < few.eigenvalues.size(); ++i) {
    EXPECT_NEAR(few.eigenvalues[i], many.eigenvalues[i], 1e-6 * std::abs(many.eigenvalues[0])) << i;
  }
}

// A free sheet has six motions of a rigid body, all of them of one eigenvalue.
TEST(Modes, OfOneEigenvalueAreAllFound) {
  for (const int n : {8, 14, 21}) {
    const mesh::TriangleMesh mesh = jittered_square(n, 1.0, 7);
    const Model model(mesh, isotropic(1.0e9, 0.3, 1.0e-3, 1000.0));
    Loads loads;
    loads.gravity.setZero();
    const Modes modes = find_modes(model, loads, rest_state(mesh).x, 8);
    ASSERT_TRUE(modes.converged) << n;
    for (Eigen::Index i = 0; i < 6; ++i)
      EXPECT_LT(std::abs(modes.eigenvalues[i]), 1e-9 * model.stiffness_bound().value()) << n;
    EXPECT_GT(modes.eigenvalues[6], 0.1 * modes.eigenvalues[7]) << n;
  }
}

// A sheet in many pieces has hundreds of such motions, of which some are requested.
TEST(Modes, AreTheFirstOfASheetInManyPieces) {
  constexpr int kPieces = 90;
  mesh::IndexedMesh pieces;
  pieces.rest.resize(2, 4 * kPieces);
  pieces.triangles.resize(3, 2 * kPieces);
  SeededRandom random(4);
  for (int i = 0; i < kPieces; ++i) {
    const double size = random.uniform(0.05, 0.9);
    for (int k = 0; k < 4; ++k) pieces.rest.col(4 * i + k) = Eigen::Vector2d(i + size * (k % 2), size * (k / 2));
    pieces.triangles.col(2 * i) = Eigen::Vector3i(4 * i, 4 * i + 1, 4 * i + 3);
    pieces.triangles.col(2 * i + 1) = Eigen::Vector3i(4 * i, 4 * i + 3, 4 * i + 2);
  }
  const mesh::TriangleMesh mesh = mesh::import_mesh(pieces).value();
  const Model model(mesh, isotropic(1.0e5, 0.3, 1.0e-3, 300.0));
  Loads loads;
  loads.gravity.setZero();
  int asked = 0;
  const Modes modes = find_modes(model, loads, rest_state(mesh).x, 5, [&] {
    ++asked;
    return false;
  });
  ASSERT_TRUE(modes.converged);
  for (const double value : modes.eigenvalues) EXPECT_LT(std::abs(value), 1e-9 * model.stiffness_bound().value());
  EXPECT_LT(asked, 2000) << "a search for all of them takes tens of thousands";
}

TEST(Modes, EndWhenTheyAreNotWantedAnyMore) {
  const mesh::TriangleMesh mesh = jittered_square(12);
  const Model model(mesh, isotropic(1.0e5, 0.3, 1.0e-3, 300.0));
  Loads loads;
  loads.gravity.setZero();
  int asked = 0;
  const Modes modes = find_modes(model, loads, rest_state(mesh).x, 5, [&] { return ++asked >= 10; });
  EXPECT_TRUE(modes.stopped);
  EXPECT_FALSE(modes.converged);
  EXPECT_EQ(asked, 10);
}

// However many are asked for, they are the first of all: also where the last is one of a pair.
TEST(Modes, AreTheFirstOfMore) {
  const mesh::TriangleMesh mesh = square_grid(7);
  const Model model(mesh, isotropic(1.0e5, 0.3, 1.0e-2, 1000.0));
  Loads loads;
  loads.gravity.setZero();
  const linear::VertexField x = rest_state(mesh).x;
  for (int v = 0; v < mesh.num_vertices(); ++v)
    loads.pins.push_back({v, x.col(v), Eigen::Vector3d::Zero(), {false, false, true}});
  const Modes all = find_modes(model, loads, x, 20);
  ASSERT_TRUE(all.converged);
  for (int count = 1; count < 20; ++count) {
    const Modes modes = find_modes(model, loads, x, count);
    ASSERT_TRUE(modes.converged) << count;
    ASSERT_EQ(modes.eigenvalues.size(), count);
    ASSERT_EQ(modes.shapes.cols(), count);
    for (Eigen::Index i = 0; i < count; ++i) {
      EXPECT_NEAR(modes.eigenvalues[i], all.eigenvalues[i], 1e-8 * all.eigenvalues[19]) << count << ", " << i;
    }
  }
}

}  // namespace
}  // namespace kerf::fem
