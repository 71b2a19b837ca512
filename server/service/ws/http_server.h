#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/base/result.h"
#include "server/service/ws/access.h"
#include "server/service/ws/asset_table.h"

namespace kerf::api {
class Api;
}  // namespace kerf::api

namespace kerf::ws {

class TlsContext;

struct HttpOptions {
  AccessPolicy access;  // bound_to_loopback, port and is_secure are set by start().
  // Makes the port speak HTTPS; null: plain HTTP.
  std::shared_ptr<TlsContext> tls;
  int threads = 2;                           // 1..64
  int max_connections = 1000;                // Beyond it, new connections are closed at once.
  int max_connections_per_address = 0;       // By one peer; others get 503, or with TLS are closed; 0: no limit.
  std::size_t max_header_bytes = 16 << 10;   // Header of a request.
  std::size_t max_message_bytes = 64 << 10;  // One WebSocket message from a client.
  // From the first byte of a request to its last; also for the handshake of TLS.
  std::chrono::milliseconds request_timeout{5'000};
  std::chrono::milliseconds upload_timeout{120'000};    // Replaces request_timeout for uploads to FileRoutes.
  std::chrono::milliseconds handshake_timeout{5'000};   // WebSocket: opening and closing handshake, each.
  std::chrono::milliseconds idle_timeout{30'000};       // Longest time between two requests of a connection.
  std::chrono::milliseconds silence_timeout{10'000};    // WebSocket: longest time without input, pongs included.
  std::chrono::milliseconds write_timeout{30'000};      // Longest time in which no part of a response is taken.
  std::chrono::milliseconds response_timeout{120'000};  // Longest time for a complete response.
  // MJPEG: the last picture is repeated after this long without a new one.
  std::chrono::milliseconds picture_repeat{15'000};
};

// Holds the transport's counters since its start.
struct HttpCounts {
  std::int64_t connections = 0;          // Accepted.
  std::int64_t open_connections = 0;     // Open now.
  std::int64_t refused_connections = 0;  // Closed at once, over max_connections or without memory.
  std::int64_t refused_by_address = 0;   // Answered 503 or closed, over max_connections_per_address.
  std::int64_t requests = 0;             // Answered.
  std::int64_t failed_requests = 0;      // Answered with a status of 400 or above.
  std::int64_t watch_streams = 0;        // WebSocket handshakes done
  std::int64_t open_watch_streams = 0;   // Open now.
};

// Serves browsers on one TCP port, HTTP/1.1, over TLS if the options say so:
//   GET /...                          the viewer's files; /docs/...: those of the documentation
//   POST /kerf.v1.Service/Method      a unary RPC as JSON; errors as {"code", "message", "details"}; a long call
//                                     (StepSheet) ends early if the client hangs up
//   GET /watch                        WebSocket, subprotocol kerf.v1: StreamService.Watch, each message a binary one
//   GET /images                       WebSocket in the same way: RenderService.WatchImages
//   GET /sheets/ID.png .jpg .mjpeg    one picture, or MJPEG for an <img>: service/ws/picture_query.h
//   GET /healthz /readyz /metrics     alive; taking requests (503 while draining); Prometheus text format
class HttpServer {
 public:
  // `metrics` returns the page of /metrics; it is called from this server's threads. `api` must outlive this.
  HttpServer(api::Api& api, AssetTable assets, std::function<std::string(const HttpCounts&)> metrics,
             HttpOptions options = {});
  ~HttpServer();  // stop() without grace
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Listens at each address of the host; port 0 picks a free one. Returns the port, or UNAVAILABLE ADDRESS_IN_USE if it
  // cannot be bound: two servers never share a port. To be called once.
  Result<int> start(const Endpoint& endpoint);

  // Uses another certificate for connections made from now on. Needs a server that was started with one. Thread-safe.
  void set_tls(std::shared_ptr<TlsContext> tls);

  // Makes /readyz answer 503 from now on; requests are still answered.
  void drain();

  // Refuses new connections, closes idle ones, waits up to `grace` for requests and streams in progress, then closes
  // them; returns when none is left. The Api must have replied to these requests, or must reply without further ones:
  // stop the Host first. Idempotent.
  void stop(std::chrono::milliseconds grace);

  [[nodiscard]] HttpCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::ws
