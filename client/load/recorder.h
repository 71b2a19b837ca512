#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "client/load/histogram.h"
#include "client/load/schedule.h"

namespace kerf::load {

enum class Role { kViewer, kSlow, kStalled, kImage };
inline constexpr std::array<Role, 4> kRoles{Role::kViewer, Role::kSlow, Role::kStalled, Role::kImage};
[[nodiscard]] const char* name_of(Role role);  // "viewers", "slow readers" ...

// Sums the observations of readers of one role.
struct ReaderTotals {
  std::int32_t readers = 0;                  // Readers that got a first frame.
  std::int64_t frames = 0;                   // Decoded frames.
  std::int64_t keyframes = 0;                // Keyframes among `frames`.
  std::int64_t bytes = 0;                    // Bytes of `frames`.
  std::int64_t skipped = 0;                  // Ticks that were not sent.
  Histogram age_us;                          // From the end of the tick until the frame is decoded, frame by frame.
  Histogram shown_us;                        // Age of the frame that a reader shows, at fixed times: see ShownAge.
  Histogram join_us;                         // From opening the stream to the first decoded frame; warm-up included.
  std::map<std::string, std::int64_t> ends;  // Reasons for streams that ended before the run did.
  std::int64_t ended_without = 0;            // Streams in `ends` that had no first frame.
};

struct CutTotals {
  std::int64_t sent = 0;
  std::int64_t applied = 0;
  std::int64_t missed = 0;        // Answered NO_INTERSECTION.
  std::int64_t undone = 0;        // Applied, then undone.
  Histogram late_us;              // From the intended time to the time of sending.
  Histogram reply_us;             // From the intended time to the reply.
  Histogram reply_ticks;          // From the newest tick of a viewer at the time of sending to the tick of the cut.
  Histogram seen_us;              // From the intended time to the first decoded frame at or after the cut's tick.
  std::int64_t seen_without = 0;  // Frames in seen_us that did not have the cut yet.
  std::int64_t unseen = 0;        // Cuts on watched sheets that have no frame in seen_us when the run ends.
};

// Counts what happens in one of kStretches equal parts of the measured time: frames that readers of role kViewer
// decode, answers to cuts that were due then, and errors.
struct Stretch {
  std::int64_t frames = 0;
  std::int64_t bytes = 0;
  Histogram age_us;
  Histogram cut_us;  // From the intended time to the reply.
  std::int64_t errors = 0;

  void merge(const Stretch& other);
};

struct FrameSeen {
  Nanoseconds decoded{0};
  std::int64_t age_us = 0;  // 0 if the clocks disagree by more than the age.
  std::int64_t bytes = 0;
  std::int64_t skipped = 0;
  bool keyframe = false;
};

// Collects all measurements of a run, from many threads. Events outside begin..end are ignored, except joins, ends and
// errors. Thread-safe.
class Recorder {
 public:
  static constexpr std::size_t kStretches = 120;

  // Counts nothing before measure() is called.
  Recorder() : stretches_(kStretches) {}
  // Makes frames decoded in begin..end count; to be called once.
  void measure(Nanoseconds begin, Nanoseconds end);

  [[nodiscard]] Nanoseconds begin() const { return begin_; }
  [[nodiscard]] Nanoseconds end() const { return end_; }
  [[nodiscard]] bool counts(Nanoseconds time) const { return time >= begin() && time < end(); }

  void joined(Role role, Nanoseconds took);
  void frame(Role role, const FrameSeen& frame);
  void shown(Role role, std::int64_t age_us);
  // Records that a stream ended early, for the reason `how`. `joined`: the reader had a first frame.
  void ended(Role role, const std::string& how, bool joined);
  void error(const std::string& reason);
  // Records the answer to a cut that was due at `intended`.
  void answered(Nanoseconds intended, std::int64_t took_us);
  // Calls `change` with the lock held.
  template <typename Change>
  void cuts(Change change) {
    const std::lock_guard lock(mutex_);
    change(cuts_);
  }

  [[nodiscard]] ReaderTotals readers(Role role) const;
  [[nodiscard]] CutTotals cut_totals() const;
  [[nodiscard]] std::vector<Stretch> stretches() const;
  [[nodiscard]] std::map<std::string, std::int64_t> errors() const;

 private:
  // Returns the part of the measured time in which `time` lies; counts(time) must be true.
  Stretch& stretch_at(Nanoseconds time);
  ReaderTotals& of(Role role) { return readers_[static_cast<std::size_t>(role)]; }

  std::atomic<Nanoseconds> begin_{Nanoseconds::max()};
  std::atomic<Nanoseconds> end_{Nanoseconds::max()};
  mutable std::mutex mutex_;
  std::array<ReaderTotals, kRoles.size()> readers_;
  CutTotals cuts_;
  std::vector<Stretch> stretches_;
  std::map<std::string, std::int64_t> errors_;  // By reason.
};

// Samples the age of the frame shown by a reader at fixed times. Between two decoded frames the first is shown and
// ages. A late frame thus counts at every one of these times, not only once.
class ShownAge {
 public:
  explicit ShownAge(Schedule times) : times_(times) {}

  // Records a decoded frame. `age`: of the frame when it was decoded. `moves`: other frames will follow, so that this
  // one ages while shown; false for a sheet that sleeps or stands still. Calls `sample(time, age_us)` for each of the
  // times until `decoded` at which the frame before was shown.
  template <typename Sample>
  void frame(Nanoseconds decoded, Nanoseconds age, bool moves, Sample sample) {
    sample_until(decoded, sample);
    decoded_ = decoded;
    age_ = age;
    moves_ = moves;
  }

  // Ends at `end`, until which the last frame was shown.
  template <typename Sample>
  void finish(Nanoseconds end, Sample sample) {
    sample_until(end, sample);
    moves_ = false;
  }

 private:
  template <typename Sample>
  void sample_until(Nanoseconds end, Sample& sample) {
    for (; times_.at(next_) <= end; ++next_) {
      const Nanoseconds time = times_.at(next_);
      if (moves_ && time >= decoded_) sample(time, microseconds(age_ + (time - decoded_)));
    }
  }

  Schedule times_;
  std::int64_t next_ = 0;
  Nanoseconds decoded_{0};
  Nanoseconds age_{0};
  bool moves_ = false;  // False before the first frame, when nothing is shown.
};

}  // namespace kerf::load
