#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "server/service/api/stream_session.h"
#include "server/service/ws/connection.h"
#include "server/service/ws/token_bucket.h"
#include "server/service/ws/wake_signal.h"
#include "server/service/ws/watched_reads.h"

namespace kerf::ws {

// A session (Watch, WatchImages) on one WebSocket. All but the ready callback runs on the socket's strand: one
// coroutine reads, one writes (at most one message at a time), the session decides what.
class SocketStream : public std::enable_shared_from_this<SocketStream> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  // `open`: makes the session, once the opening handshake is done.
  SocketStream(ConnectionContext& context, boost::beast::tcp_stream stream, Router::OpenSession open);

  // Answers the opening handshake and serves the stream until it is closed.
  boost::asio::awaitable<void> run(const Request& request);
  // On the strand: drops the connection.
  void abort();

 private:
  using Transport =
      boost::beast::basic_stream<boost::asio::ip::tcp, boost::beast::tcp_stream::executor_type, WatchedReads>;

  boost::asio::awaitable<bool> accept(const Request& request);
  boost::asio::awaitable<void> read_messages();
  boost::asio::awaitable<void> write_messages();
  // Drops the connection then, unless write_limit_ is cancelled before.
  void abort_after(std::chrono::milliseconds time);
  void limit_frames();
  // Stops reading from a peer that has sent too many frames, and begins to close.
  void flooded(std::string_view with);
  // Lets a peer that has begun its stream be silent until it hears that it is too slow.
  void allow_silence();
  [[nodiscard]] boost::beast::websocket::close_reason closing_reason() const;

  ConnectionContext& context_;
  boost::beast::websocket::stream<Transport> socket_;
  const Router::OpenSession open_;
  TokenBucket control_frames_;
  TokenBucket frame_bytes_;  // all that comes, less what messages hold
  WakeSignal woken_;         // of the writer
  boost::asio::steady_timer write_limit_;
  std::shared_ptr<api::StreamSession> session_;
  std::optional<boost::beast::websocket::close_reason>
      violation_;          // of the WebSocket rules of this server, by the peer
  bool too_slow_ = false;  // the peer hears so, and nothing follows
  bool reading_ = false;
  bool peer_gone_ = false;
};

}  // namespace kerf::ws
