#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/scene.h"
#include "client/cpp/sheet.h"

namespace kerf::client {

class Connection;

struct ServerOptions {
  // Time after which a call fails with DEADLINE_EXCEEDED; a cut may still have been made.
  std::chrono::milliseconds timeout = std::chrono::minutes(10);
  Credentials credentials = {};  // For a server that asks for a token, or for TLS.
};

struct CreateOptions {
  std::string id = {};  // [a-z][a-z0-9-]{0,62}; empty: the ID in the scene; without one, the server chooses.
  bool paused = false;
  std::string request_id =
      {};  // At most 64 bytes; a repeat with the same scene gets the same answer and makes nothing more.
};

struct LinkOptions {
  v1::Scope scope = v1::SCOPE_VIEW;  // At most that of the caller.
  std::string sheet_id = {};         // The one sheet that it reaches; empty: those of the caller.
  std::chrono::seconds lifetime{0};  // For how long logins last, 60..604,800 s; 0: 8 hours.
  bool once = false;                 // It opens once, within 60 s, and the login then lasts for `lifetime`.
};

// Represents a Kerf server and its sheets. Nothing is sent before the first call, which fails with UNAVAILABLE if the
// server does not answer. Sheets live on after the object is destroyed. Thread-safe.
class Server {
 public:
  // `address`: "HOST:PORT". Throws CallFailed if the credentials cannot be used, as Client does.
  explicit Server(const std::string& address = "127.0.0.1:50051", const ServerOptions& options = {});

  Result<v1::ServerInfo> info();  // Version, renderer, limits, material presets.
  // Creates a sheet. A mesh file of up to 64 MiB is sent in parts; the rest of a scene may have up to 1 MiB.
  Result<Sheet> create(const v1::Scene& scene, const CreateOptions& options = {});
  // Creates a sheet that plays a recording (Sheet::recording(), or a file's bytes) live and pauses at its end. An empty
  // `id` means the ID in the recording; without one, the server chooses.
  Result<Sheet> replay(const std::string& recording, const std::string& id = {}, bool paused = false);
  Result<std::vector<Sheet>> sheets();  // Sorted by name.
  // Refers to an existing sheet, without a call to the server.
  [[nodiscard]] Sheet sheet(const std::string& id) const;

  // The store of a server with a data folder; else FAILED_PRECONDITION NO_STORE.
  Result<v1::StoreInfo> store_info();  // Counts, sheets that were set aside, backups.
  Result<v1::PruneStoreResponse> prune_store();
  Result<Done> delete_set_aside(std::int64_t number);  // One of StoreInfo.set_aside, for good.
  // Copies the store into a folder of this id, [a-z0-9][a-z0-9-]{0,62}, in the server's folder of backups.
  Result<v1::StoreBackup> backup_store(const std::string& backup_id);

  Result<v1::Access> access();  // Scope, sheets and end of the caller's token.
  // Makes a link that logs in whoever opens the viewer with it. FAILED_PRECONDITION NO_TOKENS if the server asks for no
  // token; access_service.proto has the other errors.
  Result<v1::AccessLink> create_link(const LinkOptions& options = {});

  // Returns the client with all stubs, for calls that have no method here.
  [[nodiscard]] Client& client();

 private:
  std::shared_ptr<Connection> connection_;
};

}  // namespace kerf::client
