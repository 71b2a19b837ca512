// Tests bending moments at the edges between patches.
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "server/core/cut/cut.h"
#include "server/core/fem/element/bending_forces.h"
#include "tests/fem/fixture.h"
#include "tests/support/meshes.h"

namespace kerf::fem {
namespace {

struct Sheet {
  const char* name;
  mesh::TriangleMesh mesh;
};

mesh::TriangleMesh slit_square() {
  mesh::TriangleMesh mesh = square_grid(20);
  const auto plan = cut::plan(mesh, {cut::Polyline{{{0.31, 0.28}, {0.72, 0.61}}}, {}, {}});
  EXPECT_TRUE(plan.ok() && cut::apply(mesh, *plan).ok());
  return mesh;
}

std::vector<Sheet> irregular_sheets() {
  std::vector<Sheet> sheets;
  sheets.push_back({"jittered", jittered_square(20)});
  sheets.push_back({"union jack", test::union_jack(20)});
  sheets.push_back({"slit", slit_square()});
  return sheets;
}

// Shortest distance, in edges, from each vertex to the border.
std::vector<int> rings_from_border(const mesh::TriangleMesh& mesh) {
  std::vector<int> ring(static_cast<std::size_t>(mesh.num_vertices()), std::numeric_limits<int>::max());
  const auto at = [&](mesh::VertexId v) -> int& { return ring[static_cast<std::size_t>(v)]; };
  for (mesh::TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
    for (int k = 0; mesh.is_solid(slot) && k < 3; ++k) {
      if (mesh.neighbour(slot, k) != mesh::kNone) continue;
      at(mesh.vertices(slot)[(static_cast<std::size_t>(k) + 1) % 3]) = 0;
      at(mesh.vertices(slot)[(static_cast<std::size_t>(k) + 2) % 3]) = 0;
    }
  }
  for (int round = 0; round < 4; ++round) {
    for (mesh::TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
      if (!mesh.is_solid(slot)) continue;
      for (const mesh::VertexId v : mesh.vertices(slot)) {
        for (const mesh::VertexId u : mesh.vertices(slot)) at(v) = std::min(at(v), at(u) < 4 ? at(u) + 1 : at(v));
      }
    }
  }
  return ring;
}

// The fit alone would leave forces of a hundredth of the stiffness times the deflection.
TEST(BendingEdges, ConstantMomentsAreInBalanceInside) {
  for (const Sheet& sheet : irregular_sheets()) {
    const Model model(sheet.mesh, orthotropic_cloth());
    EXPECT_GT(model.bending().edges().num_entries(), 0U) << sheet.name;
    const std::vector<int> ring = rings_from_border(sheet.mesh);
    for (int form = 0; form < 3; ++form) {
      linear::VertexField x = rest_state(sheet.mesh).x;
      for (Eigen::Index v = 0; v < x.cols(); ++v) {
        const Eigen::Vector3d terms(x(0, v) * x(0, v), x(1, v) * x(1, v), x(0, v) * x(1, v));
        x(2, v) = terms[form];
      }
      linear::VertexField f = Eigen::Matrix3Xd::Zero(3, x.cols());
      add_bending_forces(model.bending().rows(), x, f);
      int num_inside = 0;
      double largest = 0.0;
      for (Eigen::Index v = 0; v < x.cols(); ++v) {
        if (ring[static_cast<std::size_t>(v)] < 4) continue;
        ++num_inside;
        largest = std::max(largest, f.col(v).norm());
      }
      EXPECT_GT(num_inside, 50) << sheet.name;
      EXPECT_LT(largest, 1e-9 * f.cwiseAbs().maxCoeff()) << sheet.name << ", form " << form;
    }
  }
}

TEST(BendingEdges, NeverMakeTheEnergyNegativeNorAnyShapeFree) {
  std::vector<Sheet> sheets;
  sheets.push_back({"jittered", jittered_square(9)});
  sheets.push_back({"union jack", test::union_jack(9)});
  sheets.push_back({"uniform", square_grid(9)});
  sheets.push_back({"fan", test::must(mesh::import_mesh(test::fan()))});
  sheets.push_back({"slivers", test::must(mesh::import_mesh(test::slivers()))});
  sheets.push_back({"two regions", test::must(mesh::import_mesh(test::two_regions()))});
  for (const Sheet& sheet : sheets) {
    const Model model(sheet.mesh, orthotropic_cloth());
    const int n = model.num_vertices();
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      for (const BendingEntry& entry : model.bending().rows().row(i)) Q(i, entry.column) = entry.value;
    }
    EXPECT_EQ(Q, Q.transpose()) << sheet.name;
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Q).eigenvalues();
    const double largest = values[n - 1];
    EXPECT_GT(values[0], -1e-12 * largest) << sheet.name;
    EXPECT_LT(values[2], 1e-12 * largest) << sheet.name << ": translation and two tilts";
    if (n > 50) {
      EXPECT_GT(values[3], 1e-7 * largest) << sheet.name;
    }
  }
}

TEST(BendingEdges, AreNotThereInsideWhereDiagonalsAreParallel) {
  const mesh::TriangleMesh mesh = square_grid(20);
  const Model model(mesh, orthotropic_cloth());
  const std::vector<int> ring = rings_from_border(mesh);
  for (int slot = 0; slot < model.bending().edges().num_rows(); ++slot) {
    for (const BendingEdge& edge : model.bending().edges().row(slot)) {
      bool near_border = false;
      for (const mesh::VertexId v : edge.vertex)
        near_border |= v != mesh::kNone && ring[static_cast<std::size_t>(v)] == 0;
      EXPECT_TRUE(near_border) << slot;
    }
  }
  for (int v = 0; v < model.num_vertices(); ++v) {
    if (ring[static_cast<std::size_t>(v)] >= 4) {
      EXPECT_EQ(model.bending().rows().row(v).size(), 19U) << v;
    }
  }
}

// A flat sheet whose border is held at the slopes that it has is at rest; tilted, it is pulled back by forces that are
// the derivative of the energy.
TEST(BendingEdges, TakeTheSlopesThatClampsHold) {
  const mesh::TriangleMesh mesh = jittered_square(9);
  Model model(mesh, orthotropic_cloth());
  linear::VertexField x = rest_state(mesh).x;
  std::vector<Clamp> clamps;
  for (int v = 0; v < mesh.num_vertices(); ++v) {
    if (mesh.rest_position(v).x() < 0.5) clamps.push_back({v, Eigen::Matrix<double, 3, 2>::Identity()});
  }
  model.set_clamps(mesh, clamps);
  const auto energy = [&](const linear::VertexField& at) {
    return bending_energy(model.bending().rows(), at) + clamp_energy(model.bending().clamp_forces(), at);
  };
  const auto forces = [&](const linear::VertexField& at) {
    linear::VertexField f = Eigen::Matrix3Xd::Zero(3, at.cols());
    add_bending_forces(model.bending().rows(), at, f);
    add_clamp_forces(model.bending().clamp_forces(), f);
    return f;
  };
  SeededRandom random(5);
  const linear::VertexField direction = random_field(random, x.cols(), 1.0);
  const linear::VertexField bent = x + 0.1 * direction;
  const double scale = forces(bent).cwiseAbs().maxCoeff();
  EXPECT_LT(forces(x).cwiseAbs().maxCoeff(), 1e-11 * scale);
  EXPECT_LT(std::abs(energy(x)), 1e-11 * energy(bent));
  constexpr double kStep = 1e-3;  // the energy is quadratic: the difference is exact
  const double slope = (energy(bent + kStep * direction) - energy(bent - kStep * direction)) / (2.0 * kStep);
  EXPECT_NEAR(-forces(bent).cwiseProduct(direction).sum(), slope, 1e-9 * std::abs(slope));
}

// Three triangles around one inner vertex: each patch has the same vertex twice.
TEST(BendingEdges, AroundAVertexOfThreeTrianglesAreSymmetric) {
  const mesh::IndexedMesh sheet =
      test::indexed({{0, 0}, {1, 0}, {0.4, 1}, {0.45, 0.35}}, {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  const Model model(mesh::import_mesh(sheet).value(), orthotropic_cloth());
  EXPECT_EQ(model.bending().edges().num_entries(), 3U);
  linear::VertexField x(4);
  x << 0, 1, 0.4, 0.45, 0, 0, 1, 0.35, 0, 0, 0, 0.1;
  linear::VertexField f = Eigen::Matrix3Xd::Zero(3, 4);
  add_bending_forces(model.bending().rows(), x, f);
  EXPECT_LT(f.rowwise().sum().norm(), 1e-14 * f.norm());
  EXPECT_GT(bending_energy(model.bending().rows(), x), 0.0);
}

}  // namespace
}  // namespace kerf::fem
