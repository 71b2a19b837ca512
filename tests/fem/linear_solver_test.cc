// The contract of every linear solver: the solution of a known system, an honest residual, refusal of what is not
// positive definite.
#include "server/core/linear/linear_solver.h"

#include <algorithm>
#include <array>
#include <string>

#include "tests/fem/linear_systems.h"
#include "tests/support/matrix_near.h"

namespace kerf::fem {
namespace {

std::string name_of_test(linear::LinearSolverKind kind) {
  std::string name(linear::name_of(kind).option);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class LinearSolverContract : public testing::TestWithParam<linear::LinearSolverKind> {
 protected:
  std::unique_ptr<linear::LinearSolver> solver_ = linear::make_linear_solver(GetParam(), 2000);
};

TEST_P(LinearSolverContract, FindsTheSolutionAndReportsTheTrueResidual) {
  SeededRandom random(2);
  for (const double scale : {0.0, 1.0, 1e4}) {
    const System system = random_system(9, scale, 17);
    solver_->analyse(system.A);
    const linear::VertexField exact = random_field(random, system.A.num_rows(), 1.0);
    linear::VertexField b(exact.cols());
    b.reshaped() = system.dense * exact.reshaped();
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, exact.cols());
    const linear::LinearStats stats = solver_->solve(system.A, b, 1e-12, x);
    EXPECT_TRUE(stats.converged) << scale;
    EXPECT_THAT(x, test::MatrixNear(exact, 1e-7)) << scale;
    const double residual = (b.reshaped() - system.dense * x.reshaped()).norm() / b.norm();
    EXPECT_NEAR(stats.residual, residual, 1e-14);
    EXPECT_LT(stats.residual, 2e-12);
  }
}

TEST_P(LinearSolverContract, SolvesOneBlockAndAZeroRightHandSide) {
  linear::BlockMatrix A;
  A.resize(1);
  A.set_row(0, std::array<int, 1>{0});
  A.block(0) = Eigen::Matrix3d{
      {4.0, 1.0, 0.0},
      {1.0, 3.0, 1.0},
      {0.0, 1.0, 2.0},
  };
  solver_->analyse(A);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, 1);
  EXPECT_TRUE(solver_->solve(A, Eigen::Vector3d(5.0, 5.0, 3.0), 1e-15, x).converged);
  EXPECT_LT((x - Eigen::Vector3d(1.0, 1.0, 1.0)).norm(), 1e-14);
  EXPECT_TRUE(solver_->solve(A, Eigen::Vector3d::Zero(), 1e-14, x).converged);
  EXPECT_EQ(x.norm(), 0.0);
}

TEST_P(LinearSolverContract, SaysSoWhenTheMatrixIsNotPositiveDefinite) {
  System system = random_system(5, 1.0, 3);
  system.A.block(system.A.diagonal(7)) -= 50.0 * Eigen::Matrix3d::Identity();
  system.dense.diagonal().segment<3>(21).array() -= 50.0;
  solver_->analyse(system.A);
  SeededRandom random(8);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  const linear::LinearStats stats = solver_->solve(system.A, b, 1e-10, x);
  EXPECT_FALSE(stats.converged);
  const double residual = (b.reshaped() - system.dense * x.reshaped()).norm() / b.norm();
  EXPECT_NEAR(stats.residual, residual, 1e-10 * residual);
}

TEST_P(LinearSolverContract, RepeatsBitForBit) {
  const System system = random_system(8, 100.0, 5);
  SeededRandom random(6);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  solver_->analyse(system.A);
  linear::VertexField first = Eigen::Matrix3Xd::Zero(3, b.cols());
  linear::VertexField second = first;
  solver_->solve(system.A, b, 1e-6, first);
  solver_->solve(system.A, b, 1e-6, second);
  EXPECT_EQ(first, second);
}

INSTANTIATE_TEST_SUITE_P(All, LinearSolverContract,
                         testing::Values(linear::LinearSolverKind::kPlainCg, linear::LinearSolverKind::kJacobiCg,
                                         linear::LinearSolverKind::kBlockJacobiCg, linear::LinearSolverKind::kFactorCg,
                                         linear::LinearSolverKind::kMultigridCg, linear::LinearSolverKind::kDirect),
                         [](const testing::TestParamInfo<linear::LinearSolverKind>& tested) {
                           return name_of_test(tested.param);
                         });

// Q A Q^T, Q having `turns` on its diagonal.
System turned(const System& system, const std::vector<Eigen::Matrix3d>& turns) {
  System result = system;
  for (int i = 0; i < system.A.num_rows(); ++i) {
    for (int at = system.A.row_begin(i); at < system.A.row_end(i); ++at) {
      const auto j = static_cast<std::size_t>(system.A.column(at));
      result.A.block(at) = turns[static_cast<std::size_t>(i)] * system.A.block(at) * turns[j].transpose();
    }
  }
  return result;
}

TEST(FactorCg, AFactorServesAMatrixThatTurnedWithItsFrames) {
  SeededRandom random(12);
  const System system = random_system(9, 1e3, 4);
  const std::unique_ptr<linear::LinearSolver> solver =
      linear::make_linear_solver(linear::LinearSolverKind::kFactorCg, 100);
  solver->analyse(system.A);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  const int fresh = solver->solve(system.A, b, 1e-9, x).iterations;
  EXPECT_LE(fresh, 4);
  for (Eigen::Matrix3d& frame : *solver->frames()) frame = random_rotation(random);
  const System after = turned(system, *solver->frames());
  x.setZero();
  const linear::LinearStats stats = solver->solve(after.A, b, 1e-9, x);
  EXPECT_TRUE(stats.converged);
  EXPECT_LE(stats.iterations, fresh + 1);
}

TEST(FactorCg, AFactorThatServesBadlyIsMadeAnew) {
  SeededRandom random(13);
  const System first = random_system(9, 1e3, 4);
  const System second = random_system(9, 1e3, 5);
  const std::unique_ptr<linear::LinearSolver> solver =
      linear::make_linear_solver(linear::LinearSolverKind::kFactorCg, 100);
  solver->analyse(first.A);
  const linear::VertexField b = random_field(random, first.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  solver->solve(first.A, b, 1e-9, x);
  x.setZero();
  const linear::LinearStats stats = solver->solve(second.A, b, 1e-9, x);
  EXPECT_TRUE(stats.converged);
  EXPECT_LE(stats.iterations, 8);  // two to see that the old one will not do
}

TEST(FactorCg, WhatWasForgottenHasNoInfluence) {
  SeededRandom random(14);
  const System first = random_system(7, 1e3, 4);
  const System second = random_system(7, 1.1e3, 4);
  const linear::VertexField b = random_field(random, first.A.num_rows(), 1.0);
  const auto solved = [&](bool forgets, bool begins_with_first) {
    const std::unique_ptr<linear::LinearSolver> solver =
        linear::make_linear_solver(linear::LinearSolverKind::kFactorCg, 100);
    solver->analyse(first.A);
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
    if (begins_with_first) solver->solve(first.A, b, 1e-6, x);
    if (forgets) solver->reset();
    x.setZero();
    solver->solve(second.A, b, 1e-6, x);
    return x;
  };
  EXPECT_EQ(solved(true, true), solved(false, false));
  EXPECT_NE(solved(false, true), solved(false, false));
}

TEST(FactorCg, LeavesWhatFloatsLoseToAFactorInDouble) {
  const System system = random_system(9, 1e4, 17);
  SeededRandom random(2);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  const auto solved = [&](linear::LinearSolverKind kind) {
    const std::unique_ptr<linear::LinearSolver> solver =
        linear::make_linear_solver(kind, 1);  // one iteration is not enough
    solver->analyse(system.A);
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
    const linear::LinearStats stats = solver->solve(system.A, b, 1e-10, x);
    EXPECT_TRUE(stats.converged);
    EXPECT_EQ(stats.iterations, kind == linear::LinearSolverKind::kDirect ? 1 : 2);
    return x;
  };
  EXPECT_EQ(solved(linear::LinearSolverKind::kFactorCg), solved(linear::LinearSolverKind::kDirect));
}

class ConjugateGradients : public testing::TestWithParam<linear::LinearSolverKind> {};

TEST_P(ConjugateGradients, StopAtTheIterationLimitAndSaySo) {
  const System system = random_system(9, 1e4, 17);
  const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(GetParam(), 3);
  solver->analyse(system.A);
  SeededRandom random(2);
  const linear::VertexField b = random_field(random, system.A.num_rows(), 1.0);
  linear::VertexField x = Eigen::Matrix3Xd::Zero(3, b.cols());
  const linear::LinearStats stats = solver->solve(system.A, b, 1e-12, x);
  EXPECT_FALSE(stats.converged);
  EXPECT_EQ(stats.iterations, 3);
  EXPECT_GT(stats.residual, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(All, ConjugateGradients,
                         testing::Values(linear::LinearSolverKind::kPlainCg, linear::LinearSolverKind::kJacobiCg,
                                         linear::LinearSolverKind::kBlockJacobiCg,
                                         linear::LinearSolverKind::kMultigridCg),
                         [](const testing::TestParamInfo<linear::LinearSolverKind>& tested) {
                           return name_of_test(tested.param);
                         });

// A preconditioner is exact where the matrix has no more than it looks at: one iteration then.
TEST(ConjugateGradient, EachPreconditionerSeesWhatItSays) {
  System system = random_system(6, 0.0, 4);
  const int n = system.A.num_rows();
  SeededRandom random(12);
  const linear::VertexField b = random_field(random, n, 1.0);
  const auto iterations = [&](linear::LinearSolverKind kind) {
    const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(kind, 1000);
    solver->analyse(system.A);
    linear::VertexField x = Eigen::Matrix3Xd::Zero(3, n);
    const linear::LinearStats stats = solver->solve(system.A, b, 1e-10, x);
    EXPECT_TRUE(stats.converged);
    return stats.iterations;
  };
  EXPECT_GT(iterations(linear::LinearSolverKind::kPlainCg), 5);
  EXPECT_EQ(iterations(linear::LinearSolverKind::kJacobiCg), 1);
  EXPECT_EQ(iterations(linear::LinearSolverKind::kBlockJacobiCg), 1);
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d u = random_vector(random, 2.0);
    system.A.block(system.A.diagonal(i)) += u * u.transpose();
  }
  EXPECT_GT(iterations(linear::LinearSolverKind::kPlainCg), 5);
  EXPECT_GT(iterations(linear::LinearSolverKind::kJacobiCg), 5);
  EXPECT_EQ(iterations(linear::LinearSolverKind::kBlockJacobiCg), 1);
}

}  // namespace
}  // namespace kerf::fem
