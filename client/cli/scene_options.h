#pragma once

#include <string>

#include <CLI/App.hpp>

#include "server/service/offline/files.h"

// Adds the options that override choices of a scene.
namespace kerf::cli {

// Adds --integrator, --precision and --solver. `instead` names the setting that they override, for the help, e.g. "the
// scene's".
void add_integrator_options(CLI::App& app, const std::string& instead, offline::Overrides& overrides);

// Adds --fidelity.
void add_fidelity_option(CLI::App& app, const std::string& instead, offline::Overrides& overrides);

}  // namespace kerf::cli
