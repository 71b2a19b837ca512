#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include <grpcpp/client_context.h>

#include "client/cpp/client.h"
#include "client/cpp/mirror.h"

namespace kerf::client {

struct WatchOptions {
  std::int32_t window = 0;   // frames in flight, 1..8; 0: what way and reader want
  double max_rate_hz = 0.0;  // 0: every tick
  v1::Encoding encoding = v1::COMPACT;
};

// The first message of a stream of `name` ("sheets/demo").
[[nodiscard]] v1::WatchRequest start_of_watch(const std::string& name, const WatchOptions& options);
// That the frame of this sequence number, and all before it, are applied; `arrived`: when it came, by this clock.
[[nodiscard]] v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived);

// Watches one sheet: reads frames, keeps a Mirror, acknowledges. Blocks the thread that calls run().
class Watcher {
 public:
  // Called after each applied frame; return false to stop.
  using OnFrame = std::function<bool(const v1::Frame& frame, const Mirror& mirror)>;

  explicit Watcher(Client& client) : client_(client) {}

  // Watches `name` ("sheets/demo") until on_frame says stop, stop() is called, the server ends the stream, or it fails.
  // OK in the first three cases; DATA_LOSS if a frame does not fit the mirror. The server is told how long on_frame
  // took, so that a slow one is given newer frames, not queued ones.
  grpc::Status run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame);

  // From any thread, also from a signal handler's aid: ends run().
  void stop();

  // Why the server ended the stream, if it did.
  [[nodiscard]] const v1::Ended& ended() const { return ended_; }

 private:
  Client& client_;
  grpc::ClientContext context_;
  std::atomic<bool> stopped_{false};
  v1::Ended ended_;
};

}  // namespace kerf::client
