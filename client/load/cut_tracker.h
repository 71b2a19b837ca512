#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "client/load/recorder.h"
#include "client/load/schedule.h"

namespace kerf::load {

// When cuts become visible: brings together the replies, which tell the tick, and the frames of one viewer for each
// watched sheet, which may come before. Thread-safe.
class CutTracker {
 public:
  explicit CutTracker(Recorder& recorder) : recorder_(recorder) {}

  // Before any frame or reply of that sheet.
  void watch(std::size_t sheet);
  // A frame was decoded.
  void frame(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds decoded);
  // Of the newest decoded frame; nothing for sheets that are not watched or have shown nothing yet.
  [[nodiscard]] std::optional<std::int64_t> newest_tick(std::size_t sheet) const;
  // A cut was applied at `tick`, after which the topology has this version; `intended`: when it should have been sent.
  void applied(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds intended);
  // Cuts that were applied and are not shown yet.
  [[nodiscard]] std::int64_t num_waiting() const;
  // The run is over: what has not been seen will not be.
  void finish();

 private:
  static constexpr std::size_t kFrames = 256;  // kept of each sheet: some seconds, longer than any reply takes

  struct Frame {
    std::int64_t tick = 0;
    std::int32_t topology_version = 0;
    Nanoseconds decoded{0};
  };
  struct Cut {
    std::int64_t tick = 0;
    std::int32_t topology_version = 0;
    Nanoseconds intended{0};
  };
  struct Sheet {
    std::deque<Frame> frames;  // oldest first
    std::vector<Cut> waiting;
  };

  void seen(const Cut& cut, const Frame& frame);

  Recorder& recorder_;
  mutable std::mutex mutex_;
  std::map<std::size_t, Sheet> sheets_;
};

}  // namespace kerf::load
