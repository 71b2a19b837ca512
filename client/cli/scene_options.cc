#include "client/cli/scene_options.h"

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace kerf::cli {

void add_integrator_options(CLI::App& app, const std::string& instead, offline::Overrides& overrides) {
  app.add_option(
         "--integrator", overrides.integrator,
         "Integrator, instead of " + instead + ": explicit, implicit (Euler),\ntrapezoidal, bdf2, tr-bdf2 or auto")
      ->check(CLI::IsMember(offline::integrator_names()));
  app.add_option("--precision", overrides.precision,
                 "Precision of the explicit integrator, instead of " + instead + ": double or mixed")
      ->check(CLI::IsMember({"double", "mixed"}));
  app.add_option("--solver", overrides.solver,
                 "Linear solver of the implicit integrators, instead of " + instead +
                     ":\nblock-jacobi-cg, factor-cg, multigrid-cg, jacobi-cg, cg or direct; es-cgm and as-cgm, which "
                     "solve a\ndifferent system")
      ->check(CLI::IsMember(offline::solver_names()));
}

void add_fidelity_option(CLI::App& app, const std::string& instead, offline::Overrides& overrides) {
  app.add_option(
         "--fidelity", overrides.fidelity,
         "Fidelity, instead of " + instead +
             ": exact, or real-time, which softens the membrane of a sheet\nthat is too stiff for its tick, and "
             "says by how much")
      ->check(CLI::IsMember({"exact", "real-time"}));
}

}  // namespace kerf::cli
