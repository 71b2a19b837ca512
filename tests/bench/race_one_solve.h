#pragma once

#include <memory>

#include "server/core/fem/step/integrator.h"

namespace kerf::bench {

// The source's scheme as it is, without Kerf's repairs and energy guard: implicit Euler with one linear solve a step,
// (M + h^2 K) (dx - h v) = h^2 (f + M g - K h v), whose result is taken whatever it is. Forces and tangent are Kerf's;
// for pins at rest and no other load than gravity.
std::unique_ptr<fem::Integrator> make_one_solve(linear::LinearSolverKind solver);

}  // namespace kerf::bench
