#include "server/rpc/connection_gate.h"

#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <list>
#include <mutex>
#include <new>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>

namespace kerf::rpc {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptRetry{100};
// Looking through all connections for closed ones is due no more often.
constexpr std::chrono::milliseconds kLookInterval{20};

// 0 of what is closed.
ino_t inode_of(int descriptor) {
  struct stat status {};
  return fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

// HOST and PORT of "HOST:PORT" and "[HOST]:PORT".
std::pair<std::string, std::string> split(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.size() > 1 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return {host, colon == std::string::npos ? std::string() : address.substr(colon + 1)};
}

}  // namespace

struct ConnectionGate::Impl {
  // A connection that was handed over. Its number is that of another one once it is closed, its inode is not.
  struct Handed {
    int descriptor;
    ino_t inode;
  };

  struct Port {
    explicit Port(asio::io_context& io) : acceptor(io), retry(io) {}
    tcp::acceptor acceptor;
    asio::steady_timer retry;
  };
  // Says nothing yet.
  struct Silent {
    explicit Silent(tcp::socket connected) : socket(std::move(connected)), limit(socket.get_executor()) {}
    tcp::socket socket;
    asio::steady_timer limit;
  };

  Impl(int most, std::chrono::milliseconds patience, Take taker)
      : max_connections(static_cast<std::size_t>(most)), silence(patience), take(std::move(taker)) {
    handed.reserve(max_connections);  // so that none is lost for want of memory
  }

  Result<int> bind(const std::string& address);
  void open();
  void stop();
  bool listen_at(const tcp::endpoint& endpoint, boost::system::error_code& error);
  void accept_next(Port& port);
  void admit_or_refuse(tcp::socket socket);
  void admit(const std::shared_ptr<Silent>& silent);
  void hear(const std::shared_ptr<Silent>& silent);
  void forget_closed() const;
  GateCounts counts() const;

  const std::size_t max_connections;
  const std::chrono::milliseconds silence;
  const Take take;
  asio::io_context io{1};
  std::list<Port> ports;  // the same number at each address of the host
  std::thread thread;

  mutable std::mutex mutex;  // of what follows
  std::set<std::shared_ptr<Silent>> silents;
  mutable std::vector<Handed> handed;
  mutable std::chrono::steady_clock::time_point looked;
  std::int64_t accepted = 0;
  std::int64_t refused = 0;
};

bool ConnectionGate::Impl::listen_at(const tcp::endpoint& endpoint, boost::system::error_code& error) {
  Port port(io);
  port.acceptor.open(endpoint.protocol(), error);
  // Lets a restarted server have its port back at once; a port that somebody listens on is still refused.
  if (!error) port.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) port.acceptor.bind(endpoint, error);
  if (!error) port.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) return false;
  ports.emplace_back(io);
  ports.back().acceptor = std::move(port.acceptor);
  return true;
}

Result<int> ConnectionGate::Impl::bind(const std::string& address) {
  const auto [host, number] = split(address);
  boost::system::error_code error;
  const tcp::resolver::results_type found = tcp::resolver(io).resolve(host, number, tcp::resolver::passive, error);
  if (!error && found.empty()) error = asio::error::host_not_found;
  for (const auto& entry : found) {
    tcp::endpoint endpoint = entry.endpoint();
    if (!ports.empty()) endpoint.port(ports.front().acceptor.local_endpoint().port());
    // A name may have an address of a family that this machine does not speak.
    if (!listen_at(endpoint, error) && error == asio::error::address_in_use) break;
  }
  if (!ports.empty() && error != asio::error::address_in_use) return ports.front().acceptor.local_endpoint().port();
  ports.clear();
  return Error{ErrorCode::kUnavailable,
               "ADDRESS_IN_USE",
               "cannot listen on " + address +
                   " for gRPC: the port is taken or the address is not this machine's; stop the other program or "
                   "choose another --listen port",
               {}};
}

void ConnectionGate::Impl::open() {
  for (Port& port : ports) accept_next(port);
  thread = std::thread([this] { io.run(); });
}

void ConnectionGate::Impl::accept_next(Port& port) {
  port.acceptor.async_accept([this, &port](const boost::system::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !port.acceptor.is_open()) return;
    if (!error) {
      admit_or_refuse(std::move(socket));
      accept_next(port);
      return;
    }
    // Out of descriptors, most likely: an accept at once would fail as well, and keep a processor busy.
    port.retry.expires_after(kAcceptRetry);
    port.retry.async_wait([this, &port](const boost::system::error_code& cancelled) {
      if (!cancelled) accept_next(port);
    });
  });
}

// Without memory a connection is refused, and the port stays open.
void ConnectionGate::Impl::admit_or_refuse(tcp::socket socket) {
  std::shared_ptr<Silent> silent;
  try {
    silent = std::make_shared<Silent>(std::move(socket));
    admit(silent);
  } catch (const std::bad_alloc&) {
    const std::lock_guard lock(mutex);
    ++refused;
    silents.erase(silent);
  }
}

void ConnectionGate::Impl::admit(const std::shared_ptr<Silent>& silent) {
  {
    const std::lock_guard lock(mutex);
    const auto is_full = [this] { return silents.size() + handed.size() >= max_connections; };
    if (is_full()) forget_closed();
    if (is_full()) {
      ++refused;
      return;
    }
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
    silents.erase(silent);
  });
}

// A closed connection can be read, too: nothing is in it.
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
    silents.erase(silent);
    if (!speaks || error) return;
    descriptor = socket.release(error);
    if (error) return;
    handed.push_back({descriptor, inode_of(descriptor)});
  }
  take(descriptor);
}

// With the mutex held.
void ConnectionGate::Impl::forget_closed() const {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked < kLookInterval) return;
  looked = now;
  handed.erase(std::remove_if(handed.begin(), handed.end(),
                              [](const Handed& each) { return inode_of(each.descriptor) != each.inode; }),
               handed.end());
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
  return {accepted, static_cast<std::int64_t>(silents.size() + handed.size()), refused};
}

ConnectionGate::ConnectionGate(int max_connections, std::chrono::milliseconds silence, Take take)
    : impl_(std::make_unique<Impl>(max_connections, silence, std::move(take))) {}

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
