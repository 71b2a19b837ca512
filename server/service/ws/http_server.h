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

struct HttpOptions {
  AccessPolicy access;                                  // bound_to_loopback and port are set by start()
  int threads = 2;                                      // 1..64
  int max_connections = 1000;                           // beyond it, new connections are closed at once
  int max_connections_per_address = 0;                  // beyond it, of one peer, they are answered 503; 0: no limit
  std::size_t max_header_bytes = 16 << 10;              // of a request
  std::size_t max_message_bytes = 64 << 10;             // of one WebSocket message from a client
  std::chrono::milliseconds request_timeout{5'000};     // from the first byte of a request to its last
  std::chrono::milliseconds upload_timeout{120'000};    // the same of a request with a file of FileRoutes
  std::chrono::milliseconds handshake_timeout{5'000};   // WebSocket opening and closing handshakes
  std::chrono::milliseconds idle_timeout{30'000};       // a kept-alive connection between requests
  std::chrono::milliseconds silence_timeout{10'000};    // WebSocket: without a sign of life, a pong included
  std::chrono::milliseconds write_timeout{30'000};      // of a response of which nothing is taken
  std::chrono::milliseconds response_timeout{120'000};  // one whole response
  std::chrono::milliseconds picture_repeat{15'000};  // MJPEG: the last picture is sent again after so long without one
};

// What the transport has counted since it started.
struct HttpCounts {
  std::int64_t connections = 0;          // accepted
  std::int64_t open_connections = 0;     // now
  std::int64_t refused_connections = 0;  // closed at once, over max_connections
  std::int64_t refused_by_address = 0;   // answered 503 or closed, over max_connections_per_address
  std::int64_t requests = 0;             // answered
  std::int64_t failed_requests = 0;      // answered with a status of 400 or above
  std::int64_t watch_streams = 0;        // WebSocket handshakes done
  std::int64_t open_watch_streams = 0;   // now
};

// The browser's transport on one TCP port, HTTP/1.1 without TLS:
//   GET /...                          the viewer's files
//   POST /kerf.v1.Service/Method      a unary RPC as JSON; errors as {"code", "message", "details"}. Ends sooner,
//                                     where it may go on for long (StepSheet), if the client hangs up
//   GET /watch                        WebSocket, subprotocol kerf.v1: StreamService.Watch, a message a binary message
//   GET /images                       the same: RenderService.WatchImages
//   GET /sheets/ID.png .jpg .mjpeg    one picture, or MJPEG for an <img>: service/ws/picture_query.h
//   GET /healthz /readyz /metrics     alive; taking requests (503 while draining); Prometheus text format
class HttpServer {
 public:
  // `metrics` gives the page of /metrics; it is called from this server's threads. `api` must outlive this.
  HttpServer(api::Api& api, AssetTable assets, std::function<std::string(const HttpCounts&)> metrics,
             HttpOptions options = {});
  ~HttpServer();  // stop() without grace
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Listens at each address of the host; port 0 picks a free one. Returns the port it got, or UNAVAILABLE
  // ADDRESS_IN_USE where it cannot be bound: two servers never share a port. To be called once.
  Result<int> start(const Endpoint& endpoint);

  // /readyz says 503 from now on; requests are still answered.
  void drain();

  // Accepts no more connections, closes idle ones, waits up to `grace` for requests and streams under way, then cuts
  // them off; returns when none is left. Idempotent. The replies that the Api owes for requests under way must have
  // come or come by themselves.
  void stop(std::chrono::milliseconds grace);

  [[nodiscard]] HttpCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::ws
