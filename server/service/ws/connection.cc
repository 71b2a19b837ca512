#include "server/service/ws/connection.h"

#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <exception>
#include <limits>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "server/service/api/upload.h"
#include "server/service/ws/mjpeg.h"
#include "server/service/ws/socket_stream.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Request = http::request<http::string_body>;
using Parser = http::request_parser<http::string_body>;

// Largest part of a request read before it is parsed.
constexpr std::size_t kMostReadAhead = std::size_t{128} << 10;

std::string header(const Request& request, http::field field) {
  const beast::string_view value = request[field];
  return {value.data(), value.size()};
}

std::string header_named(const Request& request, const char* name) {
  const beast::string_view value = request[name];
  return {value.data(), value.size()};
}

// Returns the request without its body.
HttpRequest head_of(const Request& message) {
  return {std::string(message.method_string()),
          std::string(message.target()),
          header(message, http::field::host),
          header(message, http::field::origin),
          header(message, http::field::if_none_match),
          header(message, http::field::accept_encoding),
          header(message, http::field::authorization),
          header(message, http::field::cookie),
          header_named(message, "x-kerf-csrf"),
          {},
          {}};
}

HttpRequest to_request(Request& message) {
  HttpRequest request = head_of(message);
  request.body = std::move(message.body());
  return request;
}

HttpResponse body_too_large() {
  HttpResponse response = refusal(resource_exhausted("REQUEST_TOO_LARGE",
                                                     "the request's body exceeds the limit here: send less in one "
                                                     "call; send a mesh file to POST /sheets, at most 64 MiB"));
  response.status = 413;
  return response;
}

// Returns the answer to a malformed request; nothing if the client no longer listens.
std::optional<HttpResponse> unreadable_request(const boost::system::error_code& error) {
  if (error == http::error::body_limit) return body_too_large();
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    HttpResponse response = refusal(resource_exhausted("HEADER_TOO_LARGE", "the request's header exceeds the limit"));
    response.status = 431;
    return response;
  }
  const bool silent = error == http::error::end_of_stream || error == http::error::partial_message;
  if (silent || error.category() != http::make_error_code(http::error::bad_value).category()) return std::nullopt;
  return refusal(invalid_argument("MALFORMED_REQUEST", "not HTTP/1.1: " + error.message()));
}

std::string address_of(const asio::ip::tcp::socket& socket) {
  boost::system::error_code gone;
  const asio::ip::tcp::endpoint peer = socket.remote_endpoint(gone);
  return gone ? std::string() : peer.address().to_string();
}

// Serves one connection. In coroutines here, co_await stands alone or initialises a variable, never within a condition
// or a larger expression: g++ 12 otherwise resumes the wrong frame.
class HttpConnection : public Connection, public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(ConnectionContext& context, asio::ip::tcp::socket socket)
      : context_(context),
        stream_(std::move(socket)),
        executor_(stream_.get_executor()),
        peer_(address_of(stream_.socket())),
        buffer_(context.options.max_header_bytes + kMostReadAhead) {}

  void run(std::function<void()> done) override {
    // Drops a connection that throws (out of memory) like one that fails.
    asio::co_spawn(executor_, serve(), [self = shared_from_this(), done = std::move(done)](const std::exception_ptr&) {
      self->close_now();
      done();
    });
  }

  void finish() override {
    asio::post(executor_, [self = shared_from_this()] {
      self->finishing_ = true;
      if (self->idle_) self->stream_.close();
    });
  }

  void abort() override {
    asio::post(executor_, [self = shared_from_this()] {
      self->finishing_ = true;
      self->close_now();
    });
  }

 private:
  // Holds the properties of a request that determine the framing of its response.
  struct Framing {
    unsigned version = 11;
    bool keep_alive = false;
    bool head = false;  // HEAD: length without body.
  };

  // Closes the connection. The socket of an upgraded one belongs to its stream.
  void close_now() {
    if (socket_) {
      socket_->abort();
    } else {
      stream_.close();
    }
  }

  asio::awaitable<void> serve() {
    bool more = true;
    while (more) more = co_await serve_request();
  }

  // Serves one request; returns false if it was the last one of this connection.
  asio::awaitable<bool> serve_request() {
    const bool begun = co_await request_has_begun();
    if (!begun) co_return false;
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(context_.options.max_header_bytes));
    parser.body_limit(std::numeric_limits<std::uint64_t>::max());  // Until the route is known; see read_body().
    stream_.expires_after(context_.options.request_timeout);
    boost::system::error_code error;
    co_await http::async_read_header(stream_, buffer_, parser, asio::redirect_error(asio::use_awaitable, error));
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
    Request message = parser.release();
    Framing framing{message.version(), message.keep_alive(), message.method() == http::verb::head};
    HttpRequest request = to_request(message);
    request.peer = peer_;
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
    const Router::BodyLimit limit = context_.router.body_limit(head_of(parser.get()));
    if (limit.refused) return limit.refused;
    const auto max_bytes = static_cast<std::uint64_t>(limit.max_bytes);
    const std::uint64_t announced = parser.content_length().value_or(max_bytes);
    if (announced > max_bytes) return body_too_large();
    if (limit.max_bytes > context_.api.limits().max_request_bytes) {
      Result<std::shared_ptr<const api::UploadRoom>> reserved =
          context_.api.reserve_upload(static_cast<std::int64_t>(announced));
      if (!reserved.ok()) return refusal(reserved.error());
      room = std::move(reserved).value();
      stream_.expires_after(context_.options.upload_timeout);
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
    stream_.expires_after(first ? context_.options.request_timeout : context_.options.idle_timeout);
    boost::system::error_code error;
    idle_ = true;
    const std::size_t bytes =
        co_await stream_.async_read_some(buffer_.prepare(4096), asio::redirect_error(asio::use_awaitable, error));
    idle_ = false;
    buffer_.commit(bytes);
    co_return !error;
  }

  asio::awaitable<void> upgrade(Request message) {
    const std::string subprotocols = header(message, http::field::sec_websocket_protocol);
    Router::Upgrade upgrade = context_.router.upgrade(to_request(message), subprotocols);
    if (upgrade.refused) {
      co_await write(*upgrade.refused, Framing());
      co_return;
    }
    socket_ = std::make_shared<SocketStream>(context_, std::move(stream_), std::move(upgrade.open));
    if (!finishing_) co_await socket_->run(message);
  }

  asio::awaitable<void> invite_body() {
    http::response<http::empty_body> invitation{http::status::continue_, 11};
    boost::system::error_code ignored;
    co_await http::async_write(stream_, invitation, asio::redirect_error(asio::use_awaitable, ignored));
  }

  asio::awaitable<void> play(std::shared_ptr<api::ImageSession> session) {
    stream_.expires_never();
    const std::stop_source hung_up;
    drop_input(hung_up);
    const MjpegTimes times{context_.options.write_timeout, context_.options.picture_repeat};
    const std::optional<Error> error = co_await play_mjpeg(std::move(session), stream_, times, hung_up.get_token());
    if (error && !hung_up.stop_requested()) {
      co_await write(refusal(in_words_of_query(*error)), Framing());
    } else {
      ++context_.requests;
    }
  }

  asio::awaitable<HttpResponse> answer(HttpRequest request) {
    stream_.expires_never();
    const std::stop_source hung_up;
    watch_for_hang_up(hung_up);
    HttpResponse response = co_await respond(std::move(request), hung_up.get_token());
    boost::system::error_code ignored;
    stream_.socket().cancel(ignored);  // Ends the watch for a hang-up.
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
    stream_.socket().async_wait(asio::ip::tcp::socket::wait_read, [self = shared_from_this(),
                                                                   hung_up](boost::system::error_code error) mutable {
      char next = 0;
      if (error) return;
      const ssize_t bytes = ::recv(self->stream_.socket().native_handle(), &next, 1, MSG_PEEK | MSG_DONTWAIT);
      if (bytes == 0 || (bytes < 0 && errno != EAGAIN)) hung_up.request_stop();
    });
  }

  // Requests a stop when the client of a stream closes the connection, or its half of it. The stream is the last
  // request of its connection. Further input is discarded, so that it does not hide the end.
  void drop_input(std::stop_source hung_up) {
    stream_.socket().async_read_some(asio::buffer(dropped_), [self = shared_from_this(), hung_up](
                                                                 boost::system::error_code error, std::size_t) mutable {
      if (error) {
        hung_up.request_stop();
      } else {
        self->drop_input(std::move(hung_up));
      }
    });
  }

  asio::awaitable<bool> write(const HttpResponse& response, Framing framing) {
    ++context_.requests;
    if (response.status >= 400) ++context_.failed_requests;
    const std::string_view content = response.body ? std::string_view(*response.body) : std::string_view();
    const auto status = static_cast<http::status>(response.status);
    bool written = false;
    if (framing.head || response.status == 304) {
      http::response<http::empty_body> message{status, framing.version};
      if (framing.head) message.content_length(content.size());
      written = co_await write_message(message, response, framing);
    } else {
      http::response<http::span_body<const char>> message{status, framing.version};
      message.body() = beast::span<const char>(content.data(), content.size());
      message.content_length(content.size());
      written = co_await write_message(message, response, framing);
    }
    co_return written;
  }

  template <typename Body>
  asio::awaitable<bool> write_message(http::response<Body>& message, const HttpResponse& response, Framing framing) {
    message.set(http::field::server, "kerfd");
    message.set("X-Content-Type-Options", "nosniff");
    message.set("Cross-Origin-Resource-Policy", "same-origin");
    if (!response.media_type.empty()) message.set(http::field::content_type, response.media_type);
    for (const auto& [name, value] : response.headers) message.set(name, value);
    message.keep_alive(framing.keep_alive);
    http::response_serializer<Body> serializer(message);
    const auto last = std::chrono::steady_clock::now() + context_.options.response_timeout;
    boost::system::error_code error;
    while (!error && !serializer.is_done()) {
      stream_.expires_at(std::min(last, std::chrono::steady_clock::now() + context_.options.write_timeout));
      co_await http::async_write_some(stream_, serializer, asio::redirect_error(asio::use_awaitable, error));
    }
    co_return !error;
  }

  // Reads the rest of the input. Closing a socket with unread bytes resets it, and the reset may overtake the response.
  asio::awaitable<void> discard_rest() {
    boost::system::error_code error;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
    stream_.expires_after(std::chrono::seconds(1));
    for (std::size_t discarded = 0; !error && discarded < (std::size_t{8} << 20);) {
      buffer_.clear();
      discarded += co_await stream_.async_read_some(buffer_.prepare(std::size_t{64} << 10),
                                                    asio::redirect_error(asio::use_awaitable, error));
    }
  }

  ConnectionContext& context_;
  beast::tcp_stream stream_;
  const beast::tcp_stream::executor_type executor_;  // A strand.
  const std::string peer_;                           // Its address; empty: it is gone already.
  beast::flat_buffer buffer_;                        // Bounded: the parser's limits do not cover extensions of chunks.
  std::array<char, 4096> dropped_{};                 // See drop_input().
  std::shared_ptr<SocketStream> socket_;             // Set once upgraded.
  bool first_ = true;
  bool idle_ = false;
  bool finishing_ = false;
};

}  // namespace

std::shared_ptr<Connection> make_connection(ConnectionContext& context, asio::ip::tcp::socket socket) {
  return std::make_shared<HttpConnection>(context, std::move(socket));
}

}  // namespace kerf::ws
