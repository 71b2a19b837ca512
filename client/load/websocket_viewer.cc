#include <atomic>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

#include "client/cpp/mirror.h"
#include "client/load/endpoint.h"
#include "client/load/tls.h"
#include "client/load/viewer.h"

namespace kerf::load {
namespace {

namespace beast = boost::beast;

using NetError = boost::system::error_code;

constexpr std::chrono::seconds kOpeningPatience(10);         // For each step of opening the stream.
constexpr std::size_t kMaxMessage = std::size_t{256} << 20;  // Bytes, as client::Client::kMaxReceiveBytes.

// `Stream`: beast::tcp_stream or TlsStream.
template <typename Stream>
class WebSocketViewer : public Viewer {
 public:
  WebSocketViewer(const Plan& plan, Watching watching, Recorder& recorder, Waiter& waiter)
      : plan_(plan),
        watching_(std::move(watching)),
        waiter_(waiter),
        log_(plan, watching_, recorder),
        socket_(make_socket()),
        thread_([this] { run(); }) {}
  ~WebSocketViewer() override {
    stop();
    thread_.join();
  }
  void stop() override {
    if (stopped_.exchange(true)) return;
    boost::asio::post(context_, [this] { beast::get_lowest_layer(socket_).close(); });
  }

 private:
  using Addresses = boost::asio::ip::tcp::resolver::results_type;
  using Socket = beast::websocket::stream<Stream>;
  static constexpr bool kIsEncrypted = std::is_same_v<Stream, TlsStream>;

  Socket make_socket() {
    if constexpr (kIsEncrypted) {
      unprepared_ = prepare(plan_.secrets, tls_);
      return Socket(context_, tls_);
    } else {
      return Socket(context_);
    }
  }

  void run() {
    resolve();
    context_.run();
    log_.finish();
  }

  void resolve() {
    const std::optional<Endpoint> endpoint = parse_endpoint(watching_.address);
    if (!endpoint) return ended("write HOST:PORT");
    resolver_.async_resolve(endpoint->host, endpoint->port, [this](const NetError& error, const Addresses& found) {
      if (error) return ended(error.message());
      // Connects only if stop() was not called, because connecting would reopen the closed socket.
      if (!stopped_) connect(found);
    });
  }

  void connect(const Addresses& addresses) {
    beast::tcp_stream& lowest = beast::get_lowest_layer(socket_);
    lowest.expires_after(kOpeningPatience);
    lowest.async_connect(addresses, [this](const NetError& error, const boost::asio::ip::tcp::endpoint& /*to*/) {
      if (error) return ended(error.message());
      NetError ignored;
      beast::get_lowest_layer(socket_).socket().set_option(boost::asio::ip::tcp::no_delay(true), ignored);
      if constexpr (kIsEncrypted) {
        encrypt();
      } else {
        shake_hands();
      }
    });
  }

  void encrypt() {
    if (unprepared_) return ended(unprepared_.message());
    expect_server(plan_.secrets, parse_endpoint(plan_.http)->host, socket_.next_layer());
    socket_.next_layer().async_handshake(boost::asio::ssl::stream_base::client, [this](const NetError& error) {
      if (error) return ended(error.message());
      shake_hands();
    });
  }

  void shake_hands() {
    beast::tcp_stream& lowest = beast::get_lowest_layer(socket_);
    lowest.expires_never();  // The WebSocket has its own time limit.
    socket_.set_option(
        beast::websocket::stream_base::timeout{kOpeningPatience, beast::websocket::stream_base::none(), false});
    socket_.set_option(beast::websocket::stream_base::decorator([this](beast::websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, "kerf.v1");
      const std::string& token = plan_.secrets.token;
      if (!token.empty()) request.set(beast::http::field::authorization, "Bearer " + token);
    }));
    socket_.read_message_max(kMaxMessage);
    socket_.binary(true);
    socket_.async_handshake(plan_.http, "/watch", [this](const NetError& error) {
      if (error) return ended(error.message());
      send(client::start_of_watch(watching_.sheet, options_of(plan_, watching_.role)));
    });
  }

  void read() {
    socket_.async_read(buffer_, [this](const NetError& error, std::size_t bytes) {
      if (error) return ended(error.message());
      v1::WatchResponse response;
      const bool sound = response.ParseFromArray(buffer_.data().data(), static_cast<int>(bytes));
      buffer_.consume(bytes);
      if (!sound) return ended("not a message of kerf.v1");
      if (response.has_ended()) return ended(v1::Ended::Reason_Name(response.ended().reason()));
      if (!response.has_frame()) return read();
      take(response.frame(), static_cast<std::int64_t>(bytes));
    });
  }

  void take(const v1::Frame& frame, std::int64_t bytes) {
    const auto arrived = std::chrono::steady_clock::now();
    if (const std::optional<std::string> wrong = mirror_.apply(frame)) {
      return ended("DATA_LOSS " + *wrong);
    }
    log_.seen(frame.tick(), frame.topology_version(), frame.stats(), bytes, frame.base_tick() < 0);
    const Nanoseconds hold = hold_of(plan_, watching_.role, ++frames_);
    if (hold > Nanoseconds(0) && !waiter_.wait_until(waiter_.now() + hold)) return;
    // Sends nothing more for a stalled reader: the server's reset in answer could discard its last message.
    if (watching_.role == Role::kStalled) return read();
    send(client::acknowledgement(frame.sequence(), arrived));
  }

  // Sends a request, then reads again.
  void send(const v1::WatchRequest& request) {
    sent_ = request.SerializeAsString();
    socket_.async_write(boost::asio::buffer(sent_), [this](const NetError& error, std::size_t /*bytes*/) {
      if (error) return ended(error.message());
      read();
    });
  }

  // Ends the thread at once, since the WebSocket's timer for opening would delay it.
  void ended(const std::string& how) {
    if (!stopped_) log_.ended(how);
    context_.stop();
  }

  const Plan& plan_;
  const Watching watching_;
  Waiter& waiter_;
  ReaderLog log_;
  std::atomic<bool> stopped_{false};
  client::Mirror mirror_;
  std::int64_t frames_ = 0;
  boost::asio::io_context context_{1};
  boost::asio::ip::tcp::resolver resolver_{context_};
  NetError unprepared_;  // Set if OpenSSL cannot read the keys of the plan.
  boost::asio::ssl::context tls_{boost::asio::ssl::context::tls_client};
  Socket socket_;
  beast::flat_buffer buffer_;
  std::string sent_;  // Message being written.
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Viewer> watch_frames_over_websocket(const Plan& plan, const Watching& watching, Recorder& recorder,
                                                    Waiter& waiter) {
  if (plan.secrets.use_tls) return std::make_unique<WebSocketViewer<TlsStream>>(plan, watching, recorder, waiter);
  return std::make_unique<WebSocketViewer<beast::tcp_stream>>(plan, watching, recorder, waiter);
}

}  // namespace kerf::load
