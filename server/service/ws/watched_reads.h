#pragma once

#include <cstddef>
#include <functional>
#include <limits>

#include <boost/beast/core/rate_policy.hpp>

namespace kerf::ws {

// Represents a rate policy of Beast's basic_stream (its RatePolicy) that does not limit rates. It reports all bytes
// read, and stops reading on demand.
class WatchedReads {
 public:
  // Sets `on_read`, called with the number of bytes of each read, on the stream's executor.
  void watch(std::function<void(std::size_t)> on_read) { on_read_ = std::move(on_read); }
  // Reads at most one byte per second from now on.
  void stop() { stopped_ = true; }

 private:
  friend class boost::beast::rate_policy_access;

  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] std::size_t available_read_bytes() const { return stopped_ ? 0 : kAll; }
  [[nodiscard]] static std::size_t available_write_bytes() { return kAll; }
  void transfer_read_bytes(std::size_t bytes) const {
    if (on_read_) on_read_(bytes);
  }
  static void transfer_write_bytes(std::size_t /*bytes*/) {}
  static void on_timer() {}

  std::function<void(std::size_t)> on_read_;
  bool stopped_ = false;
};

}  // namespace kerf::ws
