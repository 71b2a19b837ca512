#pragma once

#include <functional>

namespace kerf::fem {

struct EquilibriumOptions {
  double tolerance = 1e-9;   // -, see EquilibriumStats::residual
  int max_iterations = 300;  // Newton steps, >= 1
};

struct EquilibriumStats {
  bool converged = false;  // residual <= tolerance
  // -, Euclidean norm of the unbalanced forces over that of the loads and the reactions. If there are neither, it is
  // relative to the rounding error.
  double residual = 0.0;
  int iterations = 0;  // Newton steps
  // 1/s^2: this number times the masses was added to the stiffness in the last step. If it is 0 the stiffness is
  // positive definite, so the equilibrium is stable. Eigenvalues down to -1e-12 of the largest are tolerated. Free
  // motions of the sheet or of a part thus count as stable.
  double shift = 0.0;
};

// Called whenever a search has moved the sheet; returning false ends it.
using EquilibriumWatch = std::function<bool(const EquilibriumStats&)>;

}  // namespace kerf::fem
