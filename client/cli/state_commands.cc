// Implements `kerf sheet`: save, restore, states, forget.

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/arguments.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/output.h"
#include "client/cpp/client.h"

namespace kerf::cli {
namespace {

struct StateArguments {
  std::string id;
  std::string state;
  bool overwrite = false;

  [[nodiscard]] std::string name() const { return "sheets/" + id + "/states/" + state; }
};

std::string describe(const v1::SavedState& state) {
  std::array<char, 64> size{};
  std::snprintf(size.data(), size.size(), "%.1f MB", 1e-6 * static_cast<double>(state.num_bytes()));
  return state.name() + ": tick " + std::to_string(state.tick()) + ", " + std::to_string(state.num_vertices()) +
         " vertices, " + size.data() + ", saved " + time_of(state.saved_unix_us()) + ", state " + state.state_hash();
}

int save_state(const Session& session, const StateArguments& arguments) {
  client::Client client = connect(session.server);
  v1::SaveStateRequest request;
  request.set_parent("sheets/" + arguments.id);
  request.set_state_id(arguments.state);
  request.set_overwrite(arguments.overwrite);
  v1::SavedState saved;
  const grpc::Status status = client.call(&v1::SheetService::Stub::SaveState, client.sheets(), request, saved);
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s\n", session.json ? to_script_json(saved).c_str() : describe(saved).c_str());
  return kDone;
}

int restore_state(const Session& session, const StateArguments& arguments) {
  client::Client client = connect(session.server);
  v1::RestoreStateRequest request;
  request.set_name(arguments.name());
  v1::Sheet sheet;
  const grpc::Status status = client.call(&v1::SheetService::Stub::RestoreState, client.sheets(), request, sheet);
  if (!status.ok()) return refuse(status, session.server);
  print(session, sheet);
  return kDone;
}

int list_states(const Session& session, const std::string& id) {
  client::Client client = connect(session.server);
  v1::ListStatesRequest request;
  request.set_parent("sheets/" + id);
  v1::ListStatesResponse all;
  const grpc::Status status = client.call(&v1::SheetService::Stub::ListStates, client.sheets(), request, all);
  if (!status.ok()) return refuse(status, session.server);
  if (session.json) {
    std::printf("%s\n", to_script_json(all).c_str());
  } else if (all.states().empty()) {
    std::printf("no saved states\n");
  } else {
    for (const v1::SavedState& state : all.states()) std::printf("%s\n", describe(state).c_str());
  }
  return kDone;
}

int forget_state(const Session& session, const StateArguments& arguments) {
  client::Client client = connect(session.server);
  v1::DeleteStateRequest request;
  request.set_name(arguments.name());
  google::protobuf::Empty nothing;
  const grpc::Status status = client.call(&v1::SheetService::Stub::DeleteState, client.sheets(), request, nothing);
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s\n", session.json ? to_script_json(nothing).c_str() : (arguments.name() + " deleted").c_str());
  return kDone;
}

using StateCommand = int (*)(const Session&, const StateArguments&);

// Adds a command on a sheet and one of its states.
CLI::App* add_state_command(CLI::App& sheet, Session& session, const std::string& name, const std::string& description,
                            const std::shared_ptr<StateArguments>& arguments, StateCommand run) {
  CLI::App* command = sheet.add_subcommand(name, description);
  add_sheet_id(*command, arguments->id);
  command
      ->add_option("NAME", arguments->state,
                   "Name of the state: small letters, digits and hyphens, beginning with a letter")
      ->required();
  command->callback(
      [&session, arguments, run] { session.action = [&session, arguments, run] { return run(session, *arguments); }; });
  return command;
}

}  // namespace

void add_state_commands(CLI::App& sheet, Session& session) {
  const auto saved = std::make_shared<StateArguments>();
  add_state_command(sheet, session, "save",
                    "Save a sheet's state under a name, on the server\nExample: kerf sheet save demo before", saved,
                    save_state)
      ->add_flag("--overwrite", saved->overwrite, "Replace a state of this name");
  add_state_command(sheet, session, "restore",
                    "Bring a saved state back, bit for bit; `kerf undo` does not take that back",
                    std::make_shared<StateArguments>(), restore_state);
  add_sheet_command(sheet, session, "states", "List the saved states of a sheet", list_states);
  add_state_command(sheet, session, "forget", "Delete a saved state; the sheet stays as it is",
                    std::make_shared<StateArguments>(), forget_state);
}

}  // namespace kerf::cli
