#pragma once

#include <utility>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "server/base/token_bucket.h"
#include "server/service/api/stream_session.h"
#include "server/service/ws/connection.h"
#include "server/service/ws/http_messages.h"
#include "server/service/ws/transport.h"
#include "server/service/ws/wake_event.h"
#include "server/service/ws/watched_reads.h"

namespace kerf::ws {

// Runs a session (Watch, WatchImages) on one WebSocket. All except the ready callback runs on the socket's strand: one
// coroutine reads, one writes (at most one message at a time). The session decides the content. `Stream` is PlainStream
// or TlsStream.
template <typename Stream>
class SocketStream : public std::enable_shared_from_this<SocketStream<Stream>> {
 public:
  // `stream` must outlive this. `open`: makes the session once the opening handshake is done.
  SocketStream(ConnectionContext& context, Stream& stream, Router::OpenSession open);

  // Answers the opening handshake and serves the stream until it is closed.
  boost::asio::awaitable<void> run(const RequestMessage& request);
  // Drops the connection; on the strand.
  void abort();

 private:
  boost::asio::awaitable<bool> accept(const RequestMessage& request);
  boost::asio::awaitable<void> read_messages();
  boost::asio::awaitable<void> write_messages();
  // Drops the connection after `time`, unless write_limit_ is cancelled before.
  void abort_after(std::chrono::milliseconds time);
  void limit_frames();
  // Stops reading from a peer that has sent too many frames, and begins to close.
  void flooded(std::string_view with);
  // Allows a peer that has begun its stream to be silent until the close for being too slow reaches it.
  void allow_silence();
  [[nodiscard]] boost::beast::websocket::close_reason closing_reason() const;

  ConnectionContext& context_;
  boost::beast::websocket::stream<WatchedReads<Stream>> socket_;
  const Router::OpenSession open_;
  TokenBucket control_frames_;
  TokenBucket frame_bytes_;  // All input, without the content of messages.
  WakeEvent woken_;          // Wakes the writer.
  boost::asio::steady_timer write_limit_;
  std::shared_ptr<api::StreamSession> session_;
  // Set once the peer has violated this server's WebSocket rules.
  std::optional<boost::beast::websocket::close_reason> violation_;
  bool too_slow_ = false;  // The peer is being closed as too slow; nothing follows.
  bool reading_ = false;
  bool peer_gone_ = false;
};

}  // namespace kerf::ws
