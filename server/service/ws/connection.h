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

// What the connections of a server share. Outlives them all.
struct ConnectionContext {
  api::Api& api;
  const Router& router;
  const HttpOptions& options;
  std::atomic<bool> draining = false;  // streams that end are told that the server goes away

  std::atomic<std::int64_t> requests = 0;
  std::atomic<std::int64_t> failed_requests = 0;
  std::atomic<std::int64_t> watch_streams = 0;
  std::atomic<std::int64_t> open_watch_streams = 0;
};

// One client's TCP connection, until it is closed. Its socket's executor must be a strand.
class Connection {
 public:
  virtual ~Connection() = default;

  // Serves it; `done` is called once, when it is closed, on its strand. Keeps itself alive until then.
  virtual void run(std::function<void()> done) = 0;
  // From any thread: closes it now if it waits for a request, else as soon as the request or stream under way has
  // ended.
  virtual void finish() = 0;
  // From any thread: closes it now, whatever is under way.
  virtual void abort() = 0;
};

std::shared_ptr<Connection> make_connection(ConnectionContext& context, boost::asio::ip::tcp::socket socket);

}  // namespace kerf::ws
