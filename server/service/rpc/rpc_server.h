#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "server/base/result.h"
#include "server/service/host/clock.h"
#include "server/service/rpc/connection_gate.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::rpc {

struct RpcOptions {
  int max_connections = 10'000;                          // beyond it, new connections are closed at once
  int max_connections_per_address = 0;                   // the same for each peer, >= 0; 0: no limit
  std::chrono::milliseconds first_byte_timeout{5'000};   // a connection that says nothing for so long is closed
  int max_streams_per_connection = 100;                  // HTTP/2 streams, 1..10000
  std::chrono::milliseconds keepalive_interval{20'000};  // a silent connection is pinged after this long ...
  std::chrono::milliseconds keepalive_timeout{10'000};   // ... and dropped when the answer takes longer than this
  // Of uploads, and of recordings that are fetched: nothing moves for this long, and from beginning to end.
  std::chrono::milliseconds transfer_silence_timeout{30'000};
  std::chrono::milliseconds transfer_timeout{120'000};
  // For gRPC's buffers, of all connections together; under pressure it drops idle connections, then calls.
  std::size_t max_buffer_bytes = std::size_t{512} << 20;
  int max_reflection_threads = 32;  // one for each stream of ServerReflectionInfo
};

// The gRPC transport: every service of kerf.v1, grpc.health.v1.Health and server reflection on one port, without TLS.
// Requests larger than the Api's limit are refused with RESOURCE_EXHAUSTED.
class RpcServer {
 public:
  // `api` and `clock`, that of transfers and readers that stand still, must outlive this.
  RpcServer(api::Api& api, host::Clock& clock, const RpcOptions& options = {});
  ~RpcServer();  // stop() without grace
  RpcServer(const RpcServer&) = delete;
  RpcServer& operator=(const RpcServer&) = delete;

  // Listens at "HOST:PORT"; port 0 picks a free one. The port it got, or UNAVAILABLE ADDRESS_IN_USE where it cannot be
  // bound: two servers never share a port. Once.
  Result<int> start(const std::string& address);

  // Health says NOT_SERVING from now on; calls are still answered.
  void drain();

  // Accepts no more calls, waits up to `grace` for those under way, then cancels them; returns when none is left.
  // Idempotent. The replies that the Api owes for calls under way must have come or come by themselves.
  void stop(std::chrono::milliseconds grace);

  [[nodiscard]] GateCounts connections() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::rpc
