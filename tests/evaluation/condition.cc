#include "tests/evaluation/condition.h"

#include <algorithm>
#include <cmath>

#include <Spectra/MatOp/SparseSymMatProd.h>
#include <Spectra/SymEigsSolver.h>
#include <Eigen/SparseCholesky>

#include "server/base/check.h"

namespace kerf::evaluation {
namespace {

constexpr double kEigenvalueTolerance = 1e-5;  // -, relative, of eigenvalues
constexpr int kMaxRestarts = 2000;
constexpr int kBasis = 40;  // vectors

// Applies the inverse of a matrix.
class Inverse {
 public:
  using Scalar = double;
  explicit Inverse(const Eigen::SparseMatrix<double>& matrix) : factor_(matrix) {
    KERF_CHECK(factor_.info() == Eigen::Success, "the matrix is positive definite");
  }
  [[nodiscard]] Eigen::Index rows() const { return factor_.rows(); }
  [[nodiscard]] Eigen::Index cols() const { return factor_.cols(); }
  void perform_op(const double* x_in, double* y_out) const {
    Eigen::Map<Eigen::VectorXd>(y_out, rows()) = factor_.solve(Eigen::Map<const Eigen::VectorXd>(x_in, rows()));
  }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

template <typename Operator>
double largest_eigenvalue(Operator& op) {
  Spectra::SymEigsSolver<Operator> solver(op, 1, kBasis);
  // A fixed start that is orthogonal to no mode by symmetry.
  Eigen::VectorXd start(op.rows());
  for (Eigen::Index i = 0; i < start.size(); ++i) start[i] = 1.0 + 0.5 * std::sin(1.7 * static_cast<double>(i));
  solver.init(start.data());
  solver.compute(Spectra::SortRule::LargestAlge, kMaxRestarts, kEigenvalueTolerance);
  KERF_CHECK(solver.info() == Spectra::CompInfo::Successful, "the eigenvalue converges");
  return solver.eigenvalues()[0];
}

double condition_of(const Eigen::SparseMatrix<double>& matrix) {
  Spectra::SparseSymMatProd<double> product(matrix);
  Inverse inverse(matrix);
  return largest_eigenvalue(product) * largest_eigenvalue(inverse);
}

}  // namespace

ConditionMatrix::ConditionMatrix(const mesh::TriangleMesh& mesh, const fem::Material& material,
                                 const std::vector<mesh::VertexId>& held) {
  std::vector<Eigen::Index> row(static_cast<std::size_t>(mesh.num_vertices()), 0);
  for (const mesh::VertexId v : held) row[static_cast<std::size_t>(v)] = -1;
  // Vertices without material are in no triangle.
  std::vector<bool> is_used(row.size(), false);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    for (const mesh::VertexId v : mesh.vertices(t)) is_used[static_cast<std::size_t>(v)] = true;
  }
  Eigen::Index rows = 0;
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (row[v] < 0 || !is_used[v]) {
      row[v] = -1;
      continue;
    }
    row[v] = rows++;
  }
  const double nu = material.poissons_ratio_12, e = material.youngs_modulus_1, s = e / (1.0 - nu * nu);
  Eigen::Matrix3d law;
  law << s, nu * s, 0.0, nu * s, s, 0.0, 0.0, 0.0, material.shear_modulus;
  std::vector<Eigen::Triplet<double>> entries;
  mass_ = Eigen::VectorXd::Zero(2 * rows);
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& v = mesh.vertices(t);
    const double area = mesh.area(t);
    Eigen::Matrix<double, 3, 6> strain = Eigen::Matrix<double, 3, 6>::Zero();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d edge =
          mesh.rest_position(v[mesh::previous_corner(k)]) - mesh.rest_position(v[mesh::next_corner(k)]);
      const Eigen::Vector2d gradient = Eigen::Vector2d(-edge.y(), edge.x()) / (2.0 * area);
      strain(0, 2 * k) = strain(2, 2 * k + 1) = gradient.x();
      strain(1, 2 * k + 1) = strain(2, 2 * k) = gradient.y();
    }
    const Eigen::Matrix<double, 6, 6> element = material.thickness * area * strain.transpose() * law * strain;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Index a = row[static_cast<std::size_t>(v[i / 2])];
      if (a < 0) continue;
      mass_[2 * a + i % 2] += material.density * material.thickness * area / 3.0;
      for (int j = 0; j < 6; ++j) {
        const Eigen::Index b = row[static_cast<std::size_t>(v[j / 2])];
        if (b >= 0) entries.emplace_back(2 * a + i % 2, 2 * b + j % 2, element(i, j));
      }
    }
  }
  stiffness_.resize(2 * rows, 2 * rows);
  stiffness_.setFromTriplets(entries.begin(), entries.end());
}

Eigen::SparseMatrix<double> ConditionMatrix::matrix(double step) const {
  Eigen::SparseMatrix<double> a = step * step * stiffness_;
  a.diagonal() += mass_;
  return a;
}

double ConditionMatrix::condition(double step) const {
  const Eigen::SparseMatrix<double> a = matrix(step);
  Spectra::SparseSymMatProd<double> product(a);
  Inverse inverse(a);
  // Motion out of the plane has the eigenvalues of M.
  return std::max(largest_eigenvalue(product), mass_.maxCoeff()) /
         std::min(1.0 / largest_eigenvalue(inverse), mass_.minCoeff());
}

double ConditionMatrix::scaled_condition(double step) const {
  const Eigen::SparseMatrix<double> a = matrix(step);
  const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
  return condition_of(scale.asDiagonal() * a * scale.asDiagonal());
}

double ConditionMatrix::step_of(double wanted) const {
  double low = 1e-8, high = 1e-1;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (condition(middle) < wanted ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace kerf::evaluation
