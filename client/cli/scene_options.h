#pragma once

#include <string>

#include <CLI/App.hpp>

#include "server/base/disk.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

// Scene files, and the options that take the place of what a scene says of its integrator and fidelity.
namespace kerf::cli {

// A scene file, and the files that it names, which are relative to it.
Result<sheet::SheetConfig> read_scene(host::Disk& disk, const std::string& path);

struct IntegratorArguments {
  std::string integrator;
  std::string precision;
  std::string solver;

  [[nodiscard]] bool empty() const { return integrator.empty() && precision.empty() && solver.empty(); }
};

// --integrator, --precision and --solver. `instead`: of what, for the help: "the scene's".
void add_integrator_options(CLI::App& app, const std::string& instead, IntegratorArguments& arguments);

// Puts what was given into the settings.
void apply(const IntegratorArguments& arguments, sheet::IntegratorSettings& settings);

// --fidelity, of which `fidelity` is the value: "exact", "real-time" or empty.
void add_fidelity_option(CLI::App& app, const std::string& instead, std::string& fidelity);
void apply_fidelity(const std::string& fidelity, sheet::SheetConfig& config);

}  // namespace kerf::cli
