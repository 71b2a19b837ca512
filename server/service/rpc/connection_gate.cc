#include "server/service/rpc/connection_gate.h"

#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <list>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

#include "server/base/peer_places.h"
#include "server/service/host/listening.h"

namespace kerf::rpc {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptRetry{100};
// Shortest interval between searches of all connections for closed ones.
constexpr std::chrono::milliseconds kLookInterval{20};
// Largest number of connections of one peer for which searching them costs less than accepting one.
constexpr int kCheapLook = 256;

// Returns the inode of a descriptor; 0 if it is closed.
ino_t inode_of(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

// Splits "HOST:PORT" or "[HOST]:PORT". A missing port is 0.
std::pair<std::string, int> split(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  int port = 0;
  if (colon != std::string::npos) std::from_chars(&address[colon + 1], address.data() + address.size(), port);
  return {host, port};
}

}  // namespace

struct ConnectionGate::Impl {
  // Identifies a connection passed to gRPC. Its descriptor is reused once it is closed, its inode is not.
  struct Handed {
    int descriptor;
    ino_t inode;
    PeerPlaces::Place place;
  };

  struct Port {
    explicit Port(tcp::acceptor listening) : acceptor(std::move(listening)), retry(acceptor.get_executor()) {}
    tcp::acceptor acceptor;
    asio::steady_timer retry;
    tcp::endpoint peer;  // The peer that connected last.
  };
  // Holds a connection that has sent nothing yet.
  struct Silent {
    explicit Silent(tcp::socket connected) : socket(std::move(connected)), limit(socket.get_executor()) {}
    tcp::socket socket;
    asio::steady_timer limit;
    std::optional<PeerPlaces::Place> place;
  };

  Impl(const GateLimits& limits, Take taker)
      : max_connections(static_cast<std::size_t>(limits.max_connections)),
        silence(limits.silence),
        take(std::move(taker)),
        places(limits.max_per_address) {
    handed.reserve(max_connections);  // Reserved, so that no connection is lost for lack of memory.
  }

  Result<int> bind(const std::string& address);
  void open();
  void stop();
  void accept_next(Port& port);
  void admit_or_refuse(tcp::socket socket, const Peer& peer);
  void admit(const std::shared_ptr<Silent>& silent, const Peer& peer);
  bool has_room(Silent& silent, const Peer& peer);
  void hear(const std::shared_ptr<Silent>& silent);
  void forget(const std::shared_ptr<Silent>& silent);
  void forget_closed() const;
  void forget_closed_of(const Peer& peer) const;
  GateCounts counts() const;

  const std::size_t max_connections;
  const std::chrono::milliseconds silence;
  const Take take;
  PeerPlaces places;  // Outlives every connection.
  asio::io_context io{1};
  std::list<Port> ports;  // The same port at each address of the host.
  std::thread thread;

  mutable std::mutex mutex;  // Guards the members below.
  std::set<std::shared_ptr<Silent>> silents;
  mutable std::vector<Handed> handed;
  mutable std::chrono::steady_clock::time_point looked;
  std::int64_t accepted = 0;
  std::int64_t refused = 0;
  std::int64_t refused_by_address = 0;
};

Result<int> ConnectionGate::Impl::bind(const std::string& address) {
  const auto [name, number] = split(address);
  host::Listening listening = host::listen_at_each(name, number, [this] { return io.get_executor(); });
  if (!listening.error) {
    for (tcp::acceptor& acceptor : listening.acceptors) ports.emplace_back(std::move(acceptor));
    return ports.front().acceptor.local_endpoint().port();
  }
  return unavailable("ADDRESS_IN_USE",
                     "cannot listen on " + address +
                         " for gRPC: the port is taken or the address is not this machine's; stop the other program or "
                         "choose another --listen port");
}

void ConnectionGate::Impl::open() {
  for (Port& port : ports) accept_next(port);
  thread = std::thread([this] { io.run(); });
}

void ConnectionGate::Impl::accept_next(Port& port) {
  port.acceptor.async_accept(port.peer, [this, &port](const boost::system::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !port.acceptor.is_open()) return;
    if (!error) {
      admit_or_refuse(std::move(socket), peer_of(*port.peer.data()));
      accept_next(port);
      return;
    }
    // Waits before retrying. Most likely descriptors ran out: an accept at once would fail too, and keep a processor
    // busy.
    port.retry.expires_after(kAcceptRetry);
    port.retry.async_wait([this, &port](const boost::system::error_code& cancelled) {
      if (!cancelled) accept_next(port);
    });
  });
}

// Refuses the connection if memory runs out; the port stays open.
void ConnectionGate::Impl::admit_or_refuse(tcp::socket socket, const Peer& peer) {
  std::shared_ptr<Silent> silent;
  try {
    silent = std::make_shared<Silent>(std::move(socket));
    admit(silent, peer);
  } catch (const std::bad_alloc&) {
    const std::lock_guard lock(mutex);
    ++refused;
    if (silent) forget(silent);
  }
}

// Gives the connection a place among those of its peer. Needs the mutex held.
bool ConnectionGate::Impl::has_room(Silent& silent, const Peer& peer) {
  silent.place = places.take(peer);
  if (!silent.place) {
    forget_closed_of(peer);
    silent.place = places.take(peer);
  }
  if (!silent.place) {
    ++refused_by_address;
    return false;
  }
  const auto is_full = [this] { return silents.size() + handed.size() >= max_connections; };
  if (is_full()) forget_closed();
  if (!is_full()) return true;
  ++refused;
  return false;
}

void ConnectionGate::Impl::admit(const std::shared_ptr<Silent>& silent, const Peer& peer) {
  {
    const std::lock_guard lock(mutex);
    if (!has_room(*silent, peer)) return;
    ++accepted;
    silents.insert(silent);
  }
  silent->limit.expires_after(silence);
  silent->limit.async_wait([silent](const boost::system::error_code& cancelled) {
    boost::system::error_code ignored;
    if (!cancelled) silent->socket.close(ignored);
  });
  silent->socket.async_wait(tcp::socket::wait_read, [this, silent](const boost::system::error_code& error) {
    silent->limit.cancel();
    if (!error) return hear(silent);
    const std::lock_guard lock(mutex);
    forget(silent);
  });
}

// Needs the mutex held.
void ConnectionGate::Impl::forget(const std::shared_ptr<Silent>& silent) {
  silents.erase(silent);
  silent->place.reset();
}

// Passes a readable connection to gRPC if its first byte is there. A closed one becomes readable too, but without data.
void ConnectionGate::Impl::hear(const std::shared_ptr<Silent>& silent) {
  tcp::socket& socket = silent->socket;
  char first = 0;
  const bool speaks = recv(socket.native_handle(), &first, 1, MSG_PEEK | MSG_DONTWAIT) == 1;
  boost::system::error_code error;
  socket.native_non_blocking(true, error);
  if (!error) socket.set_option(tcp::no_delay(true), error);
  int descriptor = -1;
  {
    const std::lock_guard lock(mutex);
    if (speaks && !error) descriptor = socket.release(error);
    if (speaks && !error) handed.push_back({descriptor, inode_of(descriptor), *std::move(silent->place)});
    forget(silent);
    if (!speaks || error) return;
  }
  take(descriptor);
}

// Forgets all connections that gRPC has closed. Needs the mutex held.
void ConnectionGate::Impl::forget_closed() const {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked < kLookInterval) return;
  looked = now;
  std::erase_if(handed, [](const Handed& each) { return inode_of(each.descriptor) != each.inode; });
}

// Forgets the peer's connections that gRPC has closed, or those of all peers if it has many. Needs the mutex held.
void ConnectionGate::Impl::forget_closed_of(const Peer& peer) const {
  if (places.taken(peer) > kCheapLook) return forget_closed();
  std::erase_if(handed, [&peer](const Handed& each) {
    return each.place.peer() == peer && inode_of(each.descriptor) != each.inode;
  });
}

void ConnectionGate::Impl::stop() {
  if (!thread.joinable()) return;
  asio::post(io, [this] {
    boost::system::error_code ignored;
    for (Port& port : ports) {
      port.acceptor.close(ignored);
      port.retry.cancel();
    }
    const std::lock_guard lock(mutex);
    for (const std::shared_ptr<Silent>& silent : silents) silent->socket.close(ignored);
  });
  thread.join();
}

GateCounts ConnectionGate::Impl::counts() const {
  const std::lock_guard lock(mutex);
  forget_closed();
  return {accepted, static_cast<std::int64_t>(silents.size() + handed.size()), refused, refused_by_address};
}

ConnectionGate::ConnectionGate(const GateLimits& limits, Take take)
    : impl_(std::make_unique<Impl>(limits, std::move(take))) {}

ConnectionGate::~ConnectionGate() {
  stop();
}

Result<int> ConnectionGate::bind(const std::string& address) {
  return impl_->bind(address);
}

void ConnectionGate::open() {
  impl_->open();
}

void ConnectionGate::stop() {
  impl_->stop();
}

GateCounts ConnectionGate::counts() const {
  return impl_->counts();
}

}  // namespace kerf::rpc
