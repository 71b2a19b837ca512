#pragma once

#include <CLI/App.hpp>

#include "client/cli/output.h"

// Each adds its subcommands to the app; a subcommand that is given sets session.action.
namespace kerf::cli {

void add_sheet_commands(CLI::App& app, Session& session);
void add_cut_command(CLI::App& app, Session& session);
void add_view_commands(CLI::App& app, Session& session);     // render, watch, export, info
void add_offline_commands(CLI::App& app, Session& session);  // run, replay

}  // namespace kerf::cli
