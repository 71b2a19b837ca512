// ES-CGM and AS-CGM against the formulas written down in dense arithmetic, and what they leave of the solution.
#include "server/core/linear/covariance_root.h"

#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "server/core/linear/covariance_root_solver.h"
#include "tests/fem/linear_systems.h"
#include "tests/support/allocation_counter.h"

namespace kerf::fem {
namespace {

void scale(System& system, double factor) {
  for (int i = 0; i < system.A.num_rows(); ++i) {
    for (int at = system.A.row_begin(i); at < system.A.row_end(i); ++at) system.A.block(at) *= factor;
  }
  system.dense *= factor;
}

// Eq. 3.21 as it stands.
Eigen::MatrixXd covariance(const Eigen::MatrixXd& A) {
  const Eigen::RowVectorXd mean = A.colwise().mean();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(A.cols(), A.cols());
  for (Eigen::Index i = 0; i < A.rows(); ++i) M += (A.row(i) - mean).transpose() * (A.row(i) - mean);
  return M / static_cast<double>(A.rows() - 1);
}

// Eq. 3.22 to 3.25, entry by entry.
template <typename Norm>
Eigen::MatrixXd exact_root(const Eigen::MatrixXd& M, const Norm& norm) {
  const Eigen::Index n = M.rows();
  Eigen::MatrixXd L = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd D(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    D[j] = M(j, j);
    for (Eigen::Index k = 0; k < j; ++k) D[j] -= L(j, k) * L(j, k) * D[k];
    for (Eigen::Index i = j + 1; i < n; ++i) {
      L(i, j) = M(i, j);
      for (Eigen::Index k = 0; k < j; ++k) L(i, j) -= L(i, k) * L(j, k) * D[k];
      L(i, j) /= D[j];
    }
  }
  const Eigen::VectorXd F = (D.array() + 1e-6).unaryExpr(norm);
  return L * F.asDiagonal() * L.transpose();
}

// Eq. 3.27 as it stands.
Eigen::MatrixXd newton_schulz(const Eigen::MatrixXd& M, int iterations) {
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(M.rows(), M.cols());
  Eigen::MatrixXd P = M;
  Eigen::MatrixXd Q = I;
  for (int k = 0; k < iterations; ++k) {
    const Eigen::MatrixXd T = 3.0 * I - Q * P;
    P = Eigen::MatrixXd(0.5 * P * T);
    Q = Eigen::MatrixXd(0.5 * T * Q);
  }
  return P;
}

double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

// Systems of less than a tile and of several, the last one not whole.
class CovarianceRootOf : public testing::TestWithParam<int> {
 protected:
  System system_ = random_system(GetParam(), 1.0, 23);
};

TEST_P(CovarianceRootOf, LdltIsThatOfTheFormulas) {
  const Eigen::MatrixXd M = covariance(system_.dense);
  for (const double p : {0.5, 1.0, 0.25}) {
    linear::CovarianceRoot root({linear::EigenvalueNorm::kPower, p, 1});
    root.resize(system_.A.num_rows(), linear::LinearSolverKind::kEsCgm);
    const Eigen::MatrixXd expected = exact_root(M, [p](double d) { return std::pow(d, p); });
    EXPECT_LT(relative_difference(root.exact(system_.A), expected), 1e-8) << p;
  }
  linear::CovarianceRoot root({linear::EigenvalueNorm::kLog, 0.5, 1});
  root.resize(system_.A.num_rows(), linear::LinearSolverKind::kEsCgm);
  const Eigen::MatrixXd expected = exact_root(M, [](double d) { return std::log10(d); });
  EXPECT_LT(relative_difference(root.exact(system_.A), expected), 1e-8);
}

TEST_P(CovarianceRootOf, ThePowerOneGivesTheCovarianceBack) {
  scale(system_, 1e4);  // beside which the 1e-6 added to D is nothing
  linear::CovarianceRoot root({linear::EigenvalueNorm::kPower, 1.0, 1});
  root.resize(system_.A.num_rows(), linear::LinearSolverKind::kEsCgm);
  EXPECT_LT(relative_difference(root.exact(system_.A), covariance(system_.dense)), 1e-10);
}

TEST_P(CovarianceRootOf, NewtonSchulzIsThatOfTheFormulas) {
  for (const int iterations : {1, 3}) {
    linear::CovarianceRoot root({linear::EigenvalueNorm::kPower, 0.5, iterations});
    root.resize(system_.A.num_rows(), linear::LinearSolverKind::kAsCgm);
    const Eigen::MatrixXd expected = newton_schulz(covariance(system_.dense), iterations);
    EXPECT_LT(relative_difference(root.approximate(system_.A), expected), 1e-9) << iterations;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CovarianceRootOf, testing::Values(3, 9, 11));

// If |M - I| < 1 on the range of M, it is the square root.
TEST(CovarianceRoot, NewtonSchulzConvergesForSmallCovariance) {
  System system = random_system(4, 0.3, 5);
  const double to_one = 1.0 / std::sqrt(covariance(system.dense).norm());
  scale(system, to_one);
  const Eigen::MatrixXd M = covariance(system.dense);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(M);
  const Eigen::VectorXd roots = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  const Eigen::MatrixXd expected = eigen.eigenvectors() * roots.asDiagonal() * eigen.eigenvectors().transpose();
  linear::CovarianceRoot root({linear::EigenvalueNorm::kPower, 0.5, 40});
  root.resize(system.A.num_rows(), linear::LinearSolverKind::kAsCgm);
  EXPECT_LT(relative_difference(root.approximate(system.A), expected), 1e-6);
}

TEST(CovarianceRoot, NewtonSchulzDivergesAsStatedAndEndsEarly) {
  const System system = random_system(6, 1e4, 5);
  linear::CovarianceRoot root({linear::EigenvalueNorm::kPower, 0.5, 1'000'000});
  root.resize(system.A.num_rows(), linear::LinearSolverKind::kAsCgm);
  EXPECT_FALSE(root.approximate(system.A).allFinite());
}

TEST(CovarianceRoot, TheLargestSheetIsAcceptedAndNoLarger) {
  linear::CovarianceRoot root({});
  root.resize(linear::kMaxCovarianceVertices, linear::LinearSolverKind::kEsCgm);
  EXPECT_DEATH(root.resize(linear::kMaxCovarianceVertices + 1, linear::LinearSolverKind::kEsCgm), "dense");
}

class CovarianceRootSolvers : public testing::TestWithParam<linear::LinearSolverKind> {
 protected:
  std::unique_ptr<linear::LinearSolver> solver_ = linear::make_linear_solver(GetParam(), 100000);
};

TEST_P(CovarianceRootSolvers, SolveTheOtherSystemAndReportTheResidualOfTheTrueOne) {
  System system = random_system(5, 1.0, 31);
  scale(system, 0.5 / std::sqrt(covariance(system.dense).norm()));  // that Newton-Schulz does not diverge
  const Eigen::MatrixXd M = covariance(system.dense);
  const Eigen::MatrixXd other = GetParam() == linear::LinearSolverKind::kEsCgm
                                    ? exact_root(M, [](double d) { return std::sqrt(d); })
                                    : newton_schulz(M, linear::CovarianceRootOptions{}.newton_schulz_iterations);
  // A right-hand side that the system has a solution for: centred, the covariance is singular, and only ES-CGM adds to
  // it.
  SeededRandom random(2);
  linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  b.reshaped() = Eigen::VectorXd(other * b.reshaped());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(other);
  const Eigen::VectorXd expected = decomposition.solve(Eigen::VectorXd(b.reshaped()));
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  solver_->analyse(system.A);
  const linear::LinearStats stats = solver_->solve(system.A, b, 1e-12, x);
  EXPECT_LT((x.reshaped() - expected).norm(), 1e-4 * expected.norm());
  const double residual = (b.reshaped() - system.dense * x.reshaped()).norm() / b.norm();
  EXPECT_NEAR(stats.residual, residual, 1e-10 * residual);
  EXPECT_GT(stats.residual, 0.1) << "a different system";
  EXPECT_FALSE(stats.converged);
}

TEST_P(CovarianceRootSolvers, LeaveTheGuessWhereTheMatrixIsNotFinite) {
  System system = random_system(4, 1.0, 31);
  scale(system, 1e200);
  SeededRandom random(2);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  solver_->analyse(system.A);
  const linear::LinearStats stats = solver_->solve(system.A, b, 1e-6, x);
  EXPECT_FALSE(stats.converged);
  EXPECT_EQ(x.norm(), 0.0);
  EXPECT_EQ(stats.residual, 1.0);
}

TEST_P(CovarianceRootSolvers, DoNotAllocateOnceTheyHaveSeenThePattern) {
  if (!test::counts_allocations()) GTEST_SKIP() << "the sanitizer has its own malloc";
  const System system = random_system(12, 1.0, 31);
  SeededRandom random(2);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  solver_->analyse(system.A);
  const std::size_t before = test::num_allocations();
  solver_->solve(system.A, b, 1e-6, x);
  EXPECT_EQ(test::num_allocations(), before);
}

INSTANTIATE_TEST_SUITE_P(All, CovarianceRootSolvers,
                         testing::Values(linear::LinearSolverKind::kEsCgm, linear::LinearSolverKind::kAsCgm),
                         [](const testing::TestParamInfo<linear::LinearSolverKind>& tested) {
                           return tested.param == linear::LinearSolverKind::kEsCgm ? "EsCgm" : "AsCgm";
                         });

}  // namespace
}  // namespace kerf::fem
