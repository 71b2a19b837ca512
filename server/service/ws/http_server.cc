#include "server/service/ws/http_server.h"

#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/base/peer_places.h"
#include "server/service/api/api.h"
#include "server/service/host/listening.h"
#include "server/service/ws/connection.h"
#include "server/service/ws/router.h"
#include "server/service/ws/turned_away.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptRetry{100};

Error cannot_listen(const Endpoint& endpoint, const boost::system::error_code& error) {
  const bool taken = error == asio::error::address_in_use;
  return unavailable(taken ? "ADDRESS_IN_USE" : "CANNOT_LISTEN",
                     "cannot listen on " + format_endpoint(endpoint.host, endpoint.port) + " for HTTP: " +
                         error.message() + (taken ? "; stop the other program or choose another --http port" : ""));
}

}  // namespace

struct HttpServer::Impl {
  Impl(api::Api& api, AssetTable assets, std::function<std::string(const HttpCounts&)> metrics, HttpOptions chosen)
      : options(std::move(chosen)),
        router(api, std::move(assets), [this, metrics = std::move(metrics)] { return metrics(counts()); }),
        context{api, router, options},
        places(options.max_connections_per_address),
        turned_away(options.max_connections_per_address),
        tls(options.tls) {}

  // Listens at one address of the server.
  struct Port {
    explicit Port(tcp::acceptor listening) : acceptor(std::move(listening)), retry(acceptor.get_executor()) {}
    tcp::acceptor acceptor;  // Has a strand of its own, which `retry` shares.
    asio::steady_timer retry;
    tcp::endpoint peer;  // The peer that connected last.
  };
  struct Open {
    std::shared_ptr<Connection> connection;
    PeerPlaces::Place place;
  };

  Result<int> start(const Endpoint& endpoint);
  void accept_next(Port& port);
  void admit(tcp::socket socket, const Peer& peer);
  void drain();
  void stop(std::chrono::milliseconds grace);
  HttpCounts counts() const;

  const HttpOptions options;
  Router router;
  ConnectionContext context;
  PeerPlaces places;
  TurnedAway turned_away;
  asio::io_context io;
  std::list<Port> ports;
  std::vector<std::thread> threads;

  mutable std::mutex mutex;  // Guards the members below.
  std::condition_variable all_closed;
  std::map<std::int64_t, Open> connections;  // By order of arrival.
  std::shared_ptr<TlsContext> tls;           // For new connections; null: plain HTTP.
  std::int64_t accepted = 0;
  std::int64_t refused = 0;
  std::int64_t refused_by_address = 0;
  bool stopped = false;
};

Result<int> HttpServer::Impl::start(const Endpoint& endpoint) {
  host::Listening listening =
      host::listen_at_each(endpoint.host, endpoint.port, [this] { return asio::make_strand(io); });
  if (listening.error) return cannot_listen(endpoint, listening.error);
  AccessPolicy access = options.access;
  access.bound_to_loopback = std::ranges::all_of(
      listening.acceptors, [](const tcp::acceptor& each) { return each.local_endpoint().address().is_loopback(); });
  access.port = listening.acceptors.front().local_endpoint().port();
  access.is_secure = options.tls != nullptr;
  context.is_only_secure = access.is_secure && !access.bound_to_loopback;
  const int port = access.port;
  router.set_access(std::move(access));
  for (tcp::acceptor& acceptor : listening.acceptors) ports.emplace_back(std::move(acceptor));
  for (Port& each : ports) accept_next(each);
  for (int i = 0; i < std::max(1, options.threads); ++i) threads.emplace_back([this] { io.run(); });
  return port;
}

void HttpServer::Impl::accept_next(Port& port) {
  const auto accepted_one = [this, &port](const boost::system::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !port.acceptor.is_open()) return;
    if (!error) {
      admit(std::move(socket), peer_of(*port.peer.data()));
      accept_next(port);
      return;
    }
    // Waits before retrying. Most likely descriptors ran out: an accept at once would fail too, and keep a processor
    // busy.
    port.retry.expires_after(kAcceptRetry);
    port.retry.async_wait([this, &port](const boost::system::error_code& cancelled) {
      if (!cancelled) accept_next(port);
    });
  };
  port.acceptor.async_accept(asio::make_strand(io), port.peer, accepted_one);
}

void HttpServer::Impl::admit(tcp::socket socket, const Peer& peer) {
  boost::system::error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  std::optional<PeerPlaces::Place> place = places.take(peer);
  std::shared_ptr<Connection> connection;
  std::int64_t id = 0;
  {
    const std::lock_guard lock(mutex);
    if (stopped || connections.size() >= static_cast<std::size_t>(options.max_connections)) {
      ++refused;
      return;
    }
    if (place) {
      try {
        connection = make_connection(context, std::move(socket), tls);
        id = ++accepted;
        connections.emplace(id, Open{connection, *std::move(place)});
      } catch (const std::exception&) {  // No memory; the port stays open.
        ++refused;
        return;
      }
    } else {
      ++refused_by_address;
    }
  }
  if (!connection) {
    if (!options.tls) turned_away.answer(std::move(socket));
    return;
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
    for (Port& port : ports) {
      asio::post(port.acceptor.get_executor(), [&port] {
        boost::system::error_code ignored;
        port.acceptor.close(ignored);
        port.retry.cancel();
      });
    }
    for (const auto& [id, open] : connections) open.connection->finish();
    if (!all_closed.wait_for(lock, grace, [this] { return connections.empty(); })) {
      for (const auto& [id, open] : connections) open.connection->abort();
    }
  }
  // Joins the threads, which return once the last connection is gone: no delivery of a reply is interrupted.
  for (std::thread& thread : threads) thread.join();
}

HttpCounts HttpServer::Impl::counts() const {
  const std::lock_guard lock(mutex);
  return {accepted,
          static_cast<std::int64_t>(connections.size()),
          refused,
          refused_by_address,
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

void HttpServer::set_tls(std::shared_ptr<TlsContext> tls) {
  const std::lock_guard lock(impl_->mutex);
  impl_->tls = std::move(tls);
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
