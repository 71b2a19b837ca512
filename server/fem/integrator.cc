#include "server/fem/integrator.h"

#include "server/fem/automatic_integrator.h"
#include "server/fem/implicit_integrator.h"

namespace kerf::fem {

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options) {
  switch (options.kind) {
    case IntegratorKind::kExplicit:
      return std::make_unique<ExplicitIntegrator>(options);
    case IntegratorKind::kImplicitEuler:
    case IntegratorKind::kTrBdf2:
    case IntegratorKind::kTrapezoidal:
    case IntegratorKind::kBdf2:
      return std::make_unique<ImplicitIntegrator>(options);
    case IntegratorKind::kAutomatic:
      break;
  }
  return std::make_unique<AutomaticIntegrator>(options);
}

}  // namespace kerf::fem
