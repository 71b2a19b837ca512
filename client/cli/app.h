#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/output.h"

// The `kerf` command as a whole: what of it tab completion, the manual and the answers to wrong usage are made from.
namespace kerf::cli {

// With every subcommand. The one that is given sets session.action, so `session` must outlive the app.
std::unique_ptr<CLI::App> make_app(Session& session);

// A subcommand whose one argument is the ID of a sheet.
CLI::App* add_sheet_command(CLI::App& app, Session& session, const std::string& name, const std::string& help,
                            std::function<int(const Session&, const std::string&)> action);

// Declares the positional ID of an existing sheet, which tab completion asks the server for.
CLI::Option* add_sheet_id(CLI::App& command, std::string& id);

// What an option takes, as help and manual show it. Tab completion goes by it.
namespace value {
inline constexpr const char* kSheet = "SHEET";
inline constexpr const char* kMaterial = "MATERIAL";
inline constexpr const char* kFile = "FILE";
inline constexpr const char* kFolder = "FOLDER";
}  // namespace value

// CLI::ExistingDirectory, which says "FOLDER" once.
CLI::Validator existing_folder();

// Headings of the commands in the help and the manual.
namespace group {
inline constexpr const char* kSheets = "Sheets";
inline constexpr const char* kCuts = "Cuts";
inline constexpr const char* kLooks = "Looking at a sheet";
inline constexpr const char* kPhysics = "Running and analysing";
inline constexpr const char* kServer = "Server and shell";
}  // namespace group

// What there is for people to see, in the order of declaration: nothing hidden, and the options of an option group as
// if they were the command's own.
std::vector<const CLI::App*> commands_of(const CLI::App& app);
std::vector<const CLI::Option*> options_of(const CLI::App& app);    // --grid
std::vector<const CLI::Option*> arguments_of(const CLI::App& app);  // ID

// "kerf sheet create"
std::string full_name(const CLI::App& app);
// "--json", or "-q" where there is no long name.
std::string option_name(const CLI::Option& option);
bool takes_value(const CLI::Option& option);
bool is_repeatable(const CLI::Option& option);
// What a command or an option says of itself, up to the first full stop, colon or semicolon.
std::string headline(std::string description);

// The values that an option or argument may have, where it lists them; empty otherwise.
std::vector<std::string> choices_of(const CLI::Option& option);
// Whether its values are of this kind, one of `value`.
bool has_values(const CLI::Option& option, const std::string& kind);

}  // namespace kerf::cli
