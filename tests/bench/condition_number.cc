#include "tests/bench/condition_number.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "server/base/check.h"

namespace kerf::bench {
namespace {

constexpr int kMaxIterations = 3000;
constexpr double kRelativeChange = 1e-6;

// Largest eigenvalue of the symmetric positive map `apply` by power iteration.
template <typename Map>
double largest_eigenvalue(Eigen::Index size, const Map& apply) {
  Eigen::VectorXd x(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = 1.0 + 0.5 * std::sin(1.7 * static_cast<double>(i));
  x.normalize();
  double eigenvalue = 0.0;
  for (int i = 0; i < kMaxIterations; ++i) {
    Eigen::VectorXd y = apply(x);
    const double next = y.norm();
    x = y / next;
    const bool settled = std::abs(next - eigenvalue) < kRelativeChange * next;
    eigenvalue = next;
    if (settled) break;
  }
  return eigenvalue;
}

}  // namespace

double condition_number(const mesh::TriangleMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (mesh::TriangleId t = 0; t < mesh.num_triangle_slots(); ++t) {
    if (!mesh.is_solid(t)) continue;
    const auto& v = mesh.vertices(t);
    const double area = mesh.area(t);
    for (int i = 0; i < 3; ++i) {
      const auto edge = [&](int k) -> Eigen::Vector2d {
        return mesh.rest_position(v[mesh::previous_corner(k)]) - mesh.rest_position(v[mesh::next_corner(k)]);
      };
      for (int j = 0; j < 3; ++j) entries.emplace_back(v[i], v[j], edge(i).dot(edge(j)) / (4.0 * area));
      entries.emplace_back(v[i], v[i], area / 3.0 * std::numbers::pi * std::numbers::pi);
    }
  }
  Eigen::SparseMatrix<double> matrix(mesh.num_vertices(), mesh.num_vertices());
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  matrix = Eigen::SparseMatrix<double>(scale.asDiagonal() * matrix * scale.asDiagonal());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  KERF_CHECK(factor.info() == Eigen::Success, "the matrix is positive definite");
  const auto forward = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return matrix * x; };
  const auto inverse = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return factor.solve(x); };
  return largest_eigenvalue(matrix.rows(), forward) * largest_eigenvalue(matrix.rows(), inverse);
}

}  // namespace kerf::bench
