#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/scene.h"
#include "client/cpp/sheet.h"

namespace kerf::client {

class Client;
class Connection;

struct ServerOptions {
  // Time after which a call fails with DEADLINE_EXCEEDED; a cut may still have been made.
  std::chrono::milliseconds timeout = std::chrono::minutes(10);
};

struct CreateOptions {
  std::string id = {};  // [a-z][a-z0-9-]{0,62}; empty: the ID in the scene; without one, the server chooses.
  bool paused = false;
  std::string request_id =
      {};  // At most 64 bytes; a repeat with the same scene gets the same answer and makes nothing more.
};

// Represents a Kerf server and its sheets. Nothing is sent before the first call, which fails with UNAVAILABLE if the
// server does not answer. Sheets live on after the object is destroyed. Thread-safe.
class Server {
 public:
  // `address`: "HOST:PORT".
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

  // Returns the client with all stubs, for calls that have no method here.
  [[nodiscard]] Client& client();

 private:
  std::shared_ptr<Connection> connection_;
};

}  // namespace kerf::client
