#pragma once

#include <utility>

#include <boost/asio/ip/tcp.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include "server/service/ws/http_server.h"
#include "server/service/ws/router.h"

namespace kerf::ws {

// Holds the state shared by the connections of a server. Outlives them all.
struct ConnectionContext {
  api::Api& api;
  const Router& router;
  const HttpOptions& options;
  bool is_only_secure = false;  // Browsers are to use https alone for this host. Set before the first connection.
  std::atomic<bool> draining = false;  // Streams that end close with "going away".

  std::atomic<std::int64_t> requests = 0;
  std::atomic<std::int64_t> failed_requests = 0;
  std::atomic<std::int64_t> watch_streams = 0;
  std::atomic<std::int64_t> open_watch_streams = 0;
};

// Serves one client's connection until it is closed. Its socket's executor must be a strand.
class Connection {
 public:
  virtual ~Connection() = default;

  // Serves the connection and keeps itself alive until it is closed. `done` is then called once, on its strand.
  virtual void run(std::function<void()> done) = 0;
  // Closes the connection now if it waits for a request, else once the request or stream in progress has ended.
  // Callable from any thread.
  virtual void finish() = 0;
  // Closes the connection now, interrupting any work. Callable from any thread.
  virtual void abort() = 0;
};

// `tls` may be null: the connection is plain TCP then.
std::shared_ptr<Connection> make_connection(ConnectionContext& context, boost::asio::ip::tcp::socket socket,
                                            const std::shared_ptr<TlsContext>& tls);

}  // namespace kerf::ws
