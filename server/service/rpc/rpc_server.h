#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "server/base/result.h"
#include "server/service/host/clock.h"
#include "server/service/rpc/connection_gate.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::rpc {

// Holds what TLS needs, as PEM texts.
struct RpcTls {
  std::string certificate_chain;  // The server's own certificate first.
  std::string key;                // The private key of that certificate, without a password.
  // Certificates of authorities. A client must show a certificate of one of these; empty: it needs none.
  std::string client_authorities;
};

struct RpcOptions {
  std::optional<RpcTls> tls;                            // Nothing: the port does not speak TLS.
  int max_connections = 10'000;                         // Beyond it, new connections are closed at once.
  int max_connections_per_address = 0;                  // Limit on the connections of one peer, >= 0; 0: no limit.
  std::chrono::milliseconds first_byte_timeout{5'000};  // A connection that has sent nothing after this time is closed.
  int max_streams_per_connection = 100;                 // HTTP/2 streams, 1..10000.
  std::chrono::milliseconds keepalive_interval{20'000};  // A silent connection is pinged after this long.
  std::chrono::milliseconds keepalive_timeout{10'000};  // A connection is dropped if its answer to a ping takes longer.
  // Limits on uploads and on recordings being fetched: longest time without progress, and from beginning to end.
  std::chrono::milliseconds transfer_silence_timeout{30'000};
  std::chrono::milliseconds transfer_timeout{120'000};
  // Limit on gRPC's buffers of all connections together; near it gRPC drops idle connections, then calls.
  std::size_t max_buffer_bytes = std::size_t{512} << 20;
  int max_reflection_threads = 32;  // One for each stream of ServerReflectionInfo.
};

// Serves every service of kerf.v1, grpc.health.v1.Health and server reflection over gRPC on one port. Requests larger
// than the Api's limit are refused with RESOURCE_EXHAUSTED.
class RpcServer {
 public:
  // `api` and `clock` must outlive this. `clock` times transfers and stalled readers.
  RpcServer(api::Api& api, host::Clock& clock, const RpcOptions& options = {});
  ~RpcServer();  // stop() without grace
  RpcServer(const RpcServer&) = delete;
  RpcServer& operator=(const RpcServer&) = delete;

  // Listens at "HOST:PORT"; port 0 picks a free one. To be called once. Returns the port, or UNAVAILABLE ADDRESS_IN_USE
  // if it cannot be bound: two servers never share a port. A wrong RpcTls is INTERNAL.
  Result<int> start(const std::string& address);

  // Makes Health report NOT_SERVING from now on; calls are still answered.
  void drain();

  // Refuses new calls, waits up to `grace` for those in progress, cancels the rest, and returns when none is left. The
  // Api must have replied to these calls, or must reply without further requests: stop the Host first. Idempotent.
  void stop(std::chrono::milliseconds grace);

  [[nodiscard]] GateCounts connections() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::rpc
