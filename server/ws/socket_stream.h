#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "server/api/stream_session.h"
#include "server/ws/connection.h"
#include "server/ws/wake_signal.h"

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
  boost::asio::awaitable<bool> accept(const Request& request);
  boost::asio::awaitable<void> read_messages();
  boost::asio::awaitable<void> write_messages();
  // A reader that does not take the message to come for long cannot be told, and is cut off.
  void limit_write();
  [[nodiscard]] boost::beast::websocket::close_reason closing_reason() const;

  ConnectionContext& context_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  const Router::OpenSession open_;
  WakeSignal woken_;  // of the writer
  boost::asio::steady_timer write_limit_;
  std::shared_ptr<api::StreamSession> session_;
  std::optional<boost::beast::websocket::close_reason>
      violation_;  // of the WebSocket rules of this server, by the peer
  bool reading_ = false;
  bool peer_gone_ = false;
};

}  // namespace kerf::ws
