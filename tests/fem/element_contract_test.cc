// The contract of the elements: both membrane laws and both kinds of bending. They are tried on every mesh of the zoo
// and on meshes that were just cut, in all kinds of states.
// - The energy is that of the definition, forces are minus its gradient and stiffness its second derivative (see
//   element_reference.h). element_test.cc compares differences, which need a mesh without slivers.
// - There is no force at rest, no resultant and no torque.
// - Rigid motion changes nothing, and all numbers are finite.
#include <algorithm>
#include <memory>
#include <tuple>
#include <vector>

#include <Eigen/Eigenvalues>

#include "server/core/cut/cut.h"
#include "tests/fem/element_reference.h"
#include "tests/fem/elements.h"
#include "tests/fem/fixture.h"
#include "tests/support/cut_patterns.h"
#include "tests/support/meshes.h"
#include "tests/support/trials.h"

namespace kerf::fem {
namespace {

// Roundings that add up in a number, see element_reference.h; 14 are the most that were seen.
constexpr double kRoundings = 32.0;
constexpr double kRounding = 0x1p-53;

struct TestedElement {
  const char* name;
  std::function<std::unique_ptr<Element>(const mesh::TriangleMesh& mesh)> make;
  Reference (*reference)(const Model& model, const linear::VertexField& x, double moved);
};
void PrintTo(const TestedElement& tested, std::ostream* out) {
  *out << tested.name;
}

std::vector<TestedElement> tested_elements() {
  const auto membrane = [](const Material& material, MembraneLaw law) {
    return [material, law](const mesh::TriangleMesh& mesh) -> std::unique_ptr<Element> {
      return std::make_unique<MembraneElement>(mesh, material, law);
    };
  };
  const auto bending = [](const Material& material) {
    return [material](const mesh::TriangleMesh& mesh) -> std::unique_ptr<Element> {
      return std::make_unique<BendingElement>(mesh, material);
    };
  };
  const auto angles = [](const Material& material) {
    return [material](const mesh::TriangleMesh& mesh) -> std::unique_ptr<Element> {
      return std::make_unique<AngleBendingElement>(mesh, material);
    };
  };
  const Material uniform = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  const Material wool = find_preset("wool").value();
  return {
      {"Isotropic", membrane(uniform, MembraneLaw::kCorotational), membrane_reference},
      {"Orthotropic", membrane(orthotropic_cloth(), MembraneLaw::kCorotational), membrane_reference},
      {"Wool", membrane(wool, MembraneLaw::kCorotational), membrane_reference},
      {"IsotropicGreen", membrane(uniform, MembraneLaw::kGreen), membrane_reference},
      {"OrthotropicGreen", membrane(orthotropic_cloth(), MembraneLaw::kGreen), membrane_reference},
      {"WoolGreen", membrane(wool, MembraneLaw::kGreen), membrane_reference},
      {"IsotropicBending", bending(uniform), bending_reference},
      {"OrthotropicBending", bending(orthotropic_cloth()), bending_reference},
      {"IsotropicAngles", angles(uniform), angle_reference},
      {"OrthotropicAngles", angles(orthotropic_cloth()), angle_reference},
  };
}

struct TestedMesh {
  std::string name;
  mesh::TriangleMesh mesh;
};
void PrintTo(const TestedMesh& tested, std::ostream* out) {
  *out << tested.name;
}

mesh::TriangleMesh after_cuts(mesh::TriangleMesh mesh, const std::vector<cut::Curve>& curves) {
  for (const cut::Curve& curve : curves) {
    const auto plan = cut::plan(mesh, {curve, {}, {}});
    EXPECT_TRUE(plan.ok());
    const auto outcome = cut::apply(mesh, *plan);
    EXPECT_TRUE(outcome.ok() && outcome->status == cut::CutStatus::kApplied);
  }
  return mesh;
}

std::vector<TestedMesh> tested_meshes() {
  constexpr int kSide = 6;
  std::vector<TestedMesh> meshes;
  for (const test::ZooMesh& each : test::zoo())
    meshes.push_back({each.name, test::must(mesh::import_mesh(each.sheet))});
  meshes.push_back({"grid", square_grid(kSide)});
  meshes.push_back({"jittered", jittered_square(kSide)});
  meshes.push_back({"union jack", test::union_jack(kSide)});
  meshes.push_back({"kirigami slits", after_cuts(square_grid(kSide), test::kirigami(2, 2))});
  for (const test::CutPattern& pattern : test::cut_patterns(1.0 / (kSide - 1))) {
    for (const char* name : {"punch r = 0.6 h", "X of two cuts", "border to inside", "star of 7 arms"}) {
      if (pattern.name == name)
        meshes.push_back({"cut: " + pattern.name, after_cuts(jittered_square(kSide), pattern.curves)});
    }
  }
  return meshes;
}

// m, length V: the least height of the triangles at each vertex.
Eigen::VectorXd least_heights(const mesh::TriangleMesh& mesh) {
  Eigen::VectorXd least = Eigen::VectorXd::Constant(mesh.num_vertices(), std::numeric_limits<double>::max());
  for (mesh::TriangleId slot = 0; slot < mesh.num_triangle_slots(); ++slot) {
    if (!mesh.is_solid(slot)) continue;
    const std::array<mesh::VertexId, 3> corner = mesh.vertices(slot);
    const Eigen::Vector2d e1 = mesh.rest_position(corner[1]) - mesh.rest_position(corner[0]);
    const Eigen::Vector2d e2 = mesh.rest_position(corner[2]) - mesh.rest_position(corner[0]);
    const double longest = std::max({e1.norm(), e2.norm(), (e2 - e1).norm()});
    const double height = std::abs(e1.x() * e2.y() - e1.y() * e2.x()) / longest;
    for (const mesh::VertexId v : corner) least[v] = std::min(least[v], height);
  }
  return least;
}

struct Shape {
  const char* name;
  linear::VertexField x;
  bool keeps_areas = true;  // no triangle and no edge has less than kLeastArea of its size
};

class ElementContractOnMeshes : public testing::TestWithParam<std::tuple<TestedElement, TestedMesh>> {
 protected:
  ElementContractOnMeshes() : rest_(rest_state(mesh()).x), heights_(least_heights(mesh())) {}

  static const TestedElement& tested() { return std::get<0>(GetParam()); }
  static const mesh::TriangleMesh& mesh() { return std::get<1>(GetParam()).mesh; }

  static bool bends_by_angles(const Element& element) { return element.model.bending().angles() != nullptr; }

  // Returns the rest positions, displaced by up to `share` of the least height at each vertex.
  linear::VertexField jittered(double share) {
    return rest_ + random_field(random_, rest_.cols(), share) * heights_.asDiagonal();
  }
  linear::VertexField turned(const linear::VertexField& x) {
    return (random_rotation(random_) * x).colwise() + random_vector(random_, 2.0);
  }
  // Folds the left `share` of the width over the rest.
  static linear::VertexField folded(linear::VertexField x, double share) {
    const double least = x.row(0).minCoeff();
    const double edge = least + share * (x.row(0).maxCoeff() - least);
    x.row(0) = (x.row(0).array() - edge).abs();
    return x;
  }

  // All but collapsed ones.
  std::vector<Shape> shapes() {
    constexpr double kSmall = 0.05;
    const auto scaled = [&](double x, double y) {
      return turned(Eigen::Vector3d(x, y, 1.0).asDiagonal() * jittered(kSmall));
    };
    const auto sheared = [&] {
      linear::VertexField x = jittered(kSmall);
      x.row(0) += 3.0 * x.row(1);
      return turned(x);
    };
    const auto inverted = [&] {
      linear::VertexField x = jittered(kSmall);
      x.col(0).head<2>() = 2.0 * rest_.rowwise().mean().head<2>() - x.col(0).head<2>();
      return turned(x);
    };
    return {
        {"near rest", turned(jittered(kSmall))},
        {"stretched 5 times", scaled(5.0, 5.0)},
        {"stretched 20 times in one direction", scaled(20.0, 1.0)},
        {"sheared 3 times", sheared()},
        {"mirrored", scaled(-1.0, 1.0)},
        {"a vertex pulled across the sheet", inverted(), false},
        {"at random", turned(rest_ + random_field(random_, rest_.cols(), 1.0)), false},
        {"folded flat", turned(folded(jittered(kSmall), 0.4)), false},
        {"squashed to 0.01", scaled(1.0, 0.01), false},
        {"squashed to 1e-4", scaled(1e-4, 1.0), false},
        {"shrunk to 1e-6", turned(1e-6 * jittered(kSmall)), false},
        {"1e6 times as large", turned(1e6 * jittered(kSmall))},
    };
  }

  // Some triangles at least are a line or a point, to rounding.
  std::vector<Shape> collapsed_shapes() {
    const Eigen::Index n = rest_.cols();
    const linear::VertexField line = Eigen::Vector3d(1.0, 2.0, -0.5) * rest_.row(0);
    linear::VertexField coincident = rest_;
    coincident.col(1) = coincident.col(0);
    return {
        {"a point", Eigen::Matrix3Xd::Zero(3, n)},
        {"another point", Eigen::Matrix3Xd::Constant(3, n, 7.25)},
        {"a line", line},
        {"a line elsewhere", turned(line)},
        {"a short line", Eigen::Vector3d(0.0, 0.0, 1e-9) * (rest_.row(0) + rest_.row(1))},
        {"nearly a line", Eigen::Vector3d(1.0, 1e-14, 1.0).asDiagonal() * rest_},
        {"shrunk to 1e-200", 1e-200 * rest_},
        {"two vertices in one place", turned(coincident)},
        {"folded in the middle", folded(rest_, 0.5)},
    };
  }

  // Energy, forces and stiffness at x.
  void expect_derivatives(const Element& element, const linear::VertexField& x) {
    const Reference reference = tested().reference(element.model, x, 0.0);
    EXPECT_NEAR(element.energy(x), static_cast<double>(reference.energy), kRoundings * reference.energy_noise);
    const linear::VertexField f = element.forces(x);
    const Eigen::MatrixXd K = element.stiffness(x, false);
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
      EXPECT_LE(f.col(i).norm(), reference.force_bound[i]) << i;
      if (!reference.is_smooth[static_cast<std::size_t>(i)]) continue;
      const double force_off = (f.col(i) - reference.forces.col(i)).norm();
      EXPECT_LE(force_off, kRoundings * reference.force_noise[i]) << i;
      for (Eigen::Index j = 0; j < x.cols(); ++j) {
        if (!reference.is_smooth[static_cast<std::size_t>(j)]) continue;
        const double K_off = (K - reference.stiffness).block<3, 3>(3 * i, 3 * j).norm();
        EXPECT_LE(K_off, kRoundings * reference.stiffness_noise(i, j)) << i << " " << j;
        const double skew = (K.block<3, 3>(3 * i, 3 * j) - K.block<3, 3>(3 * j, 3 * i).transpose()).norm();
        EXPECT_LE(skew, kRoundings * reference.stiffness_noise(i, j)) << i << " " << j;
      }
    }
  }
  // No resultant and no torque; noise: N, length V.
  static void expect_balance(const linear::VertexField& f, const linear::VertexField& x, const Eigen::VectorXd& noise) {
    const Eigen::Vector3d centre = x.rowwise().mean();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    double torque_noise = 0.0;
    for (Eigen::Index i = 0; i < f.cols(); ++i) {
      const Eigen::Vector3d arm = x.col(i) - centre;
      torque += arm.cross(f.col(i));
      torque_noise += arm.norm() * noise[i];
    }
    EXPECT_LE(f.rowwise().sum().norm(), kRoundings * noise.sum());
    EXPECT_LE(torque.norm(), kRoundings * torque_noise);
  }

  linear::VertexField rest_;
  Eigen::VectorXd heights_;
  SeededRandom random_{7};
};

TEST_P(ElementContractOnMeshes, ForceAndStiffnessAreTheDerivativesOfTheEnergy) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    expect_derivatives(*element, shape.x);
    if (bends_by_angles(*element) && !shape.keeps_areas) continue;  // smooth is what has not collapsed
    const std::vector<bool> is_smooth = tested().reference(element->model, shape.x, 0.0).is_smooth;
    EXPECT_TRUE(std::all_of(is_smooth.begin(), is_smooth.end(), [](bool each) { return each; }));
  }
}

// The co-rotational law and angles have no derivative there, but the others have. Nothing may be infinite, or larger
// than the stress there can be.
TEST_P(ElementContractOnMeshes, CollapsedTrianglesStayFiniteAndBounded) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  for (const Shape& shape : collapsed_shapes()) {
    SCOPED_TRACE(shape.name);
    expect_derivatives(*element, shape.x);
    EXPECT_TRUE(element->stiffness(shape.x, false).allFinite());
    EXPECT_TRUE(element->stiffness(shape.x, true).allFinite());
  }
}

TEST_P(ElementContractOnMeshes, ExertsNoForceAtRestAnywhere) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  for (int trial = 0; trial < 3; ++trial) {
    const linear::VertexField x = trial == 0 ? rest_ : turned(rest_);
    const double moved = 4.0 * kRounding * x.cwiseAbs().maxCoeff();
    const Reference reference = tested().reference(element->model, x, moved);
    EXPECT_LE(std::abs(element->energy(x)), kRoundings * reference.energy_noise);
    const linear::VertexField f = element->forces(x);
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
      EXPECT_LE(f.col(i).norm(), kRoundings * reference.force_noise[i]) << i;
    }
  }
}

TEST_P(ElementContractOnMeshes, RigidMotionTurnsForcesAndKeepsEnergy) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    const Eigen::Matrix3d R = random_rotation(random_);
    const linear::VertexField moved = (R * shape.x).colwise() + Eigen::Vector3d(1.0, 2.0, 3.0);
    const double rounded = 4.0 * kRounding * (shape.x.cwiseAbs().maxCoeff() + moved.cwiseAbs().maxCoeff());
    const Reference reference = tested().reference(element->model, shape.x, rounded);
    EXPECT_LE(std::abs(element->energy(moved) - element->energy(shape.x)), kRoundings * reference.energy_noise);
    const linear::VertexField off = element->forces(moved) - R * element->forces(shape.x);
    for (Eigen::Index i = 0; i < off.cols(); ++i) {
      if (!reference.is_smooth[static_cast<std::size_t>(i)]) continue;
      EXPECT_LE(off.col(i).norm(), kRoundings * reference.force_noise[i]) << i;
    }
  }
}

TEST_P(ElementContractOnMeshes, ForcesHaveNoResultantAndNoTorque) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    expect_balance(element->forces(shape.x), shape.x, tested().reference(element->model, shape.x, 0.0).force_noise);
  }
}

// Nor where the derivatives of angles are not those of the energy: a sheet that nothing holds would begin to turn.
TEST_P(ElementContractOnMeshes, ForcesOfAnglesBalanceWhereTrianglesHaveCollapsed) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  if (!bends_by_angles(*element)) return;
  std::vector<Shape> all = shapes();
  for (Shape& shape : collapsed_shapes()) all.push_back(std::move(shape));
  for (const Shape& shape : all) {
    SCOPED_TRACE(shape.name);
    expect_balance(element->forces(shape.x), shape.x, tested().reference(element->model, shape.x, 0.0).balance_noise);
  }
}

// Holds for each triangle, and so for their sum.
TEST_P(ElementContractOnMeshes, ProjectedStiffnessIsPositiveSemidefinite) {
  const std::unique_ptr<Element> element = tested().make(mesh());
  const auto expect_positive = [](const Eigen::MatrixXd& K, double terms) {
    const Eigen::MatrixXd symmetric = 0.5 * (K + K.transpose());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric, Eigen::EigenvaluesOnly);
    EXPECT_GE(eigen.eigenvalues().minCoeff(), -kRoundings * kRounding * (terms + K.cwiseAbs().maxCoeff()));
  };
  const auto* const membrane = dynamic_cast<const MembraneElement*>(element.get());
  if (membrane == nullptr && !bends_by_angles(*element)) {  // the same at any x
    const Reference reference = tested().reference(element->model, rest_, 0.0);
    expect_positive(element->stiffness(rest_, true), reference.stiffness_noise.sum() / kRounding);
    return;
  }
  std::vector<Shape> all = shapes();
  for (Shape& shape : collapsed_shapes()) all.push_back(std::move(shape));
  for (const Shape& shape : all) {
    SCOPED_TRACE(shape.name);
    if (membrane == nullptr) {
      const Eigen::MatrixXd K = element->stiffness(shape.x, true);
      expect_positive(K, K.cwiseAbs().sum());
      continue;
    }
    membrane->for_triangles(shape.x, true, [&](const ElementBlock& block, std::size_t lane, const ElementMatrix& K) {
      expect_positive(K, stiffness_terms(block, lane, membrane->model.materials(), shape.x));
    });
  }
}

// Every element on every mesh; every seventh pair under sanitizers, which take twenty times as long.
std::vector<std::tuple<TestedElement, TestedMesh>> pairs() {
  const auto stride = static_cast<std::size_t>(test::num_trials({.few = 7, .usual = 1, .many = 1}));
  std::vector<std::tuple<TestedElement, TestedMesh>> pairs;
  std::size_t number = 0;
  for (const TestedElement& element : tested_elements()) {
    for (const TestedMesh& mesh : tested_meshes()) {
      if (number++ % stride == 0) pairs.emplace_back(element, mesh);
    }
  }
  return pairs;
}

INSTANTIATE_TEST_SUITE_P(All, ElementContractOnMeshes, testing::ValuesIn(pairs()));

}  // namespace
}  // namespace kerf::fem
