#include "client/cli/app.h"

#include <algorithm>
#include <functional>
#include <sstream>
#include <string_view>
#include <utility>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/commands.h"

namespace kerf::cli {
namespace {

// Formats the help like CLI11, but with one line per command.
class Help : public CLI::Formatter {
 public:
  Help() { column_width(26); }
  std::string make_subcommand(const CLI::App* command) const override {
    std::ostringstream out;
    CLI::detail::format_help(out, command->get_name(), headline(command->get_description()), get_column_width());
    return out.str();
  }
};

// Calls `visit` with the app and its option groups, which CLI11 keeps as commands without a name.
template <typename Visit>
void visit_groups(const CLI::App& app, const Visit& visit) {
  visit(app);
  for (const CLI::App* group : app.get_subcommands([](const CLI::App* each) { return each->get_name().empty(); })) {
    visit_groups(*group, visit);
  }
}

std::vector<const CLI::Option*> visible(const CLI::App& app, bool positional) {
  std::vector<const CLI::Option*> found;
  visit_groups(app, [&](const CLI::App& group) {
    for (const CLI::Option* option : group.get_options()) {
      // Skips the --help of an option group, which duplicates the command's.
      if (&group != &app && option == group.get_help_ptr()) continue;
      if (option->get_positional() == positional && !option->get_group().empty()) found.push_back(option);
    }
  });
  return found;
}

// Splits "TEXT:{top,corners}:FILE" into the type of the value and the text of each validator.
std::vector<std::string> kinds_of(const CLI::Option& option) {
  std::vector<std::string> kinds;
  std::istringstream parts(option.get_type_name());
  for (std::string part; std::getline(parts, part, ':');) kinds.push_back(part);
  return kinds;
}

void add_credentials(CLI::App& app, client::Credentials& credentials) {
  app.add_option("--token-file", credentials.token_file,
                 "File with the token that the server asks for, one line (or the environment KERF_TOKEN_FILE)")
      ->type_name(value::kFile);
  app.add_flag("--tls", credentials.use_tls, "Use TLS; the authorities that the system trusts are trusted");
  app.add_option("--tls-ca", credentials.tls_ca,
                 "File with the authorities to trust instead, PEM (or KERF_TLS_CA); use TLS")
      ->type_name(value::kFile);
  app.add_option("--tls-cert", credentials.tls_cert,
                 "File with the certificate to show to the server, PEM (or KERF_TLS_CERT); use TLS")
      ->type_name(value::kFile);
  app.add_option("--tls-key", credentials.tls_key, "File with the key of that certificate, PEM (or KERF_TLS_KEY)")
      ->type_name(value::kFile);
}

}  // namespace

std::unique_ptr<CLI::App> make_app(Session& session) {
  auto made = std::make_unique<CLI::App>(
      "kerf: cut, watch and run elastic sheets. Start a server with kerfd (or deploy/run).", "kerf");
  CLI::App& app = *made;
  app.formatter(std::make_shared<Help>());
  app.get_help_ptr()->description("Print this help and exit");
  app.set_version_flag("--version", std::string("kerf ") + KERF_VERSION, "Print the version and exit");
  app.add_option("--server", session.server.address,
                 "Server's gRPC address (or the environment KERF_SERVER); port 50051 unless given")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  add_credentials(app, session.server.credentials);
  app.add_flag("--json", session.json,
               "Print replies as JSON; a refusal is {\"error\": {code, reason, message, field}} on stderr");
  app.add_flag("-q,--quiet", session.quiet, "No progress bars and no status line");
  app.add_flag("-v,--verbose", session.verbose, "Also print the measurements and counts of the server");
  app.fallthrough();  // These may also follow the subcommand.
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done (a cut that misses included), 1 refused with the reason on stderr, 2 wrong usage.\n"
      "`kerf load --fail-if` has 3 and 4 besides, `kerf doctor` 3.\n"
      "Help on a command: kerf COMMAND --help. All of it: man kerf");

  add_sheet_commands(app, session);
  add_cut_command(app, session);
  add_cuts_commands(app, session);
  add_inspect_command(app, session);
  add_watch_command(app, session);
  add_view_commands(app, session);
  add_images_command(app, session);
  add_analyze_command(app, session);
  add_offline_commands(app, session);
  add_load_command(app, session);
  add_store_commands(app, session);
  add_token_commands(app, session);
  add_access_commands(app, session);
  add_doctor_commands(app, session);
  add_shell_commands(app, session);
  return made;
}

CLI::App* add_sheet_command(CLI::App& app, Session& session, const std::string& name, const std::string& help,
                            std::function<int(const Session&, const std::string&)> action) {
  const auto id = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(name, help);
  add_sheet_id(*command, *id);
  command->callback([&session, id, action = std::move(action)] {
    session.action = [&session, id, action] { return action(session, *id); };
  });
  return command;
}

CLI::Option* add_sheet_id(CLI::App& command, std::string& id) {
  return command.add_option("ID", id, "Name of the sheet")->required()->type_name(value::kSheet);
}

CLI::Validator existing_folder() {
  return CLI::Validator(CLI::ExistingDirectory).description("");
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands(
      [](const CLI::App* each) { return !each->get_name().empty() && !each->get_group().empty(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return visible(app, false);
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& app) {
  return visible(app, true);
}

std::string full_name(const CLI::App& app) {
  return app.get_parent() == nullptr ? app.get_name() : full_name(*app.get_parent()) + " " + app.get_name();
}

std::string option_name(const CLI::Option& option) {
  if (!option.get_lnames().empty()) return "--" + option.get_lnames().front();
  return option.get_snames().empty() ? option.get_name(true) : "-" + option.get_snames().front();
}

bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

bool is_repeatable(const CLI::Option& option) {
  return option.get_items_expected_max() > 1;
}

std::string headline(std::string description) {
  description = description.substr(0, description.find('\n'));
  int depth = 0;  // A pause within parentheses is not the end.
  for (std::size_t i = 0; i + 1 < description.size(); ++i) {
    if (description[i] == '(') ++depth;
    if (description[i] == ')') --depth;
    const bool is_pause = std::string_view(".:;").find(description[i]) != std::string_view::npos;
    if (is_pause && description[i + 1] == ' ' && depth == 0) return description.substr(0, i);
  }
  if (description.ends_with('.')) description.pop_back();
  return description;
}

std::vector<std::string> choices_of(const CLI::Option& option) {
  std::vector<std::string> choices;
  for (const std::string& kind : kinds_of(option)) {
    if (kind.size() < 2 || kind.front() != '{' || kind.back() != '}') continue;
    std::istringstream list(kind.substr(1, kind.size() - 2));
    for (std::string choice; std::getline(list, choice, ',');) choices.push_back(choice);
  }
  return choices;
}

bool has_values(const CLI::Option& option, const std::string& kind) {
  const std::vector<std::string> kinds = kinds_of(option);
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

}  // namespace kerf::cli
