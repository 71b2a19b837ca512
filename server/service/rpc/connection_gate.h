#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/base/result.h"

namespace kerf::rpc {

struct GateLimits {
  int max_connections = 1;              // Open at a time, >= 1.
  int max_per_address = 0;              // Per peer (server/base/peer_places.h), >= 0; 0: no limit.
  std::chrono::milliseconds silence{};  // A connection that has sent nothing after this time is closed.
};

struct GateCounts {
  std::int64_t accepted = 0;
  std::int64_t open = 0;                // Open now, those given to gRPC included.
  std::int64_t refused = 0;             // Closed at once, over max_connections.
  std::int64_t refused_by_address = 0;  // Closed at once, over max_per_address.
};

// Listens in place of gRPC, and passes a connection to it once its first byte has come. gRPC itself stops listening for
// good when the process runs out of descriptors. It also holds silent or closed connections for seconds.
class ConnectionGate {
 public:
  // Takes ownership of a connected socket. Called on the gate's thread.
  using Take = std::function<void(int descriptor)>;

  ConnectionGate(const GateLimits& limits, Take take);
  ~ConnectionGate();  // stop()
  ConnectionGate(const ConnectionGate&) = delete;
  ConnectionGate& operator=(const ConnectionGate&) = delete;

  // Binds "HOST:PORT" at each address of HOST; port 0 picks a free one. Returns the port, or UNAVAILABLE
  // ADDRESS_IN_USE. To be called once.
  Result<int> bind(const std::string& address);
  // Accepts the connections made since bind(), and later ones.
  void open();
  // Closes the port and all connections that are still silent. Idempotent.
  void stop();
  [[nodiscard]] GateCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::rpc
