#include "server/service/ws/connection.h"

#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <limits>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "server/service/api/upload.h"
#include "server/service/ws/http_messages.h"
#include "server/service/ws/mjpeg.h"
#include "server/service/ws/socket_stream.h"
#include "server/service/ws/tls.h"
#include "server/service/ws/transport.h"
#include "server/service/ws/write_response.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Parser = http::request_parser<http::string_body>;

// Largest part of a request read before it is parsed.
constexpr std::size_t kMostReadAhead = std::size_t{128} << 10;
// Largest part of the next request that is read while a client is watched during one.
constexpr std::size_t kMostOvertaking = 4096;
constexpr std::chrono::seconds kFarewell{1};

std::string address_of(const asio::ip::tcp::socket& socket) {
  boost::system::error_code gone;
  const asio::ip::tcp::endpoint peer = socket.remote_endpoint(gone);
  return gone ? std::string() : peer.address().to_string();
}

// Serves one connection. In coroutines here, co_await stands alone or initialises a variable, never within a condition
// or a larger expression: g++ 12 otherwise resumes the wrong frame.
template <typename Stream>
class HttpConnection : public Connection, public std::enable_shared_from_this<HttpConnection<Stream>> {
 public:
  HttpConnection(ConnectionContext& context, Stream stream)
      : context_(context),
        stream_(std::move(stream)),
        lowest_(beast::get_lowest_layer(stream_)),
        executor_(stream_.get_executor()),
        peer_(address_of(lowest_.socket())),
        buffer_(context.options.max_header_bytes + kMostReadAhead),
        farewell_(executor_) {
    boost::system::error_code ignored;
    lowest_.socket().non_blocking(true, ignored);  // See look_for_hang_up().
  }

  void run(std::function<void()> done) override {
    // Drops a connection that throws (out of memory) like one that fails.
    asio::co_spawn(executor_, serve(),
                   [self = this->shared_from_this(), done = std::move(done)](const std::exception_ptr&) {
                     self->lowest_.close();
                     done();
                   });
  }

  void finish() override {
    asio::post(executor_, [self = this->shared_from_this()] {
      self->finishing_ = true;
      if (self->idle_) self->lowest_.close();
    });
  }

  void abort() override {
    asio::post(executor_, [self = this->shared_from_this()] {
      self->finishing_ = true;
      self->lowest_.close();
    });
  }

 private:
  asio::awaitable<void> serve() {
    if constexpr (kIsTls<Stream>) {
      const bool secured = co_await shake_hands();
      if (!secured) co_return;
    }
    bool more = true;
    while (more) more = co_await serve_request();
    if (!socket_) co_await end_tls();  // A WebSocket has ended it already.
  }

  // Begins TLS; returns false if the client fails to. Plain HTTP is answered as such.
  asio::awaitable<bool> shake_hands() {
    if (finishing_) co_return false;
    lowest_.expires_after(context_.options.request_timeout);
    boost::system::error_code error;
    idle_ = true;
    co_await stream_.async_handshake(asio::ssl::stream_base::server, asio::redirect_error(asio::use_awaitable, error));
    idle_ = false;
    if (is_plain_http(error)) co_await refuse_plain_http();
    co_return !error;
  }

  asio::awaitable<void> refuse_plain_http() {
    ++context_.requests;
    ++context_.failed_requests;
    const std::string answer =
        last_answer(refusal(invalid_argument("TLS_NEEDED", "this port speaks HTTPS alone: begin with https://")));
    lowest_.expires_after(context_.options.write_timeout);
    boost::system::error_code error;
    co_await asio::async_write(lowest_, asio::buffer(answer), asio::redirect_error(asio::use_awaitable, error));
    if (!error) co_await discard_rest();
  }

  // Serves one request; returns false if it was the last one of this connection.
  asio::awaitable<bool> serve_request() {
    const bool begun = co_await request_has_begun();
    if (!begun) co_return false;
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(context_.options.max_header_bytes));
    parser.body_limit(std::numeric_limits<std::uint64_t>::max());  // Until the route is known; see read_body().
    lowest_.expires_after(context_.options.request_timeout);
    boost::system::error_code error;
    co_await http::async_read_header(stream_, buffer_, parser, asio::redirect_error(asio::use_awaitable, error));
    origin_ = header(parser.get(), http::field::origin);
    if (!error && beast::websocket::is_upgrade(parser.get())) {
      co_await upgrade(parser.release());
      co_return false;
    }
    std::optional<HttpResponse> refused;
    if (error) {
      refused = unreadable_request(error);
    } else {
      refused = co_await read_body(parser, error);
    }
    if (refused || error) {
      if (refused) co_await refuse(*refused);
      co_return false;
    }
    RequestMessage message = parser.release();
    Framing framing{message.version(), message.keep_alive(), message.method() == http::verb::head};
    HttpRequest request = from_peer(to_request(message));
    const std::optional<Result<std::shared_ptr<api::ImageSession>>> player = context_.router.play(request);
    if (player && player->ok()) {
      co_await play(**player);
      co_return false;
    }
    HttpResponse response;
    if (player) {
      response = refusal(player->error());
    } else {
      response = co_await answer(std::move(request));
    }
    framing.keep_alive = framing.keep_alive && !finishing_;
    const bool written = co_await write(response, framing);
    co_return written&& framing.keep_alive;
  }

  // Reads the body of a request within the limit given by its header; returns the refusal, if any.
  asio::awaitable<std::optional<HttpResponse>> read_body(Parser& parser, boost::system::error_code& error) {
    std::shared_ptr<const api::UploadRoom> room;  // Held while the body is read.
    std::optional<HttpResponse> refused = admit_body(parser, room);
    if (refused) co_return refused;
    if (parser.get()[http::field::expect] == "100-continue") co_await invite_body();
    co_await http::async_read(stream_, buffer_, parser, asio::redirect_error(asio::use_awaitable, error));
    if (error) refused = unreadable_request(error);
    co_return refused;
  }

  // Returns the refusal of a body before it is read, if any. For an accepted file it sets `room`.
  std::optional<HttpResponse> admit_body(Parser& parser, std::shared_ptr<const api::UploadRoom>& room) {
    const Router::BodyLimit limit = context_.router.body_limit(from_peer(head_of(parser.get())));
    if (limit.refused) return limit.refused;
    const auto max_bytes = static_cast<std::uint64_t>(limit.max_bytes);
    const std::uint64_t announced = parser.content_length().value_or(max_bytes);
    if (announced > max_bytes) return body_too_large();
    if (limit.max_bytes > context_.api.limits().max_request_bytes) {
      Result<std::shared_ptr<const api::UploadRoom>> reserved =
          context_.api.reserve_upload(static_cast<std::int64_t>(announced));
      if (!reserved.ok()) return refusal(reserved.error());
      room = std::move(reserved).value();
      lowest_.expires_after(context_.options.upload_timeout);
    }
    parser.body_limit(max_bytes);
    return std::nullopt;
  }

  asio::awaitable<void> refuse(const HttpResponse& response) {
    const bool written = co_await write(response, Framing());
    if (written) co_await discard_rest();
  }

  asio::awaitable<bool> request_has_begun() {
    if (finishing_) co_return false;
    if (buffer_.size() > 0) co_return true;
    const bool first = std::exchange(first_, false);
    lowest_.expires_after(first ? context_.options.request_timeout : context_.options.idle_timeout);
    boost::system::error_code error;
    idle_ = true;
    const std::size_t bytes =
        co_await stream_.async_read_some(buffer_.prepare(4096), asio::redirect_error(asio::use_awaitable, error));
    idle_ = false;
    buffer_.commit(bytes);
    co_return !error;
  }

  asio::awaitable<void> upgrade(RequestMessage message) {
    const std::string subprotocols = header(message, http::field::sec_websocket_protocol);
    Router::Upgrade upgrade = context_.router.upgrade(from_peer(to_request(message)), subprotocols);
    if (upgrade.refused) {
      co_await write(*upgrade.refused, Framing());
      co_return;
    }
    socket_ = std::make_shared<SocketStream<Stream>>(context_, stream_, std::move(upgrade.open));
    if (!finishing_) co_await socket_->run(message);
  }

  asio::awaitable<void> invite_body() {
    http::response<http::empty_body> invitation{http::status::continue_, 11};
    boost::system::error_code ignored;
    co_await http::async_write(stream_, invitation, asio::redirect_error(asio::use_awaitable, ignored));
  }

  asio::awaitable<void> play(std::shared_ptr<api::ImageSession> session) {
    lowest_.expires_never();
    const std::stop_source hung_up;
    drop_input(hung_up);
    const MjpegTimes times{context_.options.write_timeout, context_.options.picture_repeat};
    HeaderLines shared;
    context_.router.share_with_origin(origin_, shared);
    const std::optional<Error> error =
        co_await play_mjpeg(std::move(session), stream_, times, std::move(shared), hung_up.get_token());
    if (error && !hung_up.stop_requested()) {
      co_await write(refusal(in_words_of_query(*error)), Framing());
    } else {
      ++context_.requests;
    }
  }

  asio::awaitable<HttpResponse> answer(HttpRequest request) {
    lowest_.expires_never();
    const std::stop_source hung_up;
    overtaking_ = buffer_.prepare(std::min(kMostOvertaking, buffer_.max_size() - buffer_.size()));
    watch_for_hang_up(hung_up);
    HttpResponse response = co_await respond(std::move(request), hung_up.get_token());
    ++num_watches_;
    boost::system::error_code ignored;
    lowest_.socket().cancel(ignored);  // Ends the watch for a hang-up.
    co_return response;
  }

  // Resumes on this strand, because the Api may reply on any of its threads.
  asio::awaitable<HttpResponse> respond(HttpRequest request, std::stop_token stop) {
    auto initiate = [this, request = std::move(request), stop = std::move(stop)](auto handler) mutable {
      auto shared = std::make_shared<decltype(handler)>(std::move(handler));
      // Counts as work until the last copy is gone: another thread may drop its copy after the response was sent, and
      // the server must not end before.
      const auto done = [executor = asio::prefer(executor_, asio::execution::outstanding_work.tracked),
                         shared](HttpResponse response) {
        asio::post(executor, [shared, response = std::move(response)]() mutable { (*shared)(std::move(response)); });
      };
      try {
        context_.router.respond(std::move(request), done, stop);
      } catch (const std::exception& error) {
        // Replies, because the exception must not leave this function: the handler already owns the coroutine's frame.
        done(refusal(internal_error("INTERNAL", error.what())));
      }
    };
    return asio::async_initiate<const asio::use_awaitable_t<>, void(HttpResponse)>(std::move(initiate),
                                                                                   asio::use_awaitable);
  }

  // Requests a stop when the client closes the connection, or its half of it, during a request. A client that has
  // already sent its next request is not watched, because the end of the connection comes after that.
  void watch_for_hang_up(std::stop_source hung_up) {
    lowest_.socket().async_wait(asio::ip::tcp::socket::wait_read,
                                [self = this->shared_from_this(), watch = num_watches_,
                                 hung_up = std::move(hung_up)](boost::system::error_code error) mutable {
                                  if (error || self->num_watches_ != watch) return;
                                  self->look_for_hang_up(std::move(hung_up));
                                });
  }

  // Reads what has come, without waiting. A part of a TLS record is taken out of the socket, too, so that the socket is
  // not found readable for ever.
  void look_for_hang_up(std::stop_source hung_up) {
    boost::system::error_code error;
    buffer_.commit(stream_.read_some(overtaking_, error));
    if (error == asio::error::would_block) {
      watch_for_hang_up(std::move(hung_up));
    } else if (error) {
      hung_up.request_stop();
    }
  }

  // Requests a stop when the client of a stream closes the connection, or its half of it. The stream is the last
  // request of its connection. Further input is discarded, so that it does not hide the end.
  void drop_input(std::stop_source hung_up) {
    stream_.async_read_some(asio::buffer(dropped_), [self = this->shared_from_this(), hung_up](
                                                        boost::system::error_code error, std::size_t) mutable {
      if (error) {
        hung_up.request_stop();
      } else {
        self->drop_input(std::move(hung_up));
      }
    });
  }

  asio::awaitable<bool> write(HttpResponse response, Framing framing) {
    context_.router.share_with_origin(origin_, response.headers);
    const bool written = co_await write_response(stream_, context_, response, framing);
    co_return written;
  }

  // Ends this side, and reads the rest of the input. Closing a socket with unread bytes resets it, and the reset may
  // overtake the response.
  asio::awaitable<void> discard_rest() {
    co_await end_tls();
    boost::system::error_code error;
    lowest_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
    lowest_.expires_after(kFarewell);
    for (std::size_t discarded = 0; !error && discarded < (std::size_t{8} << 20);) {
      buffer_.clear();
      discarded += co_await lowest_.async_read_some(buffer_.prepare(std::size_t{64} << 10),
                                                    asio::redirect_error(asio::use_awaitable, error));
    }
  }

  // Says to the client that nothing more comes, so that it knows the response to be whole. Then waits for its answer,
  // both together for at most kFarewell.
  asio::awaitable<void> end_tls() {
    if constexpr (kIsTls<Stream>) {
      if (std::exchange(has_ended_tls_, true)) co_return;
      // A timer of its own, because drop_input() may be reading without a limit.
      farewell_.expires_after(kFarewell);
      farewell_.async_wait([weak = this->weak_from_this()](const boost::system::error_code& cancelled) {
        const std::shared_ptr<HttpConnection> self = cancelled ? nullptr : weak.lock();
        if (self) self->lowest_.close();
      });
      boost::system::error_code ignored;
      co_await stream_.async_shutdown(asio::redirect_error(asio::use_awaitable, ignored));
    }
    co_return;
  }

  HttpRequest from_peer(HttpRequest request) const {
    request.peer = context_.router.address_of(peer_, request.forwarded_for);
    return request;
  }

  ConnectionContext& context_;
  Stream stream_;
  PlainStream& lowest_;                           // The lowest layer of stream_.
  const PlainStream::executor_type executor_;     // A strand.
  const std::string peer_;                        // Its address; empty: it is gone already.
  beast::flat_buffer buffer_;                     // Bounded: the parser's limits do not cover extensions of chunks.
  asio::mutable_buffer overtaking_;               // Room in buffer_, during a request; see look_for_hang_up().
  std::array<char, 4096> dropped_{};              // See drop_input().
  std::shared_ptr<SocketStream<Stream>> socket_;  // Set once upgraded.
  asio::steady_timer farewell_;                   // See end_tls().
  int num_watches_ = 0;                           // Watches for a hang-up that have ended.
  std::string origin_;                            // Origin of the request in progress.
  bool first_ = true;
  bool idle_ = false;
  bool finishing_ = false;
  bool has_ended_tls_ = false;
};

}  // namespace

std::shared_ptr<Connection> make_connection(ConnectionContext& context, asio::ip::tcp::socket socket,
                                            const std::shared_ptr<TlsContext>& tls) {
  PlainStream plain(std::move(socket));
  if (!tls) return std::make_shared<HttpConnection<PlainStream>>(context, std::move(plain));
  return std::make_shared<HttpConnection<TlsStream>>(context, TlsStream(std::move(plain), tls->native()));
}

}  // namespace kerf::ws
