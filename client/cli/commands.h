#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "client/cli/output.h"

// Adds the subcommands to the app; a subcommand given on the command line sets session.action.
namespace kerf::cli {

void add_sheet_commands(CLI::App& app, Session& session);
void add_recording_commands(CLI::App& sheet, Session& session);  // `kerf sheet`: record, play
void add_state_commands(CLI::App& sheet, Session& session);      // `kerf sheet`: save, restore, states, forget
void add_settings_commands(CLI::App& sheet, Session& session);   // `kerf sheet`: material, self-contact, speed
void add_interaction_commands(CLI::App& sheet,
                              Session& session);  // `kerf sheet`: grab, drag, release, pins, gravity, wind
void add_cut_command(CLI::App& app, Session& session);
void add_cuts_commands(CLI::App& app, Session& session);  // cuts, undo, redo, pieces
void add_view_commands(CLI::App& app, Session& session);  // render, export, info
void add_images_command(CLI::App& app, Session& session);
void add_inspect_command(CLI::App& app, Session& session);
void add_watch_command(CLI::App& app, Session& session);
void add_offline_commands(CLI::App& app, Session& session);  // run, replay
void add_analyze_command(CLI::App& app, Session& session);
void add_load_command(CLI::App& app, Session& session);
void add_store_commands(CLI::App& app, Session& session);   // `kerf store`: info, prune, delete, backup
void add_token_commands(CLI::App& app, Session& session);   // `kerf token`: new
void add_access_commands(CLI::App& app, Session& session);  // open, access
void add_doctor_commands(CLI::App& app, Session& session);  // version, doctor
void add_shell_commands(CLI::App& app, Session& session);   // completion

// Prints the completions of the last of `words` for a shell; returns an exit code.
int print_completion(const CLI::App& app, const std::vector<std::string>& words, const ServerTarget& server);

struct BatchTiming {
  std::int64_t at_tick = 0;  // Tick at whose start the cuts are made; 0: at once.
  bool is_dry_run = false;   // Computes the cuts without making them.
};
// Applies the cuts of a file (JSON of kerf.v1.CutBatch) to a sheet, in several calls if one cannot hold them. Each call
// makes all of its cuts or none. Returns an exit code.
int cut_batch(const Session& session, const std::string& id, const std::string& file, const BatchTiming& timing);

}  // namespace kerf::cli
