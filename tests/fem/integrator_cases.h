#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "server/core/fem/step/integrator.h"
#include "tests/fem/fixture.h"

namespace kerf::fem {

// Every integrator and linear solver there is, as test parameters.
struct IntegratorCase {
  std::string name;
  IntegratorOptions options;
};
inline void PrintTo(const IntegratorCase& tested, std::ostream* out) {
  *out << tested.name;
}

inline IntegratorCase integrator_case(std::string name, IntegratorKind kind, linear::LinearSolverKind solver) {
  IntegratorCase result{std::move(name), {}};
  result.options.kind = kind;
  result.options.precision = Precision::kDouble;
  result.options.linear_solver = solver;
  return result;
}

inline IntegratorCase mixed_case() {
  IntegratorCase result =
      integrator_case("ExplicitMixed", IntegratorKind::kExplicit, linear::LinearSolverKind::kBlockJacobiCg);
  result.options.precision = Precision::kMixed;
  return result;
}

inline std::vector<IntegratorCase> all_integrators() {
  return {
      integrator_case("Explicit", IntegratorKind::kExplicit, linear::LinearSolverKind::kBlockJacobiCg),
      mixed_case(),
      integrator_case("ImplicitEulerCg", IntegratorKind::kImplicitEuler, linear::LinearSolverKind::kBlockJacobiCg),
      integrator_case("ImplicitEulerPlainCg", IntegratorKind::kImplicitEuler, linear::LinearSolverKind::kPlainCg),
      integrator_case("ImplicitEulerJacobiCg", IntegratorKind::kImplicitEuler, linear::LinearSolverKind::kJacobiCg),
      integrator_case("ImplicitEulerDirect", IntegratorKind::kImplicitEuler, linear::LinearSolverKind::kDirect),
      integrator_case("TrBdf2FactorCg", IntegratorKind::kTrBdf2, linear::LinearSolverKind::kFactorCg),
      integrator_case("TrBdf2MultigridCg", IntegratorKind::kTrBdf2, linear::LinearSolverKind::kMultigridCg),
      integrator_case("TrBdf2Direct", IntegratorKind::kTrBdf2, linear::LinearSolverKind::kDirect),
      integrator_case("Sdirk2Direct", IntegratorKind::kSdirk2, linear::LinearSolverKind::kDirect),
      integrator_case("Bdf2Direct", IntegratorKind::kBdf2, linear::LinearSolverKind::kDirect),
  };
}

// For steps that resolve what happens.
inline std::vector<IntegratorCase> undamped_integrators() {
  return {integrator_case("TrapezoidalDirect", IntegratorKind::kTrapezoidal, linear::LinearSolverKind::kDirect)};
}

class IntegratorTest : public testing::TestWithParam<IntegratorCase> {
 protected:
  // Takes GetParam()'s options as they are.
  std::unique_ptr<Integrator> make(const Model& model) const {
    std::unique_ptr<Integrator> integrator = make_integrator(GetParam().options);
    integrator->rebuild(model);
    return integrator;
  }
  bool is(IntegratorKind kind) const { return GetParam().options.kind == kind; }
  // m/s: what velocities up to `speed` (m/s) may lose to rounding in so many substeps: that of the sum, 2^-24 for
  // floats, and three more of a kick that is no larger than twice the speed.
  double rounding(int substeps, double speed) const {
    return GetParam().options.precision == Precision::kMixed ? 7.0 * (substeps + 1) * speed * 0x1p-24 : 0.0;
  }
};

inline std::string case_name(const testing::TestParamInfo<IntegratorCase>& tested) {
  return tested.param.name;
}

inline bool equal_bits(const State& a, const State& b) {
  return a.x == b.x && a.v == b.v;
}

// Elastic and kinetic energy, J.
inline double internal_energy(const Model& model, const State& state) {
  const Energies energies = model.energies(state, Eigen::Vector3d::Zero());
  return energies.membrane + energies.bending + energies.kinetic;
}

inline constexpr double kTick = 1.0 / 60.0;  // s

inline Material soft_cloth() {
  return isotropic(4.0e5, 0.3, 5.0e-4, 400.0);
}

inline Loads no_loads() {
  Loads loads;
  loads.gravity.setZero();
  return loads;
}

// Pins the upper corners of a square grid of n x n where they are.
inline Loads hang_by_corners(int n, const State& state) {
  Loads loads;
  for (const int v : {n * (n - 1), n * n - 1}) loads.pins.push_back({v, state.x.col(v), Eigen::Vector3d::Zero()});
  return loads;
}

}  // namespace kerf::fem
