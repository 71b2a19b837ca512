#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/cpp/live_stream.h"
#include "client/cpp/mirror.h"

namespace kerf::client {

struct WatchOptions {
  std::int32_t window = 0;   // frames in flight, 1..8; 0: what way and reader want
  double max_rate_hz = 0.0;  // 0: every tick
  v1::Encoding encoding = v1::COMPACT;
  bool strains = false;  // Mirror::strain() has them then
  // The server ends a stream whose frames are not acknowledged for 10 s, because on_frame takes so long, as TOO_SLOW.
  // Then, and for reopening.when_lost where the server is lost, it is opened again, and on_frame sees nothing of that
  // but a keyframe; of a server that was started anew its ticks count anew. Else run() ends.
  Reopening reopening = {};
};

// The first message of a stream of `name` ("sheets/demo").
[[nodiscard]] v1::WatchRequest start_of_watch(const std::string& name, const WatchOptions& options);
// That the frame of this sequence number, and all before it, are applied; `arrived`: when it came, by this clock.
[[nodiscard]] v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived);
// Applies a frame to the mirror: DATA_LOSS where it does not fit, else nothing.
[[nodiscard]] std::optional<grpc::Status> misfit(Mirror& mirror, const v1::Frame& frame);

// Watches one sheet: reads frames, keeps a Mirror, acknowledges. Blocks the thread that calls run().
class Watcher {
 public:
  // Called after each applied frame; return false to stop.
  using OnFrame = std::function<bool(const v1::Frame& frame, const Mirror& mirror)>;

  explicit Watcher(Client& client) : client_(client) {}  // for one run()

  // Watches `name` ("sheets/demo") until on_frame says stop, stop() is called, the server ends the stream, or it fails.
  // OK in the first three cases; DATA_LOSS if a frame does not fit the mirror. The server is told how long on_frame
  // took, so that a slow one is given newer frames, not queued ones.
  grpc::Status run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame);

  // From any thread: how often frames come from now on; max_rate_hz as in WatchOptions. While paused none come.
  void set_pace(double max_rate_hz, bool paused = false);
  // From any thread, also from a signal handler's aid: ends run().
  void stop() { stream_.stop(); }

  // Why the server ended the stream, if it did.
  [[nodiscard]] const v1::Ended& ended() const { return stream_.ended(); }

 private:
  Client& client_;
  LiveStream<v1::WatchRequest, v1::WatchResponse> stream_;
};

}  // namespace kerf::client
