#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "server/base/result.h"

namespace kerf::load {

// What a connection through the proxy is like.
struct Way {
  std::chrono::nanoseconds delay{0};  // of each direction, >= 0
  double bytes_per_s = 0.0;           // of each direction of each connection; 0: no limit
};

// A TCP proxy on a free port of 127.0.0.1 that makes a server as far away as is wanted. Passes bytes on in order, each
// after the delay, at no more than the rate; what it holds is bounded, as in a network, so that a sender finds out.
class DelayingProxy {
 public:
  // Bytes of each direction of each connection. Where there is a rate, those that are under way, rate * delay up to
  // kMostUnderWay, come on top of those that wait to be sent.
  static constexpr std::size_t kMostHeld = std::size_t{64} << 10;
  static constexpr std::size_t kMostUnderWay = std::size_t{64} << 20;
  static constexpr std::size_t kMostHeldWide = std::size_t{4} << 20;  // where there is none, all together

  // `server`: "HOST:PORT". kUnavailable where it has no address or no port is free.
  static Result<std::unique_ptr<DelayingProxy>> start(const std::string& server, const Way& way);
  ~DelayingProxy();  // ends all connections
  DelayingProxy(const DelayingProxy&) = delete;
  DelayingProxy& operator=(const DelayingProxy&) = delete;

  [[nodiscard]] std::string address() const;  // "127.0.0.1:PORT"

 private:
  struct Impl;
  explicit DelayingProxy(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf::load
