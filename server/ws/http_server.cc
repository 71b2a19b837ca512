#include "server/ws/http_server.h"

#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>

#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "server/api/api.h"
#include "server/ws/connection.h"
#include "server/ws/router.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptRetry{100};

Error cannot_listen(const Endpoint& endpoint, const boost::system::error_code& error) {
  const bool taken = error == asio::error::address_in_use;
  return {ErrorCode::kUnavailable,
          taken ? "ADDRESS_IN_USE" : "CANNOT_LISTEN",
          "cannot listen on " + format_endpoint(endpoint.host, endpoint.port) + " for HTTP: " + error.message() +
              (taken ? "; stop the other program or choose another --http port" : ""),
          {}};
}

}  // namespace

struct HttpServer::Impl {
  Impl(api::Api& api, AssetTable assets, std::function<std::string(const HttpCounts&)> metrics, HttpOptions chosen)
      : options(std::move(chosen)),
        router(api, std::move(assets), [this, metrics = std::move(metrics)] { return metrics(counts()); }),
        context{api, router, options} {}

  Result<int> start(const Endpoint& endpoint);
  void accept_next();
  void admit(tcp::socket socket);
  void drain();
  void stop(std::chrono::milliseconds grace);
  HttpCounts counts() const;

  const HttpOptions options;
  Router router;
  ConnectionContext context;
  asio::io_context io;
  tcp::acceptor acceptor{asio::make_strand(io)};
  asio::steady_timer accept_retry{acceptor.get_executor()};
  std::vector<std::thread> threads;

  mutable std::mutex mutex;  // of what follows
  std::condition_variable all_closed;
  std::map<std::int64_t, std::shared_ptr<Connection>> connections;  // by order of arrival
  std::int64_t accepted = 0;
  std::int64_t refused = 0;
  bool stopped = false;
};

Result<int> HttpServer::Impl::start(const Endpoint& endpoint) {
  boost::system::error_code error;
  const tcp::resolver::results_type addresses =
      tcp::resolver(io).resolve(endpoint.host, std::to_string(endpoint.port), tcp::resolver::passive, error);
  if (error || addresses.empty()) return cannot_listen(endpoint, error);
  const tcp::endpoint address = *addresses.begin();
  acceptor.open(address.protocol(), error);
  // Lets a restarted server have its port back at once; a port that somebody listens on is still refused.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(address, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) return cannot_listen(endpoint, error);
  AccessPolicy access = options.access;
  access.bound_to_loopback = address.address().is_loopback();
  router.set_access(std::move(access));
  const int port = acceptor.local_endpoint(error).port();
  accept_next();
  for (int i = 0; i < std::max(1, options.threads); ++i) threads.emplace_back([this] { io.run(); });
  return port;
}

void HttpServer::Impl::accept_next() {
  acceptor.async_accept(asio::make_strand(io), [this](const boost::system::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !acceptor.is_open()) return;
    if (!error) {
      admit(std::move(socket));
      accept_next();
      return;
    }
    // Out of file descriptors, most likely: at once it would fail again, and keep a processor busy with it.
    accept_retry.expires_after(kAcceptRetry);
    accept_retry.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) accept_next();
    });
  });
}

void HttpServer::Impl::admit(tcp::socket socket) {
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  std::shared_ptr<Connection> connection;
  std::int64_t id = 0;
  {
    const std::lock_guard lock(mutex);
    if (stopped || connections.size() >= static_cast<std::size_t>(options.max_connections)) {
      ++refused;
      return;
    }
    id = ++accepted;
    connection = make_connection(context, std::move(socket));
    connections.emplace(id, connection);
  }
  connection->run([this, id] {
    const std::lock_guard closed(mutex);
    connections.erase(id);
    if (connections.empty()) all_closed.notify_all();
  });
}

void HttpServer::Impl::drain() {
  context.draining = true;
  router.drain();
}

void HttpServer::Impl::stop(std::chrono::milliseconds grace) {
  {
    std::unique_lock lock(mutex);
    if (std::exchange(stopped, true)) return;
    drain();
    asio::post(acceptor.get_executor(), [this] {
      boost::system::error_code ignored;
      acceptor.close(ignored);
      accept_retry.cancel();
    });
    for (const auto& [id, connection] : connections) connection->finish();
    if (!all_closed.wait_for(lock, grace, [this] { return connections.empty(); })) {
      for (const auto& [id, connection] : connections) connection->abort();
    }
  }
  // The threads return when the last connection is gone: nothing is cut off in the middle of a reply's delivery.
  for (std::thread& thread : threads) thread.join();
}

HttpCounts HttpServer::Impl::counts() const {
  const std::lock_guard lock(mutex);
  return {accepted,
          static_cast<std::int64_t>(connections.size()),
          refused,
          context.requests,
          context.failed_requests,
          context.watch_streams,
          context.open_watch_streams};
}

HttpServer::HttpServer(api::Api& api, AssetTable assets, std::function<std::string(const HttpCounts&)> metrics,
                       HttpOptions options)
    : impl_(std::make_unique<Impl>(api, std::move(assets), std::move(metrics), std::move(options))) {}

HttpServer::~HttpServer() {
  stop(std::chrono::milliseconds(0));
}

Result<int> HttpServer::start(const Endpoint& endpoint) {
  return impl_->start(endpoint);
}

void HttpServer::drain() {
  impl_->drain();
}

void HttpServer::stop(std::chrono::milliseconds grace) {
  impl_->stop(grace);
}

HttpCounts HttpServer::counts() const {
  return impl_->counts();
}

}  // namespace kerf::ws
