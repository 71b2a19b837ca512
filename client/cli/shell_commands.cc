// Implements commands for the calling shell.

#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/completion.h"
#include "client/cli/server_names.h"

namespace kerf::cli {
namespace {

int print_script(const Session& session, const std::string& shell) {
  const std::string script = completion_script(shell);
  if (session.json) {
    std::printf("%s\n", nlohmann::ordered_json{{"shell", shell}, {"script", script}}.dump(2).c_str());
  } else {
    std::fputs(script.c_str(), stdout);
  }
  return kDone;
}

}  // namespace

void add_shell_commands(CLI::App& app, Session& session) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("completion",
                                         "Print the script for tab completion of kerf's commands and options.\n"
                                         "Example: source <(kerf completion bash)");
  command->group(group::kServer);
  command->add_option("SHELL", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback(
      [&session, shell] { session.action = [&session, shell] { return print_script(session, *shell); }; });
}

int print_completion(const CLI::App& app, const std::vector<std::string>& words, const ServerTarget& server) {
  const ServerNames names{sheet_ids, material_presets};
  std::fputs(to_lines(complete(app, words, server, names)).c_str(), stdout);
  return kDone;
}

}  // namespace kerf::cli
