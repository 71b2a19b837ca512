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

// Measures when cuts become visible. It combines the replies, which name the tick, with the frames of one viewer for
// each watched sheet; frames may come first. Thread-safe.
class CutTracker {
 public:
  explicit CutTracker(Recorder& recorder) : recorder_(recorder) {}

  // Starts watching a sheet; to be called before any frame or reply of it.
  void watch(std::size_t sheet);
  // Stops watching a sheet; cuts that no frame has shown yet are left out.
  void unwatch(std::size_t sheet);
  // Records a decoded frame.
  void frame(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds decoded);
  // Returns the tick of the newest decoded frame; nothing for sheets that are not watched or have shown nothing yet.
  [[nodiscard]] std::optional<std::int64_t> newest_tick(std::size_t sheet) const;
  // Records a cut applied at `tick`, after which the topology has this version. `intended`: time at which the cut
  // should have been sent.
  void applied(std::size_t sheet, std::int64_t tick, std::int32_t topology_version, Nanoseconds intended);
  // Returns the number of applied cuts that no decoded frame has shown yet.
  [[nodiscard]] std::int64_t num_waiting() const;
  // Ends the run; cuts not seen yet count as unseen.
  void finish();

 private:
  static constexpr std::size_t kFrames = 256;  // Newest frames kept per sheet: some seconds of them.

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
    std::deque<Frame> frames;  // Oldest first.
    std::vector<Cut> waiting;
  };

  void seen(const Cut& cut, const Frame& frame);

  Recorder& recorder_;
  mutable std::mutex mutex_;
  std::map<std::size_t, Sheet> sheets_;
};

}  // namespace kerf::load
