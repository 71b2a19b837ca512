#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "server/base/result.h"

namespace kerf::load {

// Describes a connection through the proxy.
struct Way {
  std::chrono::nanoseconds delay{0};  // Per direction, >= 0.
  double bytes_per_s = 0.0;           // Per direction of each connection; 0: no limit.
};

// Runs a TCP proxy on a free port of 127.0.0.1 that simulates a distant server. It passes bytes on in order, each after
// the delay, at most at the rate. It holds a bounded number of bytes, like a network, so that senders notice
// congestion.
class DelayingProxy {
 public:
  // Bytes held per direction of each connection while they wait to be sent. With a rate, those in transit are added:
  // rate * delay, up to kMostUnderWay.
  static constexpr std::size_t kMostHeld = std::size_t{64} << 10;
  static constexpr std::size_t kMostUnderWay = std::size_t{64} << 20;
  static constexpr std::size_t kMostHeldWide = std::size_t{4} << 20;  // Without a rate: waiting and in transit.

  // Starts a proxy. `server`: "HOST:PORT". kUnavailable if the server's host has no address or no port is free.
  static Result<std::unique_ptr<DelayingProxy>> start(const std::string& server, const Way& way);
  ~DelayingProxy();  // Ends all connections.
  DelayingProxy(const DelayingProxy&) = delete;
  DelayingProxy& operator=(const DelayingProxy&) = delete;

  [[nodiscard]] std::string address() const;  // "127.0.0.1:PORT"

 private:
  struct Impl;
  explicit DelayingProxy(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::load
