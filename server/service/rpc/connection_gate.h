#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/base/result.h"

namespace kerf::rpc {

struct GateLimits {
  int max_connections = 1;              // open at a time, >= 1
  int max_per_address = 0;              // for each peer (server/base/peer_places.h), >= 0; 0: no limit
  std::chrono::milliseconds silence{};  // a connection that says nothing for so long is closed
};

struct GateCounts {
  std::int64_t accepted = 0;
  std::int64_t open = 0;                // now
  std::int64_t refused = 0;             // closed at once, over max_connections
  std::int64_t refused_by_address = 0;  // closed at once, over max_per_address
};

// Listens in gRPC's place, and hands a connection over once its first byte has come. gRPC stops listening for good when
// the process runs out of descriptors, and holds connections for seconds that say nothing or are closed already.
class ConnectionGate {
 public:
  // Takes a connected socket over, to close it in the end. Called on the gate's thread.
  using Take = std::function<void(int descriptor)>;

  ConnectionGate(const GateLimits& limits, Take take);
  ~ConnectionGate();  // stop()
  ConnectionGate(const ConnectionGate&) = delete;
  ConnectionGate& operator=(const ConnectionGate&) = delete;

  // Binds "HOST:PORT" at each address of HOST; port 0 picks a free one. Returns the port, or UNAVAILABLE
  // ADDRESS_IN_USE. To be called once.
  Result<int> bind(const std::string& address);
  // Begins to accept what has connected since bind().
  void open();
  // Closes the port and what has said nothing yet. Idempotent.
  void stop();
  [[nodiscard]] GateCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::rpc
