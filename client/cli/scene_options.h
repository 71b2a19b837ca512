#pragma once

#include <string>

#include <CLI/App.hpp>

#include "server/base/disk.h"
#include "server/base/result.h"
#include "server/core/scene/sheet_config.h"

// Reads scene files, and the options that override a scene's integrator and fidelity.
namespace kerf::cli {

// Reads a scene file, and the files named in it, which are relative to it.
Result<sheet::SheetConfig> read_scene(host::Disk& disk, const std::string& path);

struct IntegratorArguments {
  std::string integrator;
  std::string precision;
  std::string solver;

  [[nodiscard]] bool empty() const { return integrator.empty() && precision.empty() && solver.empty(); }
};

// Adds --integrator, --precision and --solver. `instead`: the setting overridden, for the help: "the scene's".
void add_integrator_options(CLI::App& app, const std::string& instead, IntegratorArguments& arguments);

// Applies the options given to the settings.
void apply(const IntegratorArguments& arguments, sheet::IntegratorSettings& settings);

// Adds --fidelity with the value `fidelity`: "exact", "real-time" or empty.
void add_fidelity_option(CLI::App& app, const std::string& instead, std::string& fidelity);
void apply_fidelity(const std::string& fidelity, sheet::SheetConfig& config);

}  // namespace kerf::cli
