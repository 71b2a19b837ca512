#pragma once

#include <boost/asio/compose.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/websocket/teardown.hpp>

#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

namespace kerf::ws {

// Represents a rate policy of Beast's basic_stream (its RatePolicy) that does not limit rates. It stops reading on
// demand.
class StoppableReads {
 public:
  // Reads at most one byte per second from now on.
  void stop() { stopped_ = true; }

 private:
  friend class boost::beast::rate_policy_access;

  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] std::size_t available_read_bytes() const { return stopped_ ? 0 : kAll; }
  [[nodiscard]] static std::size_t available_write_bytes() { return kAll; }
  static void transfer_read_bytes(std::size_t /*bytes*/) {}
  static void transfer_write_bytes(std::size_t /*bytes*/) {}
  static void on_timer() {}

  bool stopped_ = false;
};

// Passes reads and writes on to another stream, and reports all bytes read. Above TLS these are the bytes of the
// message, without those of TLS.
template <typename Next>
class WatchedReads {
 public:
  using next_layer_type = Next;
  using executor_type = typename Next::executor_type;

  // `next` must outlive this.
  explicit WatchedReads(Next& next) : next_(next) {}

  // Sets `on_read`, called with the number of bytes of each read, on the stream's executor.
  void watch(std::function<void(std::size_t)> on_read) { on_read_ = std::move(on_read); }

  executor_type get_executor() { return next_.get_executor(); }
  Next& next_layer() { return next_; }
  const Next& next_layer() const { return next_; }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_compose<Token, void(boost::system::error_code, std::size_t)>(
        [this, buffers, begun = false](auto& self, boost::system::error_code error = {},
                                       std::size_t bytes = 0) mutable {
          if (!std::exchange(begun, true)) return next_.async_read_some(buffers, std::move(self));
          if (on_read_) on_read_(bytes);
          self.complete(error, bytes);
        },
        token, next_);
  }
  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return next_.async_write_some(buffers, std::forward<Token>(token));
  }

  // Ends the stream below, as Beast's WebSocket asks for at its end.
  template <typename Handler>
  friend void async_teardown(boost::beast::role_type role, WatchedReads& stream, Handler&& handler) {
    using boost::beast::websocket::async_teardown;
    async_teardown(role, stream.next_, std::forward<Handler>(handler));
  }

 private:
  Next& next_;
  std::function<void(std::size_t)> on_read_;
};

}  // namespace kerf::ws
