#include "server/core/fem/step/integrator.h"

#include "server/core/fem/element/loads.h"
#include "server/core/fem/model/model.h"
#include "server/core/fem/model/tick_cost.h"
#include "server/core/fem/step/automatic_integrator.h"
#include "server/core/fem/step/explicit_integrator.h"
#include "server/core/fem/step/implicit_integrator.h"

namespace kerf::fem {

double Integrator::mobility(const Model& model, const Grab& grab) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (grab.vertices[k] == mesh::kNone) continue;
    const double w = grab.weights[static_cast<Eigen::Index>(k)];
    sum += w * w * model.inverse_mass()[static_cast<std::size_t>(grab.vertices[k])];
  }
  return sum;
}

TickCost Integrator::expected_cost(const Model& /*model*/, double /*dt*/, const TickCounts& /*last*/) const {
  return {};
}

std::unique_ptr<Integrator> make_integrator(const IntegratorOptions& options) {
  switch (options.kind) {
    case IntegratorKind::kExplicit:
      return std::make_unique<ExplicitIntegrator>(options);
    case IntegratorKind::kImplicitEuler:
    case IntegratorKind::kTrBdf2:
    case IntegratorKind::kTrapezoidal:
    case IntegratorKind::kBdf2:
    case IntegratorKind::kSdirk2:
      return std::make_unique<ImplicitIntegrator>(options);
    case IntegratorKind::kAutomatic:
      break;
  }
  return std::make_unique<AutomaticIntegrator>(options);
}

}  // namespace kerf::fem
