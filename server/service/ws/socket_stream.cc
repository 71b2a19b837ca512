#include "server/service/ws/socket_stream.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/field.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <chrono>
#include <exception>
#include <string>
#include <vector>

#include "server/service/api/api.h"

namespace kerf::ws {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

// Limits on control frames; a peer that pings each frame at 60 Hz stays below.
constexpr double kControlFramesPerS = 100.0;
constexpr double kControlFramesAtOnce = 200.0;
// Limit on heads of frames, pings and pongs: some 5,000 small messages per second. The content of a message counts,
// too, until the message is complete.
constexpr double kFrameBytesPerS = 32.0 * 1024.0;
constexpr std::chrono::seconds kFloodFarewell{1};
// RFC 6455, 5.5: a control frame holds 125 bytes, 2 of them the code.
constexpr std::size_t kMaxCloseReasonBytes = 123;

// Cuts a text to the size of a close frame, at the start of a UTF-8 sequence.
std::string close_text(std::string text) {
  if (text.size() <= kMaxCloseReasonBytes) return text;
  std::size_t end = kMaxCloseReasonBytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  text.resize(end);
  return text;
}

TokenBucket::Time now() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

}  // namespace

template <typename Stream>
SocketStream<Stream>::SocketStream(ConnectionContext& context, Stream& stream, Router::OpenSession open)
    : context_(context),
      socket_(stream),
      open_(std::move(open)),
      control_frames_(kControlFramesPerS, kControlFramesAtOnce, now()),
      frame_bytes_(kFrameBytesPerS, 2.0 * static_cast<double>(context.options.max_message_bytes), now()),
      woken_(socket_.get_executor()),
      write_limit_(socket_.get_executor()) {
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = context.options.handshake_timeout;
  timeout.idle_timeout = context.options.silence_timeout;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  websocket::permessage_deflate deflate;
  deflate.server_enable = false;  // Frames are compressed already.
  socket_.set_option(deflate);
  socket_.auto_fragment(false);
  socket_.binary(true);
  socket_.read_message_max(context.options.max_message_bytes);
}

template <typename Stream>
asio::awaitable<bool> SocketStream<Stream>::accept(const RequestMessage& request) {
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(beast::http::field::sec_websocket_protocol, "kerf.v1");
    response.set(beast::http::field::server, "kerfd");
  }));
  beast::get_lowest_layer(socket_).expires_never();  // The WebSocket layer has timeouts of its own.
  boost::system::error_code error;
  co_await socket_.async_accept(request, asio::redirect_error(asio::use_awaitable, error));
  co_return !error;
}

template <typename Stream>
asio::awaitable<void> SocketStream<Stream>::run(const RequestMessage& request) {
  const std::shared_ptr<SocketStream> self = this->shared_from_this();
  const bool accepted = co_await accept(request);
  if (!accepted) co_return;
  ++context_.watch_streams;
  ++context_.open_watch_streams;
  limit_frames();
  session_ = open_();
  session_->set_wake([weak = this->weak_from_this(), executor = socket_.get_executor()] {
    asio::post(executor, [weak] {
      if (const std::shared_ptr<SocketStream> stream = weak.lock()) stream->woken_.raise();
    });
  });
  reading_ = true;
  asio::co_spawn(socket_.get_executor(), read_messages(), [self](const std::exception_ptr&) {
    self->reading_ = false;
    self->woken_.raise();
  });
  co_await write_messages();
  session_->set_wake({});
  const websocket::close_reason reason = closing_reason();
  session_->close();
  if (violation_) abort_after(kFloodFarewell);
  boost::system::error_code ignored;
  co_await socket_.async_close(reason, asio::redirect_error(asio::use_awaitable, ignored));
  abort();  // Releases the reader if the closing handshake was not answered.
  while (reading_) co_await woken_.wait();
  --context_.open_watch_streams;
}

template <typename Stream>
void SocketStream<Stream>::abort() {
  beast::get_lowest_layer(socket_).close();
}

template <typename Stream>
asio::awaitable<void> SocketStream<Stream>::read_messages() {
  beast::flat_buffer buffer;
  while (!session_->ended()) {
    boost::system::error_code error;
    co_await socket_.async_read(buffer, asio::redirect_error(asio::use_awaitable, error));
    if (error) {
      peer_gone_ = true;
      co_return;
    }
    if (!socket_.got_binary()) {
      violation_.emplace(websocket::close_code::unknown_data, "messages must be binary, each one serialised request");
      co_return;
    }
    frame_bytes_.give_back(static_cast<double>(buffer.size()));
    allow_silence();
    session_->on_bytes({static_cast<const char*>(buffer.cdata().data()), buffer.size()});
    buffer.consume(buffer.size());
  }
}

template <typename Stream>
asio::awaitable<void> SocketStream<Stream>::write_messages() {
  while (!peer_gone_ && !violation_) {
    // Read before the queue is emptied: once the session has ended, no message is added.
    const bool ended = session_->ended();
    while (const std::optional<stream::Message> message = session_->next()) {
      std::vector<asio::const_buffer> parts;
      for (const stream::Bytes& part : message->parts) parts.emplace_back(part->data(), part->size());
      boost::system::error_code error;
      too_slow_ = message->says_too_slow;
      abort_after(context_.api.limits().stream_write_timeout());
      co_await socket_.async_write(parts, asio::redirect_error(asio::use_awaitable, error));
      write_limit_.cancel();
      if (error) co_return;
    }
    if (ended) co_return;
    // Does not wait after the session has ended, since no wake-up follows.
    if (!session_->ended()) co_await woken_.wait();
  }
}

template <typename Stream>
void SocketStream<Stream>::abort_after(std::chrono::milliseconds time) {
  write_limit_.expires_after(time);
  write_limit_.async_wait([weak = this->weak_from_this()](const boost::system::error_code& cancelled) {
    const std::shared_ptr<SocketStream> stream = cancelled ? nullptr : weak.lock();
    if (stream) stream->abort();
  });
}

// Counts all bytes, since empty fragments and tiny messages are visible only as bytes.
template <typename Stream>
void SocketStream<Stream>::limit_frames() {
  socket_.next_layer().watch([this](std::size_t bytes) {
    const bool is_within = frame_bytes_.take(static_cast<double>(bytes), now());
    if (!is_within) flooded("messages and fragments");
  });
  socket_.control_callback([this](websocket::frame_type /*kind*/, beast::string_view /*payload*/) {
    if (!control_frames_.take(1.0, now())) flooded("pings and pongs");
  });
}

template <typename Stream>
void SocketStream<Stream>::flooded(std::string_view with) {
  if (violation_) return;
  violation_.emplace(websocket::close_code::policy_error,
                     "TOO_MANY_FRAMES: more " + std::string(with) + " than are accepted in a second");
  beast::get_lowest_layer(socket_).rate_policy().stop();
  abort_after(kFloodFarewell);  // Also ends a message that the peer does not read.
  woken_.raise();
}

// Disables the ping timeout, because a stalled reader answers no ping. Its stream ends by missing acknowledgements,
// with a reason sent to the peer.
template <typename Stream>
void SocketStream<Stream>::allow_silence() {
  const api::Limits& limits = context_.api.limits();
  websocket::stream_base::timeout timeout{};
  socket_.get_option(timeout);
  timeout.idle_timeout = std::max<std::chrono::steady_clock::duration>(
      context_.options.silence_timeout, 2 * limits.stream_write_timeout() - limits.watch_ack_timeout);
  socket_.set_option(timeout);
}

template <typename Stream>
websocket::close_reason SocketStream<Stream>::closing_reason() const {
  if (violation_) return *violation_;
  if (const std::optional<Error> failure = session_->failure()) {
    return {websocket::close_code::policy_error, close_text(failure->reason + ": " + failure->message)};
  }
  if (too_slow_) return {websocket::close_code::try_again_later, "TOO_SLOW: frames were not acknowledged in time"};
  return context_.draining ? websocket::close_code::going_away : websocket::close_code::normal;
}

template class SocketStream<PlainStream>;
template class SocketStream<TlsStream>;

}  // namespace kerf::ws
