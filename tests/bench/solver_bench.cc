// The tables of tests/bench/notes/linear-solvers.md: what each makes of the same linear system of a step.
//   solver_bench [wool|soft|large [SIDE]|cut [SIDE]]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "server/base/check.h"
#include "server/core/fem/element/material.h"
#include "server/core/linear/covariance_root.h"
#include "server/core/linear/factor_preconditioner.h"
#include "server/core/linear/linear_solver.h"
#include "server/core/linear/multigrid_preconditioner.h"
#include "server/core/linear/preconditioner.h"
#include "server/core/mesh/build/grid_mesh.h"
#include "tests/bench/solver_cut.h"
#include "tests/bench/solver_large_bench.h"
#include "tests/bench/solver_system.h"

namespace kerf::bench {
namespace {

constexpr double kStep = 1.0 / 60.0;  // s
constexpr int kSteps = 30;            // from the horizontal to where the system is taken
constexpr double kTolerance = 1e-6;
constexpr int kMaxIterations = 10000;

// A sheet that has fallen from the horizontal, two corners pinned.
System make_system(const fem::Material& material, int side) {
  const mesh::TriangleMesh mesh = mesh::make_grid({.num_x = side, .num_y = side}).value();
  const fem::Model model(mesh, material);
  const fem::Loads loads = corners_pinned(mesh, side);
  fem::State state = flat(mesh);
  fall(model, loads, kStep, kSteps, state);
  return system_at(model, loads, state, kStep);
}

void solve_densely(System& system) {
  const linear::BlockMatrix& A = system.tangent.blocks();
  system.dense = Eigen::MatrixXd::Zero(3 * A.num_rows(), 3 * A.num_rows());
  for (int i = 0; i < A.num_rows(); ++i) {
    for (int at = A.row_begin(i); at < A.row_end(i); ++at)
      system.dense.block<3, 3>(3 * i, 3 * A.column(at)) = A.block(at);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(system.dense);
  KERF_CHECK(factor.info() == Eigen::Success, "the tangent is positive definite");
  system.exact.reshaped() = factor.solve(Eigen::VectorXd(system.b.reshaped()));
}

// Largest over smallest |eigenvalue| of a symmetric matrix; infinite where it is not finite.
double condition(const Eigen::MatrixXd& matrix) {
  if (!matrix.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix, Eigen::EigenvaluesOnly);
  const Eigen::VectorXd sizes = eigen.eigenvalues().cwiseAbs();
  return sizes.maxCoeff() / sizes.minCoeff();
}

// S A S^T, whose condition preconditioned conjugate gradients see: S the inverse roots of 1x1 or 3x3 diagonal blocks.
Eigen::MatrixXd scaled(const Eigen::MatrixXd& A, Eigen::Index block) {
  Eigen::MatrixXd result = A;
  for (Eigen::Index i = 0; i < A.rows(); i += block) {
    const Eigen::MatrixXd L = Eigen::LLT<Eigen::MatrixXd>(A.block(i, i, block, block)).matrixL();
    const Eigen::MatrixXd S = L.inverse();
    result.middleRows(i, block) = Eigen::MatrixXd(S * result.middleRows(i, block));
    result.middleCols(i, block) = Eigen::MatrixXd(result.middleCols(i, block) * S.transpose());
  }
  return result;
}

// L^T P^-1 L, A = L L^T, of the same eigenvalues as P^-1 A.
Eigen::MatrixXd preconditioned(const System& system, std::unique_ptr<linear::Preconditioner> preconditioner) {
  const linear::BlockMatrix& A = system.tangent.blocks();
  preconditioner->analyse(A);
  if (std::vector<Eigen::Matrix3d>* const frames = preconditioner->frames()) *frames = system.frames;
  if (linear::VertexField* const positions = preconditioner->positions()) *positions = system.positions;
  KERF_CHECK(preconditioner->prepare(A), "A is positive definite");
  Eigen::MatrixXd inverse(system.dense.rows(), system.dense.cols());
  linear::VertexField unit = Eigen::Matrix3Xd::Zero(3, A.num_rows());
  linear::VertexField column(A.num_rows());
  for (Eigen::Index k = 0; k < inverse.cols(); ++k) {
    unit.reshaped()[k] = 1.0;
    preconditioner->apply(unit, column);
    unit.reshaped()[k] = 0.0;
    inverse.col(k) = column.reshaped();
  }
  const Eigen::MatrixXd L = Eigen::LLT<Eigen::MatrixXd>(system.dense).matrixL();
  const Eigen::MatrixXd result = L.transpose() * inverse * L;
  return 0.5 * (result + result.transpose());
}

struct Row {
  std::string name;
  linear::LinearSolverKind kind;
  linear::CovarianceRootOptions root;
};

std::vector<Row> rows() {
  using linear::EigenvalueNorm;
  using Kind = linear::LinearSolverKind;
  return {
      {"direct", Kind::kDirect, {}},
      {"plain CG", Kind::kPlainCg, {}},
      {"Jacobi CG", Kind::kJacobiCg, {}},
      {"block-Jacobi CG", Kind::kBlockJacobiCg, {}},
      {"factor CG", Kind::kFactorCg, {}},
      {"multigrid CG", Kind::kMultigridCg, {}},
      {"ES-CGM, p = 1/2, *solves a different system*", Kind::kEsCgm, {EigenvalueNorm::kPower, 0.5, 1}},
      {"ES-CGM, log, *solves a different system*", Kind::kEsCgm, {EigenvalueNorm::kLog, 0.5, 1}},
      {"AS-CGM, 1 iteration, *solves a different system*", Kind::kAsCgm, {EigenvalueNorm::kPower, 0.5, 1}},
      {"AS-CGM, 5 iterations, *solves a different system*", Kind::kAsCgm, {EigenvalueNorm::kPower, 0.5, 5}},
      {"AS-CGM, 10 iterations, *solves a different system*", Kind::kAsCgm, {EigenvalueNorm::kPower, 0.5, 10}},
  };
}

// Returns the matrix used in place of A; for preconditioned solvers one with the condition of their system.
Eigen::MatrixXd matrix_of(const Row& row, const System& system) {
  const linear::BlockMatrix& A = system.tangent.blocks();
  linear::CovarianceRoot root(row.root);
  switch (row.kind) {
    case linear::LinearSolverKind::kEsCgm:
      root.resize(A.num_rows(), row.kind);
      return root.exact(A);
    case linear::LinearSolverKind::kAsCgm:
      root.resize(A.num_rows(), row.kind);
      return root.approximate(A);
    case linear::LinearSolverKind::kJacobiCg:
      return scaled(system.dense, 1);
    case linear::LinearSolverKind::kBlockJacobiCg:
      return scaled(system.dense, 3);
    case linear::LinearSolverKind::kFactorCg:
      return preconditioned(system, std::make_unique<linear::FactorPreconditioner>());
    case linear::LinearSolverKind::kMultigridCg:
      return preconditioned(system, std::make_unique<linear::MultigridPreconditioner>());
    default:
      return system.dense;
  }
}

struct Solved {
  linear::VertexField x;
  linear::LinearStats stats;
  double seconds = 0.0;  // CPU
};

Solved solve(const Row& row, const System& system) {
  const std::unique_ptr<linear::LinearSolver> solver = linear::make_linear_solver(row.kind, kMaxIterations, row.root);
  Solved solved;
  solver->analyse(system.tangent.blocks());
  if (std::vector<Eigen::Matrix3d>* const frames = solver->frames()) *frames = system.frames;
  if (linear::VertexField* const positions = solver->positions()) *positions = system.positions;
  solved.x = Eigen::Matrix3Xd::Zero(3, system.b.cols());
  const std::clock_t begin = std::clock();
  solved.stats = solver->solve(system.tangent.blocks(), system.b, kTolerance, solved.x);
  solved.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return solved;
}

void report(const Row& row, const System& system) {
  const auto [x, stats, seconds] = solve(row, system);
  const Eigen::MatrixXd matrix = matrix_of(row, system);
  const bool is_other = linear::name_of(row.kind).solves_different_system;
  const Eigen::VectorXd own = is_other ? Eigen::VectorXd(system.b.reshaped() - matrix * x.reshaped())
                                       : Eigen::VectorXd(system.b.reshaped() - system.dense * x.reshaped());
  const double own_residual = own.allFinite() ? own.norm() / system.b.norm() : std::numeric_limits<double>::infinity();
  const double error = (x - system.exact).colwise().norm().maxCoeff();
  std::printf("| %s | %.2g | %d | %.2g | %.2g | %.3g | %.1f |\n", row.name.c_str(), condition(matrix), stats.iterations,
              own_residual, stats.residual, 1e3 * error, 1e3 * seconds);
  std::fflush(stdout);
}

void measure(const char* name, const fem::Material& material) {
  for (const int side : {12, 20}) {
    System system = make_system(material, side);
    solve_densely(system);
    std::printf(
        "%s, %d x %d vertices; the largest step of a vertex is %.1f mm\n\n"
        "| solver | condition | iterations | own residual | true residual | error mm | CPU ms |\n"
        "|---|---|---|---|---|---|---|\n",
        name, side, side, 1e3 * system.exact.colwise().norm().maxCoeff());
    for (const Row& row : rows()) report(row, system);
    std::printf("\n");
  }
}

}  // namespace
}  // namespace kerf::bench

int main(int argc, char** argv) {
  const std::string_view only = argc > 1 ? argv[1] : "";
  const kerf::fem::Material wool = kerf::fem::find_preset("wool").value();
  const kerf::fem::Material soft = kerf::fem::isotropic(1.0e6, 0.3, 5.0e-4, 1000.0);
  if (only.empty() || only == "wool") kerf::bench::measure("Wool", wool);
  if (only.empty() || only == "soft") kerf::bench::measure("Soft", soft);
  if (only.empty() || only == "large") {
    const int only_side = argc > 2 ? std::atoi(argv[2]) : 0;
    kerf::bench::measure_large("Wool", wool, only_side);
    kerf::bench::measure_large("Soft", soft, only_side);
  }
  bool is_right = true;
  if (only.empty() || only == "cut") {
    for (const int side : argc > 2 ? std::vector<int>{std::stoi(argv[2])} : std::vector<int>{50, 100}) {
      for (const auto& [name, material] : {std::pair("Wool", wool), {"Soft", soft}}) {
        is_right = kerf::bench::measure_after_cut(name, material, side) && is_right;
      }
    }
  }
  return is_right ? 0 : 1;
}
