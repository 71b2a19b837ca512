#pragma once

#include <array>
#include <string_view>

namespace kerf::fem {

// How the linear systems of implicit integrators are solved.
enum class LinearSolverKind {
  kPlainCg,        // conjugate gradients without a preconditioner
  kJacobiCg,       // preconditioned with the inverse diagonal
  kBlockJacobiCg,  // preconditioned with the inverse 3x3 diagonal blocks, which follow the rotation of the sheet
  kDirect,         // 3x3-block LDL^T
};

struct LinearSolverName {
  LinearSolverKind kind;
  std::string_view option;       // on a command line
  std::string_view description;  // for people
};

// In the order of the enumeration.
inline constexpr std::array<LinearSolverName, 4> kLinearSolverNames{{
    {LinearSolverKind::kPlainCg, "cg", "plain conjugate gradients"},
    {LinearSolverKind::kJacobiCg, "jacobi-cg", "Jacobi-preconditioned conjugate gradients"},
    {LinearSolverKind::kBlockJacobiCg, "block-jacobi-cg", "block-Jacobi-preconditioned conjugate gradients"},
    {LinearSolverKind::kDirect, "direct", "direct solver"},
}};

constexpr const LinearSolverName& name_of(LinearSolverKind kind) {
  return kLinearSolverNames[static_cast<std::size_t>(kind)];
}

}  // namespace kerf::fem
