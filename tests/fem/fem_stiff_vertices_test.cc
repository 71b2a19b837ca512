#include "server/fem/stiff_vertices.h"

#include <cmath>

#include "server/fem/stiff_parts.h"
#include "tests/fem/fem_fixture.h"
#include "tests/support/random_cuts.h"

namespace kerf::fem {
namespace {

constexpr double kLimit = 1.7 * 8.0;  // -, over the stiffness and the mass of a vertex of the uncut grid

double limit_of(const Model& model) {
  const MaterialLaw& law = model.materials()[0];
  return kLimit * law.curvature_bound / (law.surface_density * std::pow(model.typical_edge_length(), 2));
}

std::size_t counted(const Model& model, double limit) {
  std::size_t count = 0;
  for (mesh::VertexId v = 0; v < model.num_vertices(); ++v) {
    const double row = membrane_row_sum(model, v) + bending_row_sum(model, v);
    count += row > limit * model.mass()[static_cast<std::size_t>(v)] ? 1 : 0;
  }
  return count;
}

TEST(StiffVertices, AreNoneOfAGrid) {
  mesh::TriangleMesh mesh = square_grid(20);
  const Model model(mesh, *find_preset("demo"));
  StiffVertices stiff;
  stiff.rebuild(model, limit_of(model));
  EXPECT_EQ(stiff.count(), 0U);
}

TEST(StiffVertices, FollowCutsAndUndos) {
  mesh::TriangleMesh mesh = square_grid(20);
  Model model(mesh, *find_preset("demo"));
  const double limit = limit_of(model);
  test::RandomCuts cuts(3, mesh, model);
  StiffVertices stiff;
  stiff.rebuild(model, limit);
  const auto follow = [&] {
    stiff.follow(model, limit);
    ASSERT_EQ(stiff.count(), counted(model, limit)) << cuts.size() << " cuts";
  };
  while (cuts.size() < 8 && !HasFatalFailure()) {
    cuts.make_one();
    follow();
  }
  EXPECT_GT(stiff.count(), 50U);
  while (cuts.size() > 0 && !HasFatalFailure()) {
    cuts.undo_one();
    follow();
  }
  EXPECT_EQ(stiff.count(), 0U);
}

TEST(StiffVertices, AreCountedAgainWithAnotherLimit) {
  mesh::TriangleMesh mesh = square_grid(20);
  Model model(mesh, *find_preset("demo"));
  test::RandomCuts(3, mesh, model).make(4);
  StiffVertices stiff;
  for (const double times : {1.0, 0.1, 10.0}) {
    stiff.follow(model, times * limit_of(model));
    EXPECT_EQ(stiff.count(), counted(model, times * limit_of(model))) << times;
  }
}

}  // namespace
}  // namespace kerf::fem
