#include "server/service/wire/integrator_codec.h"

#include <array>
#include <utility>

#include "server/service/wire/choices.h"

namespace kerf::wire {
namespace {

using Kind = scene::IntegratorKind;
using Solver = scene::LinearSolverKind;

constexpr std::array<std::pair<v1::Integrator::Kind, Kind>, 6> kKinds{{
    {v1::Integrator::AUTOMATIC, Kind::kAutomatic},
    {v1::Integrator::EXPLICIT_LEAPFROG, Kind::kExplicitLeapfrog},
    {v1::Integrator::IMPLICIT_EULER, Kind::kImplicitEuler},
    {v1::Integrator::TRAPEZOIDAL, Kind::kTrapezoidal},
    {v1::Integrator::BDF2, Kind::kBdf2},
    {v1::Integrator::TR_BDF2, Kind::kTrBdf2},
}};
constexpr std::array<std::pair<v1::Integrator::Solver, Solver>, 8> kSolvers{{
    {v1::Integrator::PLAIN_CG, Solver::kPlainCg},
    {v1::Integrator::JACOBI_CG, Solver::kJacobiCg},
    {v1::Integrator::BLOCK_JACOBI_CG, Solver::kBlockJacobiCg},
    {v1::Integrator::FACTOR_CG, Solver::kFactorCg},
    {v1::Integrator::MULTIGRID_CG, Solver::kMultigridCg},
    {v1::Integrator::DIRECT, Solver::kDirect},
    {v1::Integrator::ES_CGM, Solver::kEsCgm},
    {v1::Integrator::AS_CGM, Solver::kAsCgm},
}};
constexpr std::array<std::pair<v1::CovarianceRoot::Norm, scene::EigenvalueNorm>, 2> kNorms{{
    {v1::CovarianceRoot::P_NORM, scene::EigenvalueNorm::kPower},
    {v1::CovarianceRoot::LOG_NORM, scene::EigenvalueNorm::kLog},
}};
constexpr std::array<std::pair<v1::Integrator::Precision, scene::Precision>, 2> kPrecisions{{
    {v1::Integrator::DOUBLE, scene::Precision::kDouble},
    {v1::Integrator::MIXED, scene::Precision::kMixed},
}};

}  // namespace

Status decode_integrator(const v1::Integrator& message, scene::IntegratorSettings& settings) {
  KERF_TRY(decode_choice(kKinds, message.kind(), "integrator.kind", settings.kind));
  KERF_TRY(decode_choice(kSolvers, message.solver(), "integrator.solver", settings.solver));
  KERF_TRY(decode_choice(kPrecisions, message.precision(), "integrator.precision", settings.precision));
  if (message.max_substeps() != 0) settings.max_substeps = message.max_substeps();
  if (message.newton_iterations() != 0) settings.newton_iterations = message.newton_iterations();
  if (message.solver_tolerance() != 0.0) settings.solver_tolerance = message.solver_tolerance();
  if (message.max_linear_iterations() != 0) settings.max_linear_iterations = message.max_linear_iterations();
  const v1::CovarianceRoot& root = message.covariance_root();
  const char* const norm_field = "integrator.covariance_root.norm";
  KERF_TRY(decode_choice(kNorms, root.norm(), norm_field, settings.covariance_root.norm));
  if (root.p() != 0.0) settings.covariance_root.power = root.p();
  if (root.newton_schulz_iterations() != 0) {
    settings.covariance_root.newton_schulz_iterations = root.newton_schulz_iterations();
  }
  if (message.has_highest_mode_damping()) settings.highest_mode_damping = message.highest_mode_damping();
  const bool is_undamped = settings.highest_mode_damping == 0.0;
  if (is_undamped && message.precision() == v1::Integrator::PRECISION_UNSPECIFIED) {
    settings.precision = scene::Precision::kDouble;  // Without damping nothing removes rounding errors.
  }
  return Nothing{};
}

v1::Integrator encode_integrator(const scene::IntegratorSettings& settings) {
  v1::Integrator message;
  message.set_kind(encode_choice(kKinds, settings.kind));
  message.set_solver(encode_choice(kSolvers, settings.solver));
  message.set_precision(encode_choice(kPrecisions, settings.precision));
  message.set_max_substeps(settings.max_substeps);
  message.set_newton_iterations(settings.newton_iterations);
  message.set_solver_tolerance(settings.solver_tolerance);
  message.set_max_linear_iterations(settings.max_linear_iterations);
  v1::CovarianceRoot& root = *message.mutable_covariance_root();
  root.set_norm(encode_choice(kNorms, settings.covariance_root.norm));
  root.set_p(settings.covariance_root.power);
  root.set_newton_schulz_iterations(settings.covariance_root.newton_schulz_iterations);
  message.set_highest_mode_damping(settings.highest_mode_damping);
  return message;
}

}  // namespace kerf::wire
