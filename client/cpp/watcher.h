#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <grpcpp/support/status.h>

#include "client/cpp/client.h"
#include "client/cpp/live_stream.h"
#include "client/cpp/mirror.h"

namespace kerf::client {

struct WatchOptions {
  std::int32_t window = 0;   // Frames sent and not acknowledged, 1..8; 0: adapts to connection and reader.
  double max_rate_hz = 0.0;  // 0: every tick
  v1::Encoding encoding = v1::COMPACT;
  bool strains = false;  // Fills Mirror::strain().
  // Measured on the sheet of each frame, see Mirror::probe_values(); at most 64.
  std::vector<v1::Probe> probes = {};
  // Controls when an ended stream is reopened; otherwise run() ends. The server ends a stream as TOO_SLOW if on_frame
  // takes so long that frames are not acknowledged for 10 s. A reopened stream begins with a keyframe; if the server
  // was restarted, its ticks begin again.
  Reopening reopening = {};
};

// Returns the first message of a stream of `name` ("sheets/demo").
[[nodiscard]] v1::WatchRequest start_of_watch(const std::string& name, const WatchOptions& options);
// Returns the acknowledgement of the frame with this sequence number and all before it. `arrived`: its time of arrival
// on this clock.
[[nodiscard]] v1::WatchRequest acknowledgement(std::int64_t sequence, std::chrono::steady_clock::time_point arrived);
// Applies a frame to the mirror; returns DATA_LOSS if the frame does not fit, else nothing.
[[nodiscard]] std::optional<grpc::Status> misfit(Mirror& mirror, const v1::Frame& frame);

// Watches one sheet: reads frames, keeps a Mirror, acknowledges. Blocks the thread that calls run().
class Watcher {
 public:
  // Called after each applied frame; return false to stop.
  using OnFrame = std::function<bool(const v1::Frame& frame, const Mirror& mirror)>;

  explicit Watcher(Client& client) : client_(client) {}  // Allows one run().

  // Watches `name` ("sheets/demo") until on_frame returns false, stop() is called, the server ends the stream, or the
  // stream fails. OK in the first three cases; DATA_LOSS if a frame does not fit the mirror. The server learns how long
  // on_frame takes: a slow one gets fewer frames, each the newest, instead of a queue.
  grpc::Status run(const std::string& name, const WatchOptions& options, const OnFrame& on_frame);

  // Sets the frame rate from now on, from any thread; max_rate_hz as in WatchOptions. While paused no frames come.
  void set_pace(double max_rate_hz, bool paused = false);
  // Ends run(); callable from any thread, but not directly from a signal handler.
  void stop() { stream_.stop(); }

  // Returns the reason why the server ended the stream, if it did.
  [[nodiscard]] const v1::Ended& ended() const { return stream_.ended(); }

 private:
  Client& client_;
  LiveStream<v1::WatchRequest, v1::WatchResponse> stream_;
};

}  // namespace kerf::client
