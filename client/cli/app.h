#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/output.h"

// Defines the `kerf` command as a whole, from which tab completion, the manual and the answers to wrong usage are made.
namespace kerf::cli {

// Makes the app with every subcommand. The subcommand given sets session.action, so `session` must outlive the app.
std::unique_ptr<CLI::App> make_app(Session& session);

// Adds a subcommand whose one argument is the ID of a sheet.
CLI::App* add_sheet_command(CLI::App& app, Session& session, const std::string& name, const std::string& help,
                            std::function<int(const Session&, const std::string&)> action);

// Declares the positional ID of an existing sheet, which tab completion takes from the server.
CLI::Option* add_sheet_id(CLI::App& command, std::string& id);

// Names the values of options, as shown by help and manual; tab completion depends on them.
namespace value {
inline constexpr const char* kSheet = "SHEET";
inline constexpr const char* kMaterial = "MATERIAL";
inline constexpr const char* kFile = "FILE";
inline constexpr const char* kFolder = "FOLDER";
}  // namespace value

// Returns CLI::ExistingDirectory without its type name, which help would show beside "FOLDER".
CLI::Validator existing_folder();

// Headings of the commands in the help and the manual.
namespace group {
inline constexpr const char* kSheets = "Sheets";
inline constexpr const char* kCuts = "Cuts";
inline constexpr const char* kLooks = "Looking at a sheet";
inline constexpr const char* kPhysics = "Running and analysing";
inline constexpr const char* kServer = "Server and shell";
}  // namespace group

// Return the visible commands, options and arguments, in the order of declaration. Options of an option group count as
// the command's own.
std::vector<const CLI::App*> commands_of(const CLI::App& app);
std::vector<const CLI::Option*> options_of(const CLI::App& app);    // --grid
std::vector<const CLI::Option*> arguments_of(const CLI::App& app);  // ID

// Returns the full name, e.g. "kerf sheet create".
std::string full_name(const CLI::App& app);
// Returns the name of an option: "--json", or "-q" if it has no long name.
std::string option_name(const CLI::Option& option);
bool takes_value(const CLI::Option& option);
bool is_repeatable(const CLI::Option& option);
// Returns the first line of a description up to a full stop, colon or semicolon that is not in parentheses.
std::string headline(std::string description);

// Returns the listed values of an option or argument; empty if it has no list.
std::vector<std::string> choices_of(const CLI::Option& option);
// True if the option takes values of `kind`, one of the names in namespace value.
bool has_values(const CLI::Option& option, const std::string& kind);

}  // namespace kerf::cli
