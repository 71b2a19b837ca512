// Implements `kerf store`: info, prune, delete, backup.

#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/app.h"
#include "client/cli/commands.h"
#include "client/cli/connect.h"
#include "client/cli/output.h"
#include "client/cli/progress.h"
#include "client/cpp/client.h"

namespace kerf::cli {
namespace {

constexpr std::chrono::minutes kBackupLimit{60};

std::string megabytes(std::int64_t bytes) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.1f MB", 1e-6 * static_cast<double>(bytes));
  return text.data();
}

std::string counted(std::int64_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string describe(const v1::StoreInfo& info) {
  std::string text = info.folder() + ": " + counted(info.sheets(), "sheet") + ", " +
                     std::to_string(info.set_aside_size()) + " set aside\n";
  const auto line = [&text](const char* name, const std::string& value) { text += name + value + "\n"; };
  line("  changes   ", std::to_string(info.changes()) + ", " + megabytes(info.change_bytes()));
  line("  states    ", std::to_string(info.states()) + ", " + megabytes(info.state_bytes()));
  line("  answers   ", std::to_string(info.answers()));
  line("  database  ", megabytes(info.database_bytes()));
  line("  waiting   ", counted(info.waiting_changes(), "change") + ", " + megabytes(info.waiting_bytes()));
  line("  backups   ", std::to_string(info.backup_ids_size()) + " of " + std::to_string(info.max_backups()) + " in " +
                           info.backups_folder());
  for (const std::string& id : info.backup_ids()) line("    ", id);
  for (const v1::SetAsideSheet& sheet : info.set_aside()) {
    line("  set aside: ", sheet.sheet_id() + " (number " + std::to_string(sheet.number()) + "): " + sheet.reason());
  }
  if (info.set_aside_size() > 0) {
    text +=
        "    The server does not start these, and keeps them. An older backup may have them whole: kerfd\n"
        "    --restore-store BACKUP --data DIR. `kerf store delete NUMBER` deletes one for good.\n";
  }
  return text;
}

std::string describe(const v1::PruneStoreResponse& pruned) {
  return "removed " + counted(pruned.removed_answers(), "old answer") + " and the rest of " +
         counted(pruned.removed_sheets(), "deleted sheet") + "\n";
}

std::string describe(const v1::StoreBackup& backup) {
  return backup.folder() + ": " + megabytes(backup.num_bytes()) + "\n";
}

std::string describe(const google::protobuf::Empty& /*nothing*/) {
  return "deleted\n";
}

// Makes a call of the store and prints the answer.
template <typename Request, typename Response>
int ask(const Session& session,
        grpc::Status (v1::StoreService::Stub::*method)(grpc::ClientContext*, const Request&, Response*),
        const Request& request, const char* doing) {
  client::Client client = connect(session.server);
  Response response;
  const grpc::Status status = [&] {
    const WaitingNote note(session, doing);
    return client.call(method, client.store(), request, response, kBackupLimit);
  }();
  if (!status.ok()) return refuse(status, session.server);
  std::printf("%s", session.json ? (to_script_json(response) + "\n").c_str() : describe(response).c_str());
  return kDone;
}

}  // namespace

void add_store_commands(CLI::App& app, Session& session) {
  CLI::App* store = app.add_subcommand("store", "Look after the sheets that the server keeps in its data folder");
  store->group(group::kServer);
  store->require_subcommand(1);
  CLI::App* info =
      store->add_subcommand("info", "Show what is kept, the backups, and sheets set aside with the reasons");
  info->callback([&session] {
    session.action = [&session] {
      return ask(session, &v1::StoreService::Stub::GetStoreInfo, v1::GetStoreInfoRequest(), "looking");
    };
  });
  CLI::App* prune = store->add_subcommand("prune", "Remove old answers and what deleted sheets have left");
  prune->callback([&session] {
    session.action = [&session] {
      return ask(session, &v1::StoreService::Stub::PruneStore, v1::PruneStoreRequest(), "removing");
    };
  });
  const auto number = std::make_shared<std::int64_t>(0);
  CLI::App* remove = store->add_subcommand(
      "delete", "Delete a sheet that was set aside, for good; make a backup before if it may still be needed");
  remove->add_option("NUMBER", *number, "Its number, which `kerf store info` shows")->required();
  remove->callback([&session, number] {
    session.action = [&session, number] {
      v1::DeleteSetAsideSheetRequest request;
      request.set_number(*number);
      return ask(session, &v1::StoreService::Stub::DeleteSetAsideSheet, request, "deleting");
    };
  });
  const auto id = std::make_shared<std::string>();
  CLI::App* backup = store->add_subcommand(
      "backup",
      "Copy all that is kept into a new folder on the server's machine, while it runs; kerfd --restore-store BACKUP "
      "--data DIR makes a data folder of it\nExample: kerf store backup monday");
  backup
      ->add_option("ID", *id,
                   "Name of the backup: small letters, digits and hyphens, beginning with a letter or a digit")
      ->required();
  backup->callback([&session, id] {
    session.action = [&session, id] {
      v1::BackupStoreRequest request;
      request.set_backup_id(*id);
      return ask(session, &v1::StoreService::Stub::BackupStore, request, "copying");
    };
  });
}

}  // namespace kerf::cli
