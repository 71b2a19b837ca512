#pragma once

#include <array>
#include <string_view>

namespace kerf::linear {

// Solver of the linear systems of implicit integrators.
enum class LinearSolverKind {
  kPlainCg,        // conjugate gradients without a preconditioner
  kJacobiCg,       // preconditioned with the inverse diagonal
  kBlockJacobiCg,  // preconditioned with the inverse 3x3 diagonal blocks, which follow the rotation of the sheet
  kFactorCg,       // preconditioned with a Cholesky factor in single precision that turns with the sheet; falls back to
                   // kDirect if it does not converge
  kMultigridCg,    // preconditioned with two levels of multigrid by aggregation; memory is in proportion to the number
                   // of vertices
  kDirect,         // Cholesky factor in double precision
  kEsCgm,          // a dense matrix in place of A: *solves a different system*; see CovarianceRoot
  kAsCgm,          // another dense matrix in place of A: *solves a different system*; see CovarianceRoot
};

struct LinearSolverName {
  LinearSolverKind kind;
  std::string_view option;       // name on a command line
  std::string_view description;  // text for people
  bool solves_different_system = false;
};

// Names of the solvers, in the order of the enumeration.
inline constexpr std::array<LinearSolverName, 8> kLinearSolverNames{{
    {LinearSolverKind::kPlainCg, "cg", "plain conjugate gradients"},
    {LinearSolverKind::kJacobiCg, "jacobi-cg", "Jacobi-preconditioned conjugate gradients"},
    {LinearSolverKind::kBlockJacobiCg, "block-jacobi-cg", "block-Jacobi-preconditioned conjugate gradients"},
    {LinearSolverKind::kFactorCg, "factor-cg", "factor-preconditioned conjugate gradients"},
    {LinearSolverKind::kMultigridCg, "multigrid-cg", "multigrid-preconditioned conjugate gradients"},
    {LinearSolverKind::kDirect, "direct", "direct solver"},
    {LinearSolverKind::kEsCgm, "es-cgm", "ES-CGM, which solves a different system", true},
    {LinearSolverKind::kAsCgm, "as-cgm", "AS-CGM, which solves a different system", true},
}};

constexpr const LinearSolverName& name_of(LinearSolverKind kind) {
  return kLinearSolverNames[static_cast<std::size_t>(kind)];
}

enum class EigenvalueNorm {
  kPower,  // lambda^p (eq. 3.25 of the thesis CovarianceRoot cites)
  kLog,    // log10 lambda (eq. 3.24; base 10 as in the example beside it). It is negative for lambda < 1, and the
           // matrix indefinite
};

// Options of kEsCgm and kAsCgm, see CovarianceRoot.
struct CovarianceRootOptions {
  EigenvalueNorm norm = EigenvalueNorm::kPower;  // ES-CGM only
  double power = 0.5;                            // -, p > 0; ES-CGM only
  int newton_schulz_iterations = 5;              // AS-CGM only, >= 1; the thesis gives no number
};

// Largest number of vertices of a sheet solved by kEsCgm and kAsCgm. Their matrices are dense: memory grows with the
// square of this number, work with its cube.
inline constexpr int kMaxCovarianceVertices = 500;

}  // namespace kerf::linear
