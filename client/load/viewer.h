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

// Whom and how a reader watches.
struct Watching {
  Role role = Role::kViewer;
  std::string sheet;              // "sheets/load-0"
  std::size_t index = 0;          // of that sheet
  std::string address;            // HOST:PORT, of the server or of a proxy before it
  CutTracker* tracker = nullptr;  // is told of its frames; null: is not
};

// What every reader does with a frame once it is decoded. Of one thread.
class ReaderLog {
 public:
  ReaderLog(const Plan& plan, const Watching& watching, Recorder& recorder);

  // `tick` and `topology_version`: of a frame or picture.
  void seen(std::int64_t tick, std::int32_t topology_version, const v1::FrameStats& stats, std::int64_t bytes,
            bool keyframe);
  // The reader reads no more: what it showed last it showed until now.
  void finish();
  // The stream ended before the run did.
  void ended(const std::string& how) { recorder_.ended(watching_.role, how, joined_); }

 private:
  void shown(Nanoseconds time, std::int64_t age_us);

  const Watching watching_;
  Recorder& recorder_;
  const Nanoseconds opened_;
  ShownAge shown_;
  bool joined_ = false;
};

// What a reader of frames asks for, and how long it holds its frame number `frame`, from 1; 0: not at all.
[[nodiscard]] client::WatchOptions options_of(const Plan& plan, Role role);
[[nodiscard]] Nanoseconds hold_of(const Plan& plan, Role role, std::int64_t frame);

// A connection that is not there by then is told of by the stream. (gRPC 1.51 now and then takes a connection that is
// being made for one that failed, and makes another a second later.)
inline constexpr std::chrono::seconds kConnectWithin{10};

// Watches one sheet on a thread and a connection of its own until it is destroyed.
class Viewer {
 public:
  virtual ~Viewer() = default;
  // Asks for the end; the destructor waits for it. So that many end at once.
  virtual void stop() = 0;
};

// A reader of frames over gRPC; of kSlow and kStalled as the plan has it. `waiter` is where slow and stalled ones wait.
std::unique_ptr<Viewer> watch_frames(const Plan& plan, const Watching& watching, Recorder& recorder, Waiter& waiter);
// The same over a WebSocket; watching.address is that of HTTP.
std::unique_ptr<Viewer> watch_frames_over_websocket(const Plan& plan, const Watching& watching, Recorder& recorder,
                                                    Waiter& waiter);
// A reader of pictures (kImage).
std::unique_ptr<Viewer> watch_images(const Plan& plan, const Watching& watching, Recorder& recorder);

}  // namespace kerf::load
