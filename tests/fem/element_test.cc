// The contract of every element, on one mesh; element_contract_test.cc has all meshes, and all states. Force = -dE/dx
// and stiffness = -df/dx by finite differences. Forces at rest are zero, rigid motion changes nothing, no shape leads
// to NaN. Stiffness is symmetric, and positive semidefinite where promised.
#include <functional>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include "server/core/fem/element/bending_lanes.h"
#include "tests/fem/elements.h"
#include "tests/fem/fixture.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

struct Isotropic {
  static Material material() { return isotropic(1.0e6, 0.3, 1.0e-3, 300.0); }
};
struct Orthotropic {
  static Material material() { return orthotropic_cloth(); }
};
struct Wool {
  static Material material() { return find_preset("wool").value(); }
};

template <typename Of, MembraneLaw kLaw = MembraneLaw::kCorotational>
struct Membrane : MembraneElement {
  explicit Membrane(const mesh::TriangleMesh& mesh) : MembraneElement(mesh, Of::material(), kLaw) {}
};

struct Bending : BendingElement {
  explicit Bending(const mesh::TriangleMesh& mesh) : BendingElement(mesh, orthotropic_cloth()) {}
};

struct BendingByAngles : AngleBendingElement {
  explicit BendingByAngles(const mesh::TriangleMesh& mesh) : AngleBendingElement(mesh, orthotropic_cloth()) {}
};

template <typename Tested>
class ElementContract : public testing::Test {
 protected:
  static constexpr int kSide = 5;
  ElementContract() : mesh_(jittered_square(kSide)), element_(mesh_), rest_(rest_state(mesh_).x) {}

  // Rotated, moved, and every vertex displaced by up to `size` (m); edges are 0.25 m.
  linear::VertexField deformed(double size) {
    const Eigen::Matrix3d R = random_rotation(random_);
    return (R * (rest_ + random_field(random_, rest_.cols(), size))).colwise() + random_vector(random_, 2.0);
  }
  // Returns the scale of forces at strain 1, for tolerances.
  double force_scale() { return element_.forces(deformed(0.1)).cwiseAbs().maxCoeff(); }

  mesh::TriangleMesh mesh_;
  Tested element_;
  linear::VertexField rest_;
  SeededRandom random_{7};
};

using Elements = testing::Types<Membrane<Isotropic>, Membrane<Orthotropic>, Membrane<Wool>,
                                Membrane<Isotropic, MembraneLaw::kGreen>, Membrane<Orthotropic, MembraneLaw::kGreen>,
                                Membrane<Wool, MembraneLaw::kGreen>, Bending, BendingByAngles>;
TYPED_TEST_SUITE(ElementContract, Elements);

TYPED_TEST(ElementContract, ExertsNoForceAtRestAnywhere) {
  const double scale = this->force_scale();
  const Eigen::Matrix3d R = random_rotation(this->random_);
  const linear::VertexField moved = (R * this->rest_).colwise() + Eigen::Vector3d(3.0, -2.0, 1.0);
  EXPECT_LT(this->element_.forces(this->rest_).cwiseAbs().maxCoeff(), 1e-13 * scale);
  EXPECT_LT(this->element_.forces(moved).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_NEAR(this->element_.energy(moved), 0.0, 1e-13 * scale);
}

TYPED_TEST(ElementContract, RigidMotionTurnsForcesAndKeepsEnergy) {
  const linear::VertexField x = this->deformed(0.05);
  const Eigen::Matrix3d R = random_rotation(this->random_);
  const linear::VertexField moved = (R * x).colwise() + Eigen::Vector3d(1.0, 2.0, 3.0);
  const linear::VertexField f = this->element_.forces(x);
  EXPECT_NEAR(this->element_.energy(moved), this->element_.energy(x), 1e-11 * this->element_.energy(x));
  EXPECT_THAT(this->element_.forces(moved), test::MatrixNear(R * f, 1e-11 * f.cwiseAbs().maxCoeff()));
}

TYPED_TEST(ElementContract, ForceIsMinusTheGradientOfTheEnergy) {
  linear::VertexField x = this->deformed(0.05);
  const linear::VertexField f = this->element_.forces(x);
  constexpr double kStep = 1e-5;  // m
  double worst = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double keep = x.data()[i];
    // Fourth order, so that truncation stays below rounding.
    std::array<double, 4> energy{};
    const std::array<double, 4> offsets{-2.0, -1.0, 1.0, 2.0};
    for (std::size_t k = 0; k < 4; ++k) {
      x.data()[i] = keep + offsets[k] * kStep;
      energy[k] = this->element_.energy(x);
    }
    x.data()[i] = keep;
    const double slope = (energy[0] - 8.0 * energy[1] + 8.0 * energy[2] - energy[3]) / (12.0 * kStep);
    worst = std::max(worst, std::abs(slope + f.data()[i]));
  }
  EXPECT_LT(worst, 1e-7 * f.cwiseAbs().maxCoeff());
}

TYPED_TEST(ElementContract, StiffnessIsMinusTheGradientOfTheForce) {
  linear::VertexField x = this->deformed(0.05);
  const Eigen::MatrixXd K = this->element_.stiffness(x, false);
  constexpr double kStep = 1e-5;  // m
  double worst = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double keep = x.data()[i];
    std::array<linear::VertexField, 4> f;
    const std::array<double, 4> offsets{-2.0, -1.0, 1.0, 2.0};
    for (std::size_t k = 0; k < 4; ++k) {
      x.data()[i] = keep + offsets[k] * kStep;
      f[k] = this->element_.forces(x);
    }
    x.data()[i] = keep;
    const linear::VertexField slope = (f[0] - 8.0 * f[1] + 8.0 * f[2] - f[3]) / (12.0 * kStep);
    worst = std::max(worst, (slope.reshaped() + K.col(i)).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-7 * K.cwiseAbs().maxCoeff());
}

TYPED_TEST(ElementContract, StiffnessIsSymmetricAndItsProjectionPositiveSemidefinite) {
  for (const double size : {0.0, 0.02, 0.1, 0.5}) {
    const linear::VertexField x = this->deformed(size);
    const Eigen::MatrixXd K = this->element_.stiffness(x, true);
    const double scale = K.cwiseAbs().maxCoeff();
    EXPECT_THAT(K, test::MatrixNear(K.transpose(), 1e-13 * scale)) << size;
    const Eigen::MatrixXd symmetric = 0.5 * (K + K.transpose());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(symmetric, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-12 * scale) << size;
  }
}

TYPED_TEST(ElementContract, ForcesHaveNoResultantAndNoTorque) {
  const linear::VertexField x = this->deformed(0.1);
  const linear::VertexField f = this->element_.forces(x);
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < x.cols(); ++i) torque += x.col(i).cross(f.col(i));
  const double scale = f.cwiseAbs().sum();
  EXPECT_LT(f.rowwise().sum().norm(), 1e-14 * scale);
  EXPECT_LT(torque.norm(), 1e-13 * scale);
}

TYPED_TEST(ElementContract, StaysFiniteHoweverTheSheetIsCollapsed) {
  const Eigen::Index n = this->rest_.cols();
  std::vector<linear::VertexField> shapes;
  shapes.push_back(Eigen::Matrix3Xd::Zero(3, n));                                                 // a point
  shapes.push_back(Eigen::Matrix3Xd::Constant(3, n, 7.25));                                       // another
  shapes.push_back(Eigen::Vector3d(1.0, 2.0, -0.5) * this->rest_.row(0));                         // a line
  shapes.push_back(Eigen::Vector3d(0.0, 0.0, 1e-9) * (this->rest_.row(0) + this->rest_.row(1)));  // a short one
  shapes.push_back(Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal() * this->rest_);                   // mirrored
  shapes.push_back(1e-200 * this->rest_);
  shapes.push_back(1e6 * this->rest_);
  shapes.push_back(Eigen::Vector3d(1.0, 1e-14, 1.0).asDiagonal() * this->rest_);  // nearly a line
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_TRUE(std::isfinite(this->element_.energy(shapes[i]))) << i;
    EXPECT_TRUE(this->element_.forces(shapes[i]).allFinite()) << i;
    EXPECT_TRUE(this->element_.stiffness(shapes[i], true).allFinite()) << i;
  }
}

TEST(MembraneElement, PullsACollapsedLineBackAlongItself) {
  const mesh::TriangleMesh mesh = square_grid(2);
  const Membrane<Isotropic> membrane(mesh);
  // Everything on the x axis, stretched to twice its length: ends are pulled inwards as in a stretched strip.
  const linear::VertexField x = Eigen::Vector3d(2.0, 0.0, 0.0).asDiagonal() * rest_state(mesh).x;
  const linear::VertexField f = membrane.forces(x);
  EXPECT_GT(f(0, 0) + f(0, 2), 100.0);  // vertices 0 and 2 lie at x = 0
  EXPECT_LT(f(0, 1) + f(0, 3), -100.0);
}

TEST(MembraneElement, MirroredTriangleIsUnstrained) {
  const mesh::TriangleMesh mesh = jittered_square(4);
  const Membrane<Orthotropic> membrane(mesh);
  const linear::VertexField x = Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal() * rest_state(mesh).x;
  EXPECT_LT(membrane.energy(x), 1e-20);
}

TEST(MembraneElement, UniaxialStretchGivesTheEngineeringConstants) {
  // Stretch l along axis 1 and 1 - nu12 (l - 1) along axis 2: sigma1 = E1 t (l - 1), sigma2 = 0, at any l.
  Material material = orthotropic_cloth();
  material.direction = 0.0;
  const mesh::TriangleMesh mesh = square_grid(3);
  const Model model(mesh, material);
  constexpr double kStrain = 0.3;
  const Eigen::Vector3d stretch(1.0 + kStrain, 1.0 - material.poissons_ratio_12 * kStrain, 1.0);
  const linear::VertexField x = stretch.asDiagonal() * rest_state(mesh).x;
  const double energy = membrane_energy(model.element_blocks(), model.materials(), x);
  EXPECT_NEAR(energy, 0.5 * material.youngs_modulus_1 * material.thickness * kStrain * kStrain, 1e-9);
  linear::VertexField f(x.cols());
  model.internal_forces(x, f);
  double pull = 0.0;
  for (int j = 0; j < 3; ++j) pull += f(0, 3 * j);
  EXPECT_NEAR(pull, material.youngs_modulus_1 * material.thickness * kStrain, 1e-9);
  EXPECT_LT(f.row(1).cwiseAbs().maxCoeff(), 1e-9);
}

// F = [1 e; e 1] in axes at `direction` to the material's: no rotation, so e11 = e22 = 0 and shear 2 e at any e, whose
// modulus `expected` (Pa) is.
void expect_shear_modulus(Material material, double direction, double expected) {
  material.direction = direction;
  material.bending_scale = 0.0;
  const mesh::TriangleMesh mesh = jittered_square(4);
  const Model model(mesh, material);
  for (const double e : {1e-4, 0.1}) {
    const Eigen::Matrix3d F{{1.0, e, 0.0}, {e, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    const linear::VertexField x = F * rest_state(mesh).x;
    const double shear_force = expected * material.thickness * 2.0 * e;  // N, on each side of 1 m
    const double energy = membrane_energy(model.element_blocks(), model.materials(), x);
    EXPECT_NEAR(energy, 0.5 * shear_force * 2.0 * e, 1e-9 * shear_force * e);
    linear::VertexField f(x.cols());
    model.internal_forces(x, f);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      const bool is_inside = (mesh.rest_position(i).array() > 0.0).all() && (mesh.rest_position(i).array() < 1.0).all();
      if (is_inside) {
        EXPECT_LT(f.col(i).norm(), 1e-9 * shear_force) << "uniform stress is in balance";
      }
      if (mesh.rest_position(i).x() == 1.0) right -= f.col(i);
    }
    EXPECT_NEAR(right.x(), 0.0, 1e-9 * shear_force);  // its corners' shares of the other sides cancel
    EXPECT_NEAR(right.y(), shear_force, 1e-9 * shear_force);
  }
}

TEST(MembraneElement, PureShearAlongTheAxesFeelsTheIndependentShearModulusAlone) {
  Material material = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  for (const double factor : {0.02, 1.0, 3.0}) {
    material.shear_modulus = factor * 1.0e6;
    expect_shear_modulus(material, 0.0, material.shear_modulus);
  }
  expect_shear_modulus(orthotropic_cloth(), 0.0, orthotropic_cloth().shear_modulus);
}

TEST(MembraneElement, PureShearAcrossTheAxesFeelsEverythingButTheShearModulus) {
  Material material = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  material.shear_modulus = 2.0e4;
  expect_shear_modulus(material, 0.25 * std::numbers::pi, 1.0e6 / (2.0 * 1.3));
}

TEST(MembraneDamping, NeverAddsEnergyAndIgnoresRigidMotion) {
  const mesh::TriangleMesh mesh = jittered_square(5);
  const std::array<Model, 2> models{Model(mesh, orthotropic_cloth()),
                                    Model(mesh, orthotropic_cloth(), MembraneLaw::kGreen)};
  const std::array<double, 1> beta{1e-2};
  SeededRandom random(3);
  const linear::VertexField zero = Eigen::Matrix3Xd::Zero(3, mesh.num_vertices());
  for (std::size_t trial = 0; trial < 40; ++trial) {
    const Model& model = models[trial % 2];
    const linear::VertexField x = rest_state(mesh).x + random_field(random, zero.cols(), 0.1);
    const linear::VertexField v = random_field(random, zero.cols(), 1.0);
    const auto damping = [&](const linear::VertexField& velocity) {
      linear::VertexField f = zero;
      linear::VertexField elastic = zero;
      add_membrane_forces(model.element_blocks(), model.materials(), beta, x, velocity, f);
      add_membrane_forces(model.element_blocks(), model.materials(), {}, x, velocity, elastic);
      return linear::VertexField(f - elastic);
    };
    const linear::VertexField f = damping(v);
    EXPECT_LT(f.cwiseProduct(v).sum(), 0.0);
    const Eigen::Vector3d omega = random_vector(random, 1.0);
    linear::VertexField rigid(x.cols());
    for (Eigen::Index i = 0; i < x.cols(); ++i) rigid.col(i) = omega.cross(x.col(i)) + Eigen::Vector3d(1.0, 2.0, 3.0);
    EXPECT_LT(damping(rigid).cwiseAbs().maxCoeff(), 1e-12 * f.cwiseAbs().maxCoeff());
  }
}

// A cylinder of radius r has curvature 1/r: E = D / (2 r^2) an area, whatever the direction of its axis.
TEST(BendingElement, CylinderHasThePlateEnergyInEveryDirection) {
  const Material material = isotropic(1.0e6, 0.3, 1.0e-3, 300.0);
  const double D = bending_law(material)(0, 0);
  constexpr double kRadius = 2.0;  // m
  for (const bool jittered : {false, true}) {
    const mesh::TriangleMesh mesh = jittered ? jittered_square(40) : square_grid(40);
    const Model model(mesh, material);
    for (const double angle : {0.0, 0.5235987755982988, 0.7853981633974483}) {
      linear::VertexField x(mesh.num_vertices());
      for (int i = 0; i < mesh.num_vertices(); ++i) {
        const Eigen::Vector2d X = mesh.rest_position(i);
        const double across = X.x() * std::cos(angle) + X.y() * std::sin(angle);
        const double along = -X.x() * std::sin(angle) + X.y() * std::cos(angle);
        x.col(i) << kRadius * std::sin(across / kRadius), along, kRadius * (1.0 - std::cos(across / kRadius));
      }
      const double energy = bending_energy(model.bending().rows(), x);
      // The strip along the free edges has no neighbours to bend against: 3 % at this size, known and one-sided.
      EXPECT_NEAR(energy * 2.0 * kRadius * kRadius / D, 0.97, 0.015) << jittered << " " << angle;
    }
  }
}

std::array<double, 21> stiffness_of(const PatchGeometry& patch, const Eigen::Matrix3d& D) {
  PatchLanes lanes;
  lanes.set(0, patch, D, D.inverse());
  lanes.fit(1);
  return lanes.stiffness_of(0);
}

TEST(BendingElement, SixPointsOnAConicGiveAFiniteStiffness) {
  // Corners and opposite corners of a regular hexagon lie on one circle, and on many conics besides.
  std::array<Eigen::Vector2d, 6> hexagon;
  for (int i = 0; i < 6; ++i) {
    const double angle = 1.0471975511965976 * i;
    hexagon[static_cast<std::size_t>(i)] = {std::cos(angle), std::sin(angle)};
  }
  const Eigen::Matrix3d D = bending_law(isotropic(1.0e6, 0.3, 1.0e-3, 300.0));
  const std::array<double, 21> Q = stiffness_of({{hexagon[0], hexagon[2], hexagon[4]},
                                                 {hexagon[3], hexagon[5], hexagon[1]},
                                                 {PatchEdge::kNeighbour, PatchEdge::kNeighbour, PatchEdge::kNeighbour}},
                                                D);
  for (const double q : Q) {
    EXPECT_TRUE(std::isfinite(q));
    EXPECT_LT(std::abs(q), 1e3 * D(0, 0));
  }
}

// Q = A B^T D B of the fit, by its definition.
TEST(BendingElement, StiffnessIsThatOfTheFitWhicheverNeighboursThereAre) {
  const Eigen::Matrix3d D = bending_law(orthotropic_cloth());
  const std::array<Eigen::Vector2d, 3> X{Eigen::Vector2d(0.1, 0.0), Eigen::Vector2d(1.2, 0.2),
                                         Eigen::Vector2d(0.4, 0.9)};
  const std::array<Eigen::Vector2d, 3> opposite{Eigen::Vector2d(1.3, 1.1), Eigen::Vector2d(-0.6, 0.7),
                                                Eigen::Vector2d(0.8, -0.8)};
  const auto quadratic = [&](const Eigen::Vector2d& x) {
    const Eigen::Vector2d d = x - X[0];
    return Eigen::Vector3d(0.5 * d.x() * d.x(), 0.5 * d.y() * d.y(), 0.5 * d.x() * d.y());
  };
  Eigen::Matrix3d corners;
  for (int k = 0; k < 3; ++k) corners.col(k) << 1.0, X[static_cast<std::size_t>(k)];
  const double area = 0.5 * corners.determinant();
  for (int present = 0; present < 8; ++present) {
    std::array<PatchEdge, 3> edges{};
    Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 6> W = Eigen::Matrix<double, 3, 6>::Zero();
    for (int r = 0; r < 3; ++r) {
      const auto slot = static_cast<std::size_t>(r);
      if ((present >> r & 1) != 0) edges[slot] = PatchEdge::kNeighbour;
      if (edges[slot] == PatchEdge::kFree) continue;
      const Eigen::Vector3d lambda = corners.inverse() * Eigen::Vector3d(1.0, opposite[slot].x(), opposite[slot].y());
      Eigen::Vector3d p = quadratic(opposite[slot]);
      for (int k = 0; k < 3; ++k) p -= lambda[k] * quadratic(X[static_cast<std::size_t>(k)]);
      P.row(r) = p;
      W.row(r).head<3>() = -lambda;
      W(r, 3 + r) = 1.0;
    }
    const Eigen::Matrix3d G = P * D.inverse() * P.transpose();
    const Eigen::Matrix<double, 3, 6> B =
        D.inverse() * P.transpose() * G.completeOrthogonalDecomposition().pseudoInverse() * W;
    const Eigen::Matrix<double, 6, 6> expected = area * B.transpose() * D * B;
    const std::array<double, 21> Q = stiffness_of({X, opposite, edges}, D);
    std::size_t at = 0;
    for (int i = 0; i < 6; ++i) {
      for (int j = i; j < 6; ++j) EXPECT_NEAR(Q[at++], expected(i, j), 1e-11 * D(0, 0)) << present;
    }
  }
}

}  // namespace
}  // namespace kerf::fem
