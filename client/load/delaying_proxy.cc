#include "client/load/delaying_proxy.h"

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/connect.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include "client/load/endpoint.h"

namespace kerf::load {
namespace proxy {  // Named, because DelayingProxy::Impl has members of these types.

namespace asio = boost::asio;
using Tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;
using NetError = boost::system::error_code;

struct Pair {
  explicit Pair(asio::io_context& context) : client(context), server(context) {}
  Tcp::socket client;
  Tcp::socket server;
  void close() {
    NetError ignored;
    client.close(ignored);
    server.close(ignored);
  }
};

// Carries one direction of one connection. Keeps itself alive while work is in progress.
class Pump : public std::enable_shared_from_this<Pump> {
 public:
  Pump(std::shared_ptr<Pair> pair, Tcp::socket& from, Tcp::socket& to, const Way& way)
      : pair_(std::move(pair)), from_(from), to_(to), way_(way), most_(most_held(way)), timer_(to.get_executor()) {}

  void read() {
    if (reading_ || ended_ || held_bytes_ >= most_) return;
    reading_ = true;
    from_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](const NetError& error, std::size_t bytes) {
      self->reading_ = false;
      if (error) return self->end(error);
      self->hold(bytes);
      self->read();
    });
  }

 private:
  struct Chunk {
    Clock::time_point due;
    std::vector<char> bytes;
  };

  static std::size_t most_held(const Way& way) {
    if (way.bytes_per_s <= 0.0) return DelayingProxy::kMostHeldWide;
    const double under_way = way.bytes_per_s * std::chrono::duration<double>(way.delay).count();
    return DelayingProxy::kMostHeld +
           static_cast<std::size_t>(std::min(under_way, static_cast<double>(DelayingProxy::kMostUnderWay)));
  }

  // Ends reading from this side; bytes read before are still passed on.
  void end(const NetError& how) {
    ended_ = how;
    if (held_.empty()) pass_on_end();
  }

  void pass_on_end() {
    if (*ended_ != asio::error::eof) return pair_->close();
    NetError ignored;
    to_.shutdown(Tcp::socket::shutdown_send, ignored);  // The other direction continues until its own end.
  }

  void hold(std::size_t bytes) {
    Clock::time_point passed = Clock::now();
    if (way_.bytes_per_s > 0.0) {
      const std::chrono::duration<double> takes(static_cast<double>(bytes) / way_.bytes_per_s);
      free_at_ = std::max(free_at_, passed) + std::chrono::duration_cast<Clock::duration>(takes);
      passed = free_at_;
    }
    held_bytes_ += bytes;
    held_.push_back({passed + std::chrono::duration_cast<Clock::duration>(way_.delay),
                     {buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(bytes)}});
    if (held_.size() == 1) pass_on();
  }

  void pass_on() {
    timer_.expires_at(held_.front().due);
    timer_.async_wait([self = shared_from_this()](const NetError& cancelled) {
      if (cancelled) return;
      asio::async_write(self->to_, asio::buffer(self->held_.front().bytes),
                        [self](const NetError& error, std::size_t bytes) {
                          if (error) return self->pair_->close();
                          self->held_bytes_ -= bytes;
                          self->held_.pop_front();
                          if (!self->held_.empty()) {
                            self->pass_on();
                          } else if (self->ended_) {
                            self->pass_on_end();
                          }
                          self->read();
                        });
    });
  }

  const std::shared_ptr<Pair> pair_;
  Tcp::socket& from_;
  Tcp::socket& to_;
  const Way way_;
  const std::size_t most_;  // Bytes held at once.
  asio::steady_timer timer_;
  std::array<char, 16384> buffer_{};
  bool reading_ = false;
  std::optional<NetError> ended_;  // Result of reading, once it has ended.
  std::deque<Chunk> held_;
  std::size_t held_bytes_ = 0;
  Clock::time_point free_at_{};
};

}  // namespace proxy

namespace asio = boost::asio;
using proxy::NetError;
using proxy::Pair;
using proxy::Pump;
using proxy::Tcp;

constexpr std::chrono::milliseconds kAcceptAgainAfter(100);

struct DelayingProxy::Impl {
  asio::io_context context{1};
  Tcp::resolver::results_type server;
  Tcp::acceptor acceptor{context};
  asio::steady_timer retry{context};
  Way way;
  std::thread thread;

  void accept() {
    const auto pair = std::make_shared<Pair>(context);
    acceptor.async_accept(pair->client, [this, pair](const NetError& refused) {
      if (refused) return accept_later();
      connect(pair);
      accept();
    });
  }
  // Retries later. Most likely descriptors ran out; waiting connections stay until some are free.
  void accept_later() {
    retry.expires_after(kAcceptAgainAfter);
    retry.async_wait([this](const NetError& /*cancelled*/) { accept(); });
  }
  void connect(const std::shared_ptr<Pair>& pair) {
    asio::async_connect(pair->server, server, [this, pair](const NetError& error, const Tcp::endpoint& /*endpoint*/) {
      if (error) return pair->close();
      for (Tcp::socket* socket : {&pair->client, &pair->server}) {
        NetError ignored;
        socket->set_option(Tcp::no_delay(true), ignored);
      }
      std::make_shared<Pump>(pair, pair->client, pair->server, way)->read();
      std::make_shared<Pump>(pair, pair->server, pair->client, way)->read();
    });
  }
};

Result<std::unique_ptr<DelayingProxy>> DelayingProxy::start(const std::string& server, const Way& way) {
  auto impl = std::make_unique<Impl>();
  impl->way = way;
  const auto no_proxy = [&](const std::string& why) {
    return unavailable("NO_PROXY", "cannot start a proxy to " + server + ": " + why);
  };
  const std::optional<Endpoint> endpoint = parse_endpoint(server);
  if (!endpoint) return no_proxy("write HOST:PORT");
  NetError error;
  impl->server = Tcp::resolver(impl->context).resolve(endpoint->host, endpoint->port, error);
  if (error) return no_proxy(error.message());
  const Tcp::endpoint here(asio::ip::address_v4::loopback(), 0);
  if (!error) impl->acceptor.open(here.protocol(), error);
  if (!error) impl->acceptor.bind(here, error);
  if (!error) impl->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) return no_proxy(error.message());
  impl->accept();
  impl->thread = std::thread([raw = impl.get()] { raw->context.run(); });
  return std::unique_ptr<DelayingProxy>(new DelayingProxy(std::move(impl)));
}

DelayingProxy::DelayingProxy(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

DelayingProxy::~DelayingProxy() {
  impl_->context.stop();
  impl_->thread.join();
}

std::string DelayingProxy::address() const {
  return "127.0.0.1:" + std::to_string(impl_->acceptor.local_endpoint().port());
}

}  // namespace kerf::load
