#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "client/cpp/watcher.h"
#include "client/load/cut_tracker.h"
#include "client/load/plan.h"
#include "client/load/recorder.h"
#include "client/load/schedule.h"
#include "kerf/v1/stream.pb.h"

namespace kerf::load {

// Describes the sheet and connection of a reader.
struct Watching {
  Role role = Role::kViewer;
  std::string sheet;              // "sheets/load-0"
  std::size_t index = 0;          // Index of the sheet in the run.
  std::string address;            // HOST:PORT of the server or of a proxy before it.
  CutTracker* tracker = nullptr;  // Receives the reader's frames; may be null.
};

// Records each decoded frame of a reader. For use on one thread.
class ReaderLog {
 public:
  ReaderLog(const Plan& plan, const Watching& watching, Recorder& recorder);

  // Records a frame or picture with this `tick` and `topology_version`.
  void seen(std::int64_t tick, std::int32_t topology_version, const v1::FrameStats& stats, std::int64_t bytes,
            bool keyframe);
  // Ends reading, and counts the last frame as shown until now.
  void finish();
  // Records that the stream ended before the run did.
  void ended(const std::string& how) { recorder_.ended(watching_.role, how, joined_); }

 private:
  void shown(Nanoseconds time, std::int64_t age_us);

  const Watching watching_;
  Recorder& recorder_;
  const Nanoseconds opened_;
  ShownAge shown_;
  bool joined_ = false;
};

// Connects to the plan's server at `address`, which may be that of a proxy before it.
client::Client connect_to(const std::string& address, const Plan& plan, client::Client::Connection connection);

// options_of() returns the options of a reader's stream. hold_of() returns how long the reader holds its frame number
// `frame`, >= 1, before it takes the next; 0 if it does not hold the frame.
[[nodiscard]] client::WatchOptions options_of(const Plan& plan, Role role);
[[nodiscard]] Nanoseconds hold_of(const Plan& plan, Role role, std::int64_t frame);

// Time to wait for a connection; if there is none by then, the stream reports the failure. (gRPC 1.51 sometimes treats
// a pending connection as failed, and makes another a second later.)
inline constexpr std::chrono::seconds kConnectWithin{10};

// Watches one sheet on its own thread and connection until it is destroyed.
class Viewer {
 public:
  virtual ~Viewer() = default;
  // Requests the end without waiting, so that many can end at once; the destructor waits.
  virtual void stop() = 0;
};

// Returns a reader of frames over gRPC; kSlow and kStalled behave as in the plan and wait on `waiter`.
std::unique_ptr<Viewer> watch_frames(const Plan& plan, const Watching& watching, Recorder& recorder, Waiter& waiter);
// Returns the reader of watch_frames(), but over a WebSocket; watching.address is the HTTP address.
std::unique_ptr<Viewer> watch_frames_over_websocket(const Plan& plan, const Watching& watching, Recorder& recorder,
                                                    Waiter& waiter);
// Returns a reader of pictures (kImage).
std::unique_ptr<Viewer> watch_images(const Plan& plan, const Watching& watching, Recorder& recorder);

}  // namespace kerf::load
