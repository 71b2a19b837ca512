#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/connection.h"
#include "client/cpp/scene.h"
#include "client/cpp/sheet.h"

namespace kerf::client {

struct ServerOptions {
  // How long a call may take before it is DEADLINE_EXCEEDED; a cut may have been made all the same.
  std::chrono::milliseconds timeout = std::chrono::minutes(10);
};

struct CreateOptions {
  std::string id = {};  // [a-z][a-z0-9-]{0,62}; empty: the scene's, else the server chooses
  bool paused = false;
  std::string request_id =
      {};  // at most 64 bytes; a repeat with the same scene gets the same answer and makes nothing more
};

// A Kerf server and its sheets. Nothing is sent before the first call; a server that does not answer is UNAVAILABLE
// then. Sheets outlive it. Thread-safe.
class Server {
 public:
  // address: "HOST:PORT"
  explicit Server(const std::string& address = "127.0.0.1:50051", const ServerOptions& options = {});

  Result<v1::ServerInfo> info();  // version, renderer, limits, material presets
  // A mesh file of up to 64 MiB goes in parts; the rest of a scene may have up to 1 MiB.
  Result<Sheet> create(const v1::Scene& scene, const CreateOptions& options = {});
  // A new sheet that plays a recording (Sheet::recording(), or a file's bytes) live and is paused at its end. id:
  // empty: that of the recording, else the server chooses.
  Result<Sheet> replay(const std::string& recording, const std::string& id = {}, bool paused = false);
  Result<std::vector<Sheet>> sheets();  // by name
  // One that there is; nothing is asked of the server yet.
  [[nodiscard]] Sheet sheet(const std::string& id) const { return {connection_, id}; }

  // The stubs themselves, for what has no method here.
  [[nodiscard]] Client& client() { return connection_->client(); }

 private:
  std::shared_ptr<Connection> connection_;
};

}  // namespace kerf::client
