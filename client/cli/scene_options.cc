#include "client/cli/scene_options.h"

#include <filesystem>
#include <vector>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "server/service/wire/scene_codec.h"

namespace kerf::cli {
namespace {

std::vector<std::string> solver_options() {
  std::vector<std::string> options;
  for (const fem::LinearSolverName& name : fem::kLinearSolverNames) options.emplace_back(name.option);
  return options;
}

}  // namespace

Result<sheet::SheetConfig> read_scene(host::Disk& disk, const std::string& path) {
  KERF_TRY_ASSIGN(const std::string json, disk.read_file(path, wire::kMaxSceneFileBytes));
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  return wire::decode_scene_file(json, [&disk, &folder](const std::string& file) {
    return disk.read_file((folder / file).string(), sheet::kMaxMeshFileBytes);
  });
}

void add_integrator_options(CLI::App& app, const std::string& instead, IntegratorArguments& arguments) {
  app.add_option(
         "--integrator", arguments.integrator,
         "Integrator, instead of " + instead + ": explicit, implicit (Euler),\ntrapezoidal, bdf2, tr-bdf2 or auto")
      ->check(CLI::IsMember({"explicit", "implicit", "trapezoidal", "bdf2", "tr-bdf2", "auto"}));
  app.add_option("--precision", arguments.precision,
                 "Precision of the explicit integrator, instead of " + instead + ": double or mixed")
      ->check(CLI::IsMember({"double", "mixed"}));
  app.add_option("--solver", arguments.solver,
                 "Linear solver of the implicit integrators, instead of " + instead +
                     ":\nblock-jacobi-cg, factor-cg, multigrid-cg, jacobi-cg, cg or direct; es-cgm and as-cgm, which "
                     "solve a\ndifferent system")
      ->check(CLI::IsMember(solver_options()));
}

void apply(const IntegratorArguments& arguments, sheet::IntegratorSettings& settings) {
  if (arguments.integrator == "explicit") settings.kind = sheet::IntegratorKind::kExplicitLeapfrog;
  if (arguments.integrator == "implicit") settings.kind = sheet::IntegratorKind::kImplicitEuler;
  if (arguments.integrator == "trapezoidal") settings.kind = sheet::IntegratorKind::kTrapezoidal;
  if (arguments.integrator == "bdf2") settings.kind = sheet::IntegratorKind::kBdf2;
  if (arguments.integrator == "tr-bdf2") settings.kind = sheet::IntegratorKind::kTrBdf2;
  if (arguments.integrator == "auto") settings.kind = sheet::IntegratorKind::kAutomatic;
  if (arguments.precision == "mixed") settings.precision = sheet::Precision::kMixed;
  if (arguments.precision == "double") settings.precision = sheet::Precision::kDouble;
  for (const fem::LinearSolverName& name : fem::kLinearSolverNames) {
    if (arguments.solver == name.option) settings.solver = name.kind;
  }
}

void add_fidelity_option(CLI::App& app, const std::string& instead, std::string& fidelity) {
  app.add_option(
         "--fidelity", fidelity,
         "Fidelity, instead of " + instead +
             ": exact, or real-time, which softens the membrane of a sheet\nthat is too stiff for its tick, and "
             "says by how much")
      ->check(CLI::IsMember({"exact", "real-time"}));
}

void apply_fidelity(const std::string& fidelity, sheet::SheetConfig& config) {
  if (fidelity == "exact") config.fidelity = sheet::Fidelity::kExact;
  if (fidelity == "real-time") config.fidelity = sheet::Fidelity::kRealTime;
}

}  // namespace kerf::cli
