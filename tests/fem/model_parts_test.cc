// The parts of a model, each by itself: elements at rest, masses of vertices, the bending operator.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "server/core/fem/model/bending_operator.h"
#include "server/core/fem/model/rest_elements.h"
#include "server/core/fem/model/vertex_masses.h"
#include "server/core/linear/vertex_field.h"
#include "tests/fem/integrator_cases.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

using mesh::TriangleId;
using mesh::VertexId;

RestElements elements_of(const mesh::TriangleMesh& mesh, const Material& material) {
  RestElements elements({&material, 1}, MembraneLaw::kCorotational);
  std::vector<TriangleId> all;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) all.push_back(t);
  elements.follow(mesh, all);
  return elements;
}

TEST(RestElements, HaveTheAreaTheHeightsAndTheIncidenceOfTheMesh) {
  constexpr int kSide = 5;
  const mesh::TriangleMesh mesh = square_grid(kSide);
  const RestElements elements = elements_of(mesh, orthotropic_cloth());
  EXPECT_NEAR(elements.area(), 1.0, 1e-14);
  EXPECT_EQ(elements.num_vertices(), kSide * kSide);
  EXPECT_EQ(elements.touched().size(), static_cast<std::size_t>(kSide * kSide));
  const double height = std::sqrt(0.5) / (kSide - 1);  // over the diagonal of a cell
  EXPECT_NEAR(elements.largest_gradient(), 1.0 / height, 1e-12 / height);
  const VertexId middle = kSide * kSide / 2;
  ASSERT_EQ(elements.incident_slots().row(middle).size(), 6U);
  for (const TriangleId slot : elements.incident_slots().row(middle)) {
    const std::array<VertexId, 3> corners = elements.corners(slot);
    EXPECT_TRUE(elements.has_material(slot));
    EXPECT_EQ(std::count(corners.begin(), corners.end(), middle), 1);
  }
}

TEST(RestElements, ChangeOnlyWhereTheyAreRewritten) {
  const mesh::TriangleMesh mesh = square_grid(5);
  RestElements elements = elements_of(mesh, soft_cloth());
  const TriangleId slot = elements.incident_slots().row(12).front();
  elements.follow(mesh, std::vector<TriangleId>{slot});
  EXPECT_EQ(elements.touched().size(), 3U);
  ASSERT_EQ(elements.changed_slots().size(), 1U);
  EXPECT_EQ(elements.changed_slots()[0], slot);
  EXPECT_EQ(elements.incident_slots().row(12).size(), 6U);
}

TEST(VertexMasses, AreAThirdOfEachTriangle) {
  const mesh::TriangleMesh mesh = square_grid(4);
  Material material = soft_cloth();
  material.mass_damping = 0.7;
  const RestElements elements = elements_of(mesh, material);
  VertexMasses masses;
  const MassChange change = masses.follow({mesh, elements});
  EXPECT_EQ(change.vertices.size(), 16U);
  EXPECT_NEAR(masses.total(), material.density * material.thickness, 1e-14);
  const double triangle = masses.total() / 18.0;
  EXPECT_NEAR(masses.mass()[5], 2.0 * triangle, 1e-15) << "six triangles around an inner vertex";
  EXPECT_EQ(masses.inverse()[5], 1.0 / masses.mass()[5]);
  EXPECT_EQ(masses.damping(5), 0.7);
  EXPECT_EQ(masses.built_extent(), 1.0);
}

TEST(BendingOperator, OpposesCurvatureOnlyAndIsTheGradientOfItsEnergy) {
  const mesh::TriangleMesh mesh = jittered_square(7);
  const RestElements elements = elements_of(mesh, orthotropic_cloth());
  BendingOperator bending;
  std::vector<TriangleId> all;
  for (TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) all.push_back(t);
  bending.follow({mesh, elements}, all);

  SeededRandom random(3);
  const Eigen::Index n = mesh.num_vertices();
  const linear::VertexField bent = random_field(random, n, 0.1);
  linear::VertexField force(n);
  force.setZero();
  bending.add_forces(elements.blocks(), bent, force);
  const double energy = bending.energy(elements.blocks(), bent);
  EXPECT_GT(energy, 0.0);
  EXPECT_NEAR(-0.5 * force.cwiseProduct(bent).sum(), energy, 1e-11 * energy) << "a quadratic form";
  EXPECT_LT(force.rowwise().sum().norm(), 1e-11 * force.norm()) << "without resultant";

  linear::VertexField flat = rest_state(mesh).x;
  flat = random_rotation(random) * flat;
  linear::VertexField none(n);
  none.setZero();
  bending.add_forces(elements.blocks(), flat, none);
  EXPECT_THAT(none, test::MatrixNear(Eigen::Matrix3Xd::Zero(3, n), 1e-11 * force.norm()));
}

TEST(BendingOperator, IsEmptyWithoutBending) {
  const mesh::TriangleMesh mesh = square_grid(4);
  const RestElements elements = elements_of(mesh, without_bending(soft_cloth()));
  BendingOperator bending;
  bending.follow({mesh, elements}, elements.changed_slots());
  EXPECT_EQ(bending.rows().num_rows(), 0);
  EXPECT_TRUE(bending.changed_rows().empty());
  EXPECT_FALSE(bending.set_clamps({mesh, elements}, BorderClamps(std::vector<Clamp>{Clamp{}})));
  EXPECT_EQ(bending.energy(elements.blocks(), rest_state(mesh).x), 0.0);
}

}  // namespace
}  // namespace kerf::fem
