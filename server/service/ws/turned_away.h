#pragma once

#include <atomic>
#include <memory>
#include <string>

#include <boost/asio/ip/tcp.hpp>

namespace kerf::ws {

// Answers connections that are not admitted, without waiting for their requests: 503 with Retry-After and the error
// TOO_MANY_CONNECTIONS as JSON. Must outlive them. Thread-safe.
class TurnedAway {
 public:
  // The error names the limit, `most_per_address`.
  explicit TurnedAway(int most_per_address);

  // Writes as much as the socket takes at once, then reads the request for up to a second. Otherwise a reset caused by
  // the unread request could overtake the response. Beyond a few such connections, the socket is closed at once.
  void answer(boost::asio::ip::tcp::socket socket);

 private:
  struct Lingering;
  void linger(const std::shared_ptr<Lingering>& lingering);

  const std::string response_;
  std::atomic<int> lingering_ = 0;
};

}  // namespace kerf::ws
